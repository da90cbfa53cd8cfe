"""Search for a robustness certificate: cells of the parameter box with Lyapunov matrices.

A cell is a rectangle of rates; its Lyapunov matrices are linear in K/J and rounded to short
integers. This search proves nothing: a cell is kept only if the proof of
verify/certificate_proof.py succeeds with the rounded matrices, for the bound that is stored.

The matrices come from lmi/certificate_search.py. The bound is the worst norm in a scan of the box,
raised by the smallest of SLACKS for which MOST_CELLS cells are enough. The coordinates are chosen
so that the Lyapunov matrix of the plant in the middle is the identity. The matrices of the cells
are then near the identity, and few bits are enough.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from scipy import linalg

from frictool.adapters.state_space import read_state_space
from frictool.documents.certificate import Bound, Box, Cell, Certificate, CertifiedWeights, Filter
from frictool.errors import NoSolutionError
from frictool.lmi.certificate_search import lyapunov_ends
from frictool.plant.generalised_plant import FirstOrderWeight, PlantWeights, generalised_plant
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import largest
from frictool.typing import Matrix
from frictool.verify.certificate_box import Interval, inverse_inertia, surroundings
from frictool.verify.certificate_loop import CertificateLoop
from frictool.verify.certificate_proof import (
    CertificateCoordinates,
    enclose_loop,
    failing_inequality,
    pack_matrix,
    quantity_loop,
)
from frictool.verify.enclosed_axis import CONTROL_POINTS
from frictool.verify.feedback_loops import chain
from frictool.verify.interval_arithmetic import ONE, Enclosure
from frictool.verify.loop_figures import weights_of
from frictool.verify.speed_loop import performance

Rectangle = tuple[Interval, Interval]
SLACKS = (0.01, 0.03, 0.10)
MOST_CELLS = 64
MOST_HALVINGS = 2 * MOST_CELLS
BITS_KEPT = 22
SCANNED = 3  # values of each parameter in the scan of the box
NEGLIGIBLE = (
    1e-9  # of the largest Hankel singular value; smaller ones are scaled as if they had this value
)
# relative margin of the cells beyond the box, so that an exactly known parameter has cells too
ROOM = 1e-9


def certify(loop: CertificateLoop, box: Box) -> Certificate:
    """Return certified bounds of the loop's norm and largest sensitivity over the box.

    A bound that could not be proved is replaced by the reason. Raises NoSolutionError if the scan
    meets an unstable loop in the box. The work is limited by the number of cells, not by time, so
    that the same inputs give the same certificate.
    """
    quantities: tuple[Literal["norm", "sensitivity"], ...] = ("norm", "sensitivity")
    certified = {of: _bound(quantity_loop(loop, of), box, of) for of in quantities}
    bounds = tuple(bound for bound in certified.values() if isinstance(bound, Bound))
    return Certificate(
        1,
        box,
        loop.weights,
        bounds,
        {of: reason for of, reason in certified.items() if isinstance(reason, str)},
    )


def certified_weights(weights: PlantWeights) -> CertifiedWeights:
    """Return the weights of a design in the form that a certificate stores."""

    def stored(weight: FirstOrderWeight) -> Filter:
        return Filter(
            weight.gain,
            *(value if np.isfinite(value) else None for value in (weight.zero, weight.pole)),
        )

    noise = stored(weights.noise)
    return CertifiedWeights(
        stored(weights.error),
        weights.disturbance,
        weights.drive,
        weights.command,
        noise,
        weights.eta,
    )


def _bound(loop: CertificateLoop, box: Box, of: Literal["norm", "sensitivity"]) -> Bound | str:
    """Return a bound of the quantity `of` with its proof, or the reason why there is no proof."""
    worst, where = _scan(loop, box)
    if not np.isfinite(worst):
        raise NoSolutionError(
            f"not verified: the sampled loop is unstable at inertia {where.inertia:.4g}, viscous "
            f"{where.viscous:.4g}, "
            f"constant {where.constant:.4g}; relax the weights"
        )
    try:
        factor = _factor(loop, box, (1.0 + SLACKS[0]) * worst)
    except NoSolutionError as error:
        return str(error)
    rows = tuple(tuple(float(value) for value in row[k:]) for k, row in enumerate(factor))
    for slack in SLACKS:
        below = float(f"{(1.0 + slack) * worst:.4g}")
        cells = _CellSearch(loop, box, CertificateCoordinates.of(rows), below).cells()
        if cells is not None:
            return Bound(of, below, BITS_KEPT, rows, cells)
    return (
        f"{of} < {below:.4g} needs more than {MOST_CELLS} cells, although the largest value found "
        f"is {worst:.4g}; narrower intervals of the model or of the bench need fewer cells"
    )


def _scan(loop: CertificateLoop, box: Box) -> tuple[float, PlantPoint]:
    """Return the largest norm on a grid over the box, corners included, and its plant."""
    k = (
        chain(loop.sections, loop.period)
        if loop.sections
        else read_state_space(loop.controller, loop.period)
    )
    ends = (box.inertia, box.viscous, box.constant)
    coulomb = max(abs(end) for end in box.coulomb)
    intervals = []
    for j, sigma, constant in itertools.product(
        *(np.unique(np.linspace(low, high, SCANNED)) for low, high in ends)
    ):
        point = PlantPoint("", float(j), float(sigma), coulomb, float(constant))
        plant = generalised_plant(
            loop.controlled,
            point.rates,
            loop.lag,
            weights_of(loop.weights),
            loop.period,
            loop.delay,
        )
        intervals.append((performance(k, plant), point))
    worst, at = largest(value for value, _ in intervals)
    return worst, intervals[at][1]


def _numbers(enclosure: Enclosure) -> Matrix:
    return np.asarray((enclosure.centre / ONE).astype(np.float64))


def _factor(loop: CertificateLoop, box: Box, below: float) -> Matrix:
    """Return W, upper triangular; W' W solves the bounded-real inequality at mid-box."""
    drive, viscous = (_narrow((low + high) / 2) for low, high in surroundings(box))
    n = len(loop.states)
    unscaled = CertificateCoordinates.of(
        [[float(column == row) for column in range(row, n)] for row in range(n)]
    )
    whole = _numbers(enclose_loop(loop, box, (drive, viscous), unscaled)[0])
    t = _balancing(whole[:n, :n], whole[:n, n:], whole[n:, :n])
    inside = (
        linalg.block_diag(np.linalg.inv(t), np.eye(len(whole) - n))
        @ whole
        @ linalg.block_diag(t, np.eye(whole.shape[1] - n))
    )
    least, low, high = lyapunov_ends([inside], [inside], n, below)
    if least <= 0.0:
        raise NoSolutionError(
            f"no matrix is found for the plant in the middle of the intervals, at {below:.4g}"
        )
    root = linalg.cholesky(0.5 * (low + high)) @ np.linalg.inv(t)
    return np.asarray(linalg.qr(root, mode="r")[0])


def _narrow(value: Fraction) -> Interval:
    near = Fraction(float(value))
    return near, near


def _balancing(a: Matrix, b: Matrix, c: Matrix) -> Matrix:
    """Return t for which (t^-1 a t, t^-1 b, c t) has equal diagonal Gramians.

    All states are kept. Nearly unreachable or unobservable ones are scaled as if their Hankel
    singular value were NEGLIGIBLE times the largest.
    """
    root_reach = _root(linalg.solve_discrete_lyapunov(a, b @ b.T, method="bilinear"))
    root_see = _root(linalg.solve_discrete_lyapunov(a.T, c.T @ c, method="bilinear"))
    _, hankel, v = np.linalg.svd(root_see.T @ root_reach)
    return np.asarray(root_reach @ v.T * np.maximum(hankel, NEGLIGIBLE * hankel[0]) ** -0.5)


def _root(gramian: Matrix) -> Matrix:
    """Return a square root of full rank; eigenvalues are raised to 1e-14 times the largest."""
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 1e-14 * values[-1])))


@dataclass(frozen=True)
class _TriedCell:
    """A rectangle of rates after one attempt to prove the bound there.

    `least` is the margin by which the matrices satisfy the inequalities. `cell` is None if the
    proof failed. `empty` marks a rectangle that contains no plant of the box.
    """

    rates: Rectangle
    least: float
    cell: Cell | None = None
    empty: bool = False


class _CellSearch:
    """Search for the cells of one bound; rectangles without a proof are halved."""

    def __init__(
        self, loop: CertificateLoop, box: Box, coordinates: CertificateCoordinates, below: float
    ) -> None:
        self.loop = loop
        self.box = box
        self.coordinates = coordinates
        self.below = below
        drive, viscous = surroundings(box)
        self.whole = (_outward(drive), _outward(viscous))

    def cells(self) -> tuple[Cell, ...] | None:
        """Return the cells, or None if more than MOST_CELLS or MOST_HALVINGS would be needed.

        The number of halvings has its own limit, because halves without a plant give no cell.
        """
        waiting = [self._tried(self.whole)]
        accepted: list[Cell] = []
        halvings = 0
        while waiting:
            tried = waiting.pop()
            if tried.cell is not None:
                accepted.append(tried.cell)
            elif not tried.empty:
                halvings += 1
                if len(accepted) + len(waiting) >= MOST_CELLS or halvings > MOST_HALVINGS:
                    return None
                waiting += self._halves(tried.rates)
        return tuple(accepted)

    def _tried(self, rates: Rectangle) -> _TriedCell:
        if inverse_inertia(self.box, *rates) is None:
            return _TriedCell(rates, np.inf, empty=True)
        loops = enclose_loop(self.loop, self.box, rates, self.coordinates)
        # end points of the cubics: values between them lie nearly on the chord and are left to the
        # proof
        low_ends, high_ends = (
            [_numbers(end[0]), _numbers(end[-1])]
            for end in (loops[:CONTROL_POINTS], loops[CONTROL_POINTS:])
        )
        least, *lyapunov = lyapunov_ends(low_ends, high_ends, len(self.loop.states), self.below)
        if least <= 0.0:
            return _TriedCell(rates, least)
        low, high = (
            np.array(
                [[round(value * 2**BITS_KEPT) for value in row] for row in p.tolist()], dtype=object
            )
            for p in lyapunov
        )
        if (
            failing_inequality(loops, self.coordinates, (low, high), BITS_KEPT, self.below)
            is not None
        ):
            return _TriedCell(rates, 0.0)
        drive, viscous = ((float(ends[0]), float(ends[1])) for ends in rates)
        return _TriedCell(rates, least, Cell(drive, viscous, pack_matrix(low), pack_matrix(high)))

    def _halves(self, rates: Rectangle) -> list[_TriedCell]:
        """Return the two halves of a rectangle with the results of their proofs.

        The cut is in the direction whose first half satisfies the inequalities with the larger
        margin. A direction without width is not cut.
        """
        drive, viscous = rates
        if _thin(viscous) or _thin(drive):
            halves = (
                [(half, viscous) for half in _halved(drive)]
                if _thin(viscous)
                else [(drive, half) for half in _halved(viscous)]
            )
            return [self._tried(half) for half in halves]
        across_drive = [(half, viscous) for half in _halved(drive)]
        across_viscous = [(drive, half) for half in _halved(viscous)]
        first, other = self._tried(across_drive[0]), self._tried(across_viscous[0])
        if first.least > other.least:
            return [first, self._tried(across_drive[1])]
        return [other, self._tried(across_viscous[1])]


def _halved(interval: Interval) -> tuple[Interval, Interval]:
    """Return the two halves of an interval, the upper one first."""
    middle = Fraction(float((interval[0] + interval[1]) / 2))
    return (middle, interval[1]), (interval[0], middle)


def _thin(interval: Interval) -> bool:
    """Return True if the interval is only the margin ROOM around an exactly known rate."""
    return float(interval[1] - interval[0]) <= 2.0 * ROOM * max(
        abs(float(interval[0])), abs(float(interval[1])), 1.0
    ) * (1.0 + ROOM)


def _outward(interval: Interval) -> Interval:
    low, high = float(interval[0]), float(interval[1])
    room = ROOM * max(abs(low), abs(high), 1.0)
    return Fraction(low - room), Fraction(high + room)
