"""What is true of a loop for every constant value of its real parameters: the worst norm, and how
far the box may grow.

    worst_gain       smallest g found with |z| < g |w| for every Delta, |Delta| <= 1: an upper bound
                     of the worst norm over the box
    singular_value   smallest m found with the loop stable for every Delta, |Delta| < 1/m: an upper
                     bound of the real mu of the box

Upper bounds by D-G scalings (Fan, Tits and Doyle, 1991; Young, 1993), which are not a grid of
frequencies: on each arc of the unit circle one D, G is sought with the inequality strict at the
arc's ends and middle, and is accepted where a Hamiltonian matrix shows that it holds on the whole
arc; else the arc is halved. Where no D, G exists at a point the level is raised to the one that its
own optimum asks for. The solver's answer is used as numbers only: D > 0 and the inequality are
evaluated here. A continuous loop goes through Tustin's image, which keeps norm, stability and the
uncertainty as they are.
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
from frictool.lmi.dg_scalings import Complex, ScalingForm, Vector, form
from frictool.lmi.sdp import Affine, solve
from frictool.plant.lti import Lti, tustin
from frictool.plant.uncertain_axis import Uncertain

Matrix = NDArray[np.float64]
TOLERANCE = 2e-3  # how far above the optimum at its worst frequency a level is set
SHORTEST = 1e-7  # rad, of an arc
SMALLEST = 1e-3  # level at which a search begins
UNBOUNDED = 1e6  # times the level before: no level at all
LARGEST = 1e4  # sum of the scalings D in evened coordinates: what needs more has no useful margin
FIRST_ARCS = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 9) * np.pi])


@dataclass(frozen=True)
class CertifiedLevel:
    """`value` holds on the whole frequency axis; it is what `frequency` [rad/s] asks for (nan: no
    frequency asked for more than the start).

    arcs: how many were needed to cover the axis.
    """

    value: float
    frequency: float
    arcs: int


def worst_gain(
    loop: Lti, blocks: Sequence[Uncertain], start: float = 0.0, tolerance: float = TOLERANCE
) -> CertifiedLevel:
    """Upper bound of the norm from w to z over all Delta.

    `loop`: inputs (w_Delta, w), outputs (z_Delta, z), those of `blocks` first. `start`: a norm that
    some plant of the box has, where the search begins. Infinite where the loop is unstable without
    uncertainty, or where the bound is not finite.
    """
    return _covered(loop, blocks, start, tolerance, scaled=False)


def singular_value(
    loop: Lti, blocks: Sequence[Uncertain], start: float = 0.0, tolerance: float = TOLERANCE
) -> CertifiedLevel:
    """Upper bound of the structured singular value of M_Delta; the loop is stable for every |Delta|
    < 1/value. Ports as in `worst_gain`.

    A sampled axis's rest (plant/uncertain_axis.py) encloses the box itself: a value below 1 says
    that all of it is stable, and 1/value is how far the box may grow in continuous time only.
    """
    z, w = sum(b.entering for b in blocks), sum(b.size for b in blocks)
    alone = replace(loop, b=loop.b[:, :w], c=loop.c[:z], d=loop.d[:z, :w])
    return _covered(alone, blocks, start, tolerance, scaled=True)


def _covered(
    loop: Lti, blocks: Sequence[Uncertain], start: float, tolerance: float, *, scaled: bool
) -> CertifiedLevel:
    return (
        _ArcCover(loop, blocks, scaled=scaled, tolerance=tolerance).found(start)
        if loop.stable
        else CertifiedLevel(np.inf, np.nan, 0)
    )


class _ArcCover:
    """Of a stable loop: arcs with scalings that hold on them, at a level that only rises (what
    holds at a level holds above it)."""

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

    def found(self, start: float) -> CertifiedLevel:
        level, where, arcs = max(start, self.least()) * (1.0 + self.tolerance), np.nan, 0
        waiting = list(pairwise(FIRST_ARCS.tolist()))
        # at the ends, where the response is real, what real parameters ask for may jump: scalings
        # beside them grow beyond measure below it
        angles: tuple[float, ...] = (0.0, np.pi)
        while True:
            for angle in angles:
                asked = self.asked(angle, level)
                if not np.isfinite(asked):
                    return CertifiedLevel(np.inf, self.frequency(angle), arcs)
                if asked > level:
                    level, where = asked * (1.0 + self.tolerance), self.frequency(angle)
            while waiting and self.held(*waiting[-1], level):
                waiting.pop()
                arcs += 1
            if not waiting:
                return CertifiedLevel(level, where, arcs)
            left, right = waiting.pop()
            middle = 0.5 * (left + right)
            if right - left < SHORTEST:
                raise NoSolutionError(
                    f"the structured singular value was not bounded near {self.frequency(middle):.4g} rad/s: no scaling holds on any arc "
                    "there; narrow the parameters' intervals"
                )
            angles = left, middle, right
            waiting += [(left, middle), (middle, right)]

    def least(self) -> float:
        """A level that is certainly not too high: the gain without uncertainty, or hardly
        anything."""
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
        """In rad/s, of the loop as it was given."""
        return float(
            2.0 / self.period * np.tan(0.5 * angle) if self.continuous else angle / self.period
        )

    def scaled_loop(self, level: float) -> tuple[Lti, float]:
        """The loop and the level of the performance at which the inequality is posed."""
        return (
            (replace(self.loop, c=self.loop.c / level, d=self.loop.d / level), 1.0)
            if self.scaled
            else (self.loop, level)
        )

    def held(self, left: float, right: float, level: float) -> bool:
        """Whether scalings were found that hold from one angle to the other."""
        loop, performance = self.scaled_loop(level)
        x = self.scalings(loop, np.array([left, 0.5 * (left + right), right]), performance)
        return x is not None and is_negative_on(loop, self.form.at(x, performance), left, right)

    def asked(self, angle: float, level: float) -> float:
        """The smallest level at one angle, at least `level`, to a fraction of the tolerance;
        infinite where it is UNBOUNDED times that."""
        low, high = level, level
        while self.scalings(*self.one(angle, high)) is None:
            low, high = high, 2.0 * high
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
        """Unknowns of the form with Phi < 0 at all angles and D > 0, by our own eigenvalues, or
        None."""
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


def _responses(loop: Lti, angles: NDArray[np.float64]) -> Complex:
    """[M; I] at the angles [rad]."""
    m = replace(loop, period=1.0).response(angles)
    return np.concatenate(
        [m, np.broadcast_to(np.eye(m.shape[2]), (len(m), m.shape[2], m.shape[2]))], axis=1
    )


def _congruence(stack: Complex, part: Complex) -> Complex:
    return np.asarray(stack.conj().T @ part @ stack)


def _real(matrices: Complex) -> Matrix:
    """Real symmetric images of Hermitian matrices (..., m, m), with the same eigenvalues twice."""
    return np.block([[matrices.real, -matrices.imag], [matrices.imag, matrices.real]])


def _below(terms: Complex) -> Affine:
    """-Phi - t >= 0, t the last unknown."""
    fixed, parts = _real(terms[0]), _real(terms[1:])
    identity = np.eye(len(fixed))

    def positive(x: Matrix) -> Matrix:
        return np.asarray(
            -fixed - np.tensordot(x[:, :-1], parts, 1) - x[:, -1, None, None] * identity
        )

    return positive


def _bounds(shape: ScalingForm) -> list[Affine]:
    """D >= 0 of each block, trace of all D at most a bound, t at most 1."""
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
    """The same loop with each uncertain channel in the unit that evens out what enters and leaves
    it (D and G change with it)."""
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
    """Pairs of rows and columns that may be scaled by their own number."""
    return (
        [
            (slice(z.start + k, z.start + k + 1), slice(w.start + k, w.start + k + 1))
            for k in range(z.stop - z.start)
        ]
        if real
        else [(z, w)]
    )
