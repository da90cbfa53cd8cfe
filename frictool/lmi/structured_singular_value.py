"""Worst norm and stability margin of a loop for every constant value of its real parameters.

    worst_gain       smallest g found with |z| < g |w| for every |Delta| <= 1: an upper bound
                     of the worst norm over the box
    singular_value   smallest m found with the loop stable for every |Delta| < 1/m: an upper
                     bound of the real mu of the box

The bounds use D-G scalings (Fan, Tits and Doyle, 1991; Young, 1993) on the whole frequency axis,
not on a grid. For each arc of the unit circle one D, G is computed for which the inequality is
strict at the arc's ends and middle. The arc is accepted if a Hamiltonian matrix shows that the
inequality holds on all of it, else it is halved. If no D, G exists at a point, the level is raised
to the smallest feasible one at that point.

The solver's result is checked: D > 0 and the inequality are evaluated here. A continuous loop is
replaced by its Tustin image, which keeps norm, stability and uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from frictool.errors import NoSolutionError
from frictool.lmi.arc_negativity import is_negative_on
from frictool.lmi.dg_scalings import ScalingForm, form
from frictool.lmi.sdp import Affine, solve
from frictool.plant.lti import Lti, tustin
from frictool.plant.uncertain_axis import Uncertain
from frictool.typing import ComplexVector, Matrix, Vector

TOLERANCE = 2e-3  # relative distance of a level above the optimum at its worst frequency
SHORTEST = 1e-7  # rad, shortest arc
SMALLEST = 1e-3  # level at which a search begins
UNBOUNDED = 1e6  # factor on the starting level above which the level counts as infinite
# limit of the sum of the scalings D in balanced coordinates; larger ones mean no useful margin
LARGEST = 1e4
FIRST_ARCS = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 9) * np.pi])


@dataclass(frozen=True)
class CertifiedLevel:
    """Level `value` that holds on the whole frequency axis.

    `frequency` [rad/s] is the frequency that requires this level, NaN if no frequency raised the
    level above the start. `arcs` is the number of arcs that cover the axis.
    """

    value: float
    frequency: float
    arcs: int


def worst_gain(
    loop: Lti, blocks: Sequence[Uncertain], start: float = 0.0, tolerance: float = TOLERANCE
) -> CertifiedLevel:
    """Return an upper bound of the norm from w to z over all Delta.

    The inputs of `loop` are (w_Delta, w), its outputs (z_Delta, z); the channels of `blocks` come
    first. `start` is the norm of some plant of the box, at which the search begins. The bound is
    infinite if the loop is unstable without uncertainty or no finite bound exists.
    """
    return _covered(loop, blocks, start, tolerance, scaled=False)


def singular_value(
    loop: Lti, blocks: Sequence[Uncertain], start: float = 0.0, tolerance: float = TOLERANCE
) -> CertifiedLevel:
    """Return an upper bound of the structured singular value of M_Delta.

    The loop is stable for every |Delta| < 1/value. Its ports are as in `worst_gain`. The remainder
    of a sampled axis (plant/uncertain_axis.py) is computed for this box. A value below 1 then means
    that the whole box is stable; only in continuous time is 1/value the factor by which the box may
    grow.
    """
    z, w = sum(b.entering for b in blocks), sum(b.size for b in blocks)
    alone = replace(loop, b=loop.b[:, :w], c=loop.c[:z], d=loop.d[:z, :w])
    return _covered(alone, blocks, start, tolerance, scaled=True)


def _covered(
    loop: Lti, blocks: Sequence[Uncertain], start: float, tolerance: float, *, scaled: bool
) -> CertifiedLevel:
    return (
        _ArcCover(loop, blocks, scaled=scaled, tolerance=tolerance).certified_level(start)
        if loop.stable
        else CertifiedLevel(np.inf, np.nan, 0)
    )


class _ArcCover:
    """Cover of the unit circle by arcs with scalings that hold on them, for a stable loop.

    The level only rises; scalings that hold at a level also hold above it.
    """

    def __init__(
        self, loop: Lti, blocks: Sequence[Uncertain], *, scaled: bool, tolerance: float
    ) -> None:
        self.scaled, self.tolerance = scaled, tolerance
        fast = np.abs(np.linalg.eigvals(loop.a))
        self.period = loop.period or 2.0 / float(
            np.exp(np.mean(np.log(np.maximum(fast, 1e-3 * np.max(fast)))))
        )
        self.continuous = loop.period == 0.0
        self.form = form(blocks, len(loop.c), loop.b.shape[1])
        self.loop = _evened(tustin(loop, self.period) if self.continuous else loop, self.form)

    def certified_level(self, start: float) -> CertifiedLevel:
        level = max(start, self.least()) * (1.0 + self.tolerance)
        where = np.nan
        arcs = 0
        waiting = list(pairwise(FIRST_ARCS.tolist()))
        # at the ends the response is real, and the level for real parameters may jump: below that
        # level the scalings nearby grow without limit
        angles: tuple[float, ...] = (0.0, np.pi)
        while True:
            for angle in angles:
                feasible = self.smallest_feasible(angle, level)
                if not np.isfinite(feasible):
                    return CertifiedLevel(np.inf, self.frequency(angle), arcs)
                if feasible > level:
                    level = feasible * (1.0 + self.tolerance)
                    where = self.frequency(angle)
            while waiting and self.holds_between(*waiting[-1], level):
                waiting.pop()
                arcs += 1
            if not waiting:
                return CertifiedLevel(level, where, arcs)
            left, right = waiting.pop()
            middle = 0.5 * (left + right)
            if right - left < SHORTEST:
                raise NoSolutionError(
                    "the structured singular value was not bounded near "
                    f"{self.frequency(middle):.4g} rad/s: no scaling holds on any arc "
                    "there; narrow the parameters' intervals"
                )
            angles = left, middle, right
            waiting += [(left, middle), (middle, right)]

    def least(self) -> float:
        """Return the gain without uncertainty, at least SMALLEST, as a safe lower level."""
        if self.scaled:
            return SMALLEST
        rows, columns = self.form.z_uncertain, self.form.w_uncertain
        nominal = replace(
            self.loop,
            b=self.loop.b[:, columns:],
            c=self.loop.c[rows:],
            d=self.loop.d[rows:, columns:],
            period=1.0,
        )
        return max(
            SMALLEST, float(np.max(np.linalg.norm(nominal.response(FIRST_ARCS), 2, axis=(1, 2))))
        )

    def frequency(self, angle: float) -> float:
        """Return an angle as frequency in rad/s of the original loop."""
        return float(
            2.0 / self.period * np.tan(0.5 * angle) if self.continuous else angle / self.period
        )

    def scaled_loop(self, level: float) -> tuple[Lti, float]:
        """Return the loop and performance level for the inequality; a scaled loop has level 1."""
        return (
            (replace(self.loop, c=self.loop.c / level, d=self.loop.d / level), 1.0)
            if self.scaled
            else (self.loop, level)
        )

    def holds_between(self, left: float, right: float, level: float) -> bool:
        """Return True if scalings were found that satisfy the inequality between two angles."""
        loop, performance = self.scaled_loop(level)
        x = self.scalings(loop, np.array([left, 0.5 * (left + right), right]), performance)
        return x is not None and is_negative_on(loop, self.form.at(x, performance), left, right)

    def smallest_feasible(self, angle: float, level: float) -> float:
        """Return the smallest feasible level at one angle, at least `level`.

        It is accurate to a fraction of the tolerance, and infinite above UNBOUNDED times `level`.
        """
        low, high = level, level
        while self.scalings(*self.one(angle, high)) is None:
            low = high
            high = 2.0 * high
            if high > UNBOUNDED * level:
                return np.inf
        while high > low * (1.0 + 0.25 * self.tolerance):
            middle = np.sqrt(low * high)
            low, high = (
                (low, middle)
                if self.scalings(*self.one(angle, middle)) is not None
                else (middle, high)
            )
        return float(high)

    def one(self, angle: float, level: float) -> tuple[Lti, NDArray[np.float64], float]:
        loop, performance = self.scaled_loop(level)
        return loop, np.array([angle]), performance

    def scalings(self, loop: Lti, angles: NDArray[np.float64], level: float) -> Vector | None:
        """Return unknowns with Phi < 0 at all angles and D > 0, or None if the solver finds none.

        The eigenvalues of Phi and D confirm both inequalities.
        """
        m = _responses(loop, angles)
        terms = np.array(
            [
                [_congruence(stack, part) for part in (self.form.fixed(level), *self.form.basis)]
                for stack in m
            ]
        )
        constraints = [*(_below(one) for one in terms), *_bounds(self.form)]
        objective = np.zeros(self.form.count + 1)
        objective[-1] = -1.0
        x = solve(objective, constraints).x[:-1]
        if not np.all(np.isfinite(x)) or any(
            np.linalg.eigvalsh(d)[0] <= 0.0 for d in self.form.scales(x)
        ):
            return None
        worst = max(np.linalg.eigvalsh(one[0] + np.tensordot(x, one[1:], 1))[-1] for one in terms)
        return x if worst < 0.0 else None


def _responses(loop: Lti, angles: NDArray[np.float64]) -> ComplexVector:
    """Return the loop's frequency response M, stacked on the identity, at each angle [rad]."""
    m = replace(loop, period=1.0).response(angles)
    return np.concatenate(
        [m, np.broadcast_to(np.eye(m.shape[2]), (len(m), m.shape[2], m.shape[2]))], axis=1
    )


def _congruence(stack: ComplexVector, part: ComplexVector) -> ComplexVector:
    return np.asarray(stack.conj().T @ part @ stack)


def _real(matrices: ComplexVector) -> Matrix:
    """Return real symmetric images of Hermitian matrices (..., m, m); eigenvalues occur twice."""
    return np.block([[matrices.real, -matrices.imag], [matrices.imag, matrices.real]])


def _below(terms: ComplexVector) -> Affine:
    """Return the constraint -Phi - t >= 0, t the last unknown."""
    fixed = _real(terms[0])
    parts = _real(terms[1:])
    identity = np.eye(len(fixed))

    def positive(x: Matrix) -> Matrix:
        return np.asarray(
            -fixed - np.tensordot(x[:, :-1], parts, 1) - x[:, -1, None, None] * identity
        )

    return positive


def _bounds(shape: ScalingForm) -> list[Affine]:
    """Return the constraints D >= 0 of each block, trace of all D <= LARGEST and t <= 1."""
    basis = shape.basis
    constraints: list[Affine] = []
    for z, _, real in shape.blocks:
        rows = z if real else slice(z.start, z.start + 1)
        constraints.append(partial(_combined, _real(basis[:, rows, rows])))
    trace = np.array(
        [float(np.trace(part[: shape.z_uncertain, : shape.z_uncertain]).real) for part in basis]
    )
    constraints.append(lambda x: (LARGEST - x[:, :-1] @ trace)[:, None, None])
    constraints.append(lambda x: (1.0 - x[:, -1])[:, None, None])
    return constraints


def _combined(parts: Matrix, x: Matrix) -> Matrix:
    return np.asarray(np.tensordot(x[:, :-1], parts, 1))


def _evened(loop: Lti, shape: ScalingForm, sweeps: int = 20) -> Lti:
    """Return the loop with each uncertain channel scaled to equal input and output gains.

    D and G change with the scaling.
    """
    size = np.max(np.abs(replace(loop, period=1.0).response(np.geomspace(1e-3, np.pi, 12))), axis=0)
    scale_z, scale_w = np.ones(shape.z), np.ones(shape.w)
    offset = shape.z
    for _ in range(sweeps):
        for z, w, real in shape.blocks:
            for rows, columns in _channels(z, slice(w.start - offset, w.stop - offset), real):
                leaving = float(np.linalg.norm(scale_z[rows, None] * size[rows] * scale_w))
                entering = float(
                    np.linalg.norm(scale_z[:, None] * size[:, columns] * scale_w[columns])
                )
                if leaving > 0.0 and entering > 0.0:
                    factor = np.sqrt(entering / leaving)
                    scale_z[rows] *= factor
                    scale_w[columns] /= factor
    return replace(
        loop, b=loop.b * scale_w, c=scale_z[:, None] * loop.c, d=scale_z[:, None] * loop.d * scale_w
    )


def _channels(z: slice, w: slice, real: bool) -> list[tuple[slice, slice]]:
    """Return the pairs of rows and columns that may be scaled independently."""
    return (
        [
            (slice(z.start + k, z.start + k + 1), slice(w.start + k, w.start + k + 1))
            for k in range(z.stop - z.start)
        ]
        if real
        else [(z, w)]
    )
