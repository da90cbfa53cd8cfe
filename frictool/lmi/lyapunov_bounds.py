"""Upper bounds of the worst norm (5.53) of a family of loops whose parameters may move.

    x' = A x + B w,  z = C x + D w    multi-affine in the parameters r of a box, normalised
                                      to [0, 1]
    common                one P: any motion of r at any speed (Boyd et al., 1994); the
                          vertices are sufficient for their hull
    parameter dependent   P(r) multi-affine in r: r constant, or |r'| bounded

With P(r) the bounded-real inequality has degree two in each parameter. In Bernstein's basis,
(1-r)^2, 2 r (1-r), r^2 for each parameter, it is negative on the whole box if all 3^r coefficient
matrices are. This condition is sufficient, needs no grid and is linear in P. A coefficient is the
mean, over the pairs of corners that contribute to it, of the inequality with P of one corner and
the loop of the other.

The motion adds the sum of r_j' dP/dr_j, at every corner of the box of rates. In discrete time a
step moves P(r) to P+ = P(r + step), and a Schur complement keeps A' P+ A linear:

    [-P  A'P+  0  C'; P+A  -P+  P+B  0; 0  B'P+  -gamma  D'; C  0  D  -gamma] < 0.

Samples of a continuous plant are only nearly multi-affine in its parameters. For sampled loops the
bound is therefore that of the interpolation between the corners; `at` computes the gamma that P
proves for any other loop. The solver's gamma is not used: for given P the smallest gamma of each
inequality is the largest eigenvalue of a matrix in closed form (Schur complement), computed here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cholesky

from frictool.lmi.sdp import Affine, solve, symmetric
from frictool.lmi.state_balancing import osborne
from frictool.plant.lti import Lti
from frictool.typing import Matrix

PASSES = 3  # balancing passes, each in coordinates in which the last mean P is the unit matrix


@dataclass(frozen=True)
class LyapunovBound:
    """Bound `gamma` of |z|/|w|, infinite if no Lyapunov matrix was found.

    `p` is P, or P at each corner, in coordinates x = t x_balanced and, in continuous time, in time
    units of `unit` [s]. In SI units the decrease of x' P x would be lost in rounding.
    """

    gamma: float
    p: tuple[Matrix, ...] = ()
    t: Matrix = field(default_factory=lambda: np.zeros((0, 0)))
    unit: float = 1.0

    def at(self, loop: Lti, values: Sequence[float] = ()) -> float:
        """Return the gamma that P proves for a loop at normalised `values` (r,); inf if none."""
        if not self.p:
            return np.inf
        corners = product((0, 1), repeat=len(values))
        weights = [
            np.prod(
                [value if bit else 1.0 - value for bit, value in zip(corner, values, strict=True)]
            )
            for corner in corners
        ]
        p = sum(
            (weight * part for weight, part in zip(weights, self.p, strict=True)),
            start=np.zeros_like(self.p[0]),
        )
        if np.linalg.eigvalsh(p)[0] <= 0.0:
            return np.inf
        posed = _timed(loop, self.unit).transformed(self.t)
        return _smallest_gamma(
            _inequality(posed, p[None], p[None], np.zeros_like(p)[None])[0], loop
        )


def common_bound(loops: Sequence[Lti]) -> LyapunovBound:
    """Return the bound by one Lyapunov matrix for the hull of `loops`, for motion at any speed.

    The loops have the same states, inputs, outputs and domain.
    """
    return _bound(loops, 0, [[(0, k)] for k in range(len(loops))], np.zeros((1, 0)))


def parameter_dependent_bound(
    loops: Sequence[Lti], rates: ArrayLike | None = None
) -> LyapunovBound:
    """Return the bound by a P that is multi-affine in r parameters.

    `loops` are the 2^r corners in the order of itertools.product, the last parameter fastest.
    `rates` (r,) bound the speeds of the parameters, in interval widths per s, or per sample for
    sampled loops (more than 1 means 1); without them the parameters are constant. The result is
    `common_bound` if a rate is infinite or no P(r) is found. Raises ValueError if there are not 2^r
    loops.
    """
    count = len(loops).bit_length() - 1
    if len(loops) != 1 << count:
        raise ValueError(
            f"{len(loops)} loops are not the corners of a box; there must be 2, 4, 8 ..."
        )
    speeds = np.zeros(count) if rates is None else np.asarray(rates, dtype=np.float64)
    if loops[0].period:
        speeds = np.minimum(speeds, 1.0)
    motions = np.array(
        list(product(*((-speed, speed) if speed > 0.0 else (0.0,) for speed in speeds))),
        dtype=np.float64,
    )  # (k, r); (1, 0) for one plant
    corners = list(product((0, 1), repeat=count))
    meeting: dict[tuple[int, ...], list[tuple[int, int]]] = {}
    for i, first in enumerate(corners):
        for j, second in enumerate(corners):
            meeting.setdefault(tuple(np.add(first, second).tolist()), []).append((i, j))
    bound = (
        _bound(loops, count, list(meeting.values()), motions)
        if np.all(np.isfinite(speeds))
        else LyapunovBound(np.inf)
    )
    if np.isfinite(bound.gamma):
        return bound
    common = common_bound(loops)
    return replace(common, p=common.p * len(loops))


Pairs = Sequence[tuple[int, int]]  # (corner of P, loop)


def _bound(
    loops: Sequence[Lti], count: int, coefficients: Sequence[Pairs], motions: Matrix
) -> LyapunovBound:
    best = LyapunovBound(np.inf)
    if any(not loop.stable for loop in loops):
        return best
    unit = (
        1.0
        if loops[0].period
        else 1.0 / float(np.median([np.max(np.abs(np.linalg.eigvals(loop.a))) for loop in loops]))
    )
    posed = [_timed(loop, unit) for loop in loops]
    t = osborne([np.block([[loop.a, loop.b], [loop.c, loop.d]]) for loop in posed], posed[0].order)
    for _ in range(PASSES):
        problem = _BoundProblem(
            [loop.transformed(t) for loop in posed], count, coefficients, unit * motions
        )
        gamma, p = problem.solved()
        if not np.isfinite(gamma):
            break
        if gamma < best.gamma:
            best = LyapunovBound(gamma, p, t, unit)
        t = t @ np.linalg.inv(cholesky(np.mean(p, axis=0)))
    return best


def _timed(loop: Lti, unit: float) -> Lti:
    """Return a continuous loop with time in `unit` s; P is the same."""
    return (
        loop
        if loop.period
        else replace(loop, a=unit * loop.a, b=np.sqrt(unit) * loop.b, c=np.sqrt(unit) * loop.c)
    )


class _BoundProblem:
    """Inequalities in one set of coordinates; the unknowns are P of each corner, then gamma."""

    def __init__(
        self, loops: Sequence[Lti], count: int, coefficients: Sequence[Pairs], motions: Matrix
    ) -> None:
        self.loops, self.coefficients, self.motions = loops, coefficients, motions
        self.n = loops[0].order
        self.half = self.n * (self.n + 1) // 2
        self.corners = list(product((0, 1), repeat=count))
        self.unknowns = len(self.corners) * self.half + 1

    def solved(self) -> tuple[float, tuple[Matrix, ...]]:
        """Return the smallest gamma proved by the solver's P, and P of each corner.

        gamma is infinite if P proves nothing.
        """
        constraints: list[Affine] = [
            partial(self.p, corner=corner) for corner in range(len(self.corners))
        ]
        constraints += [
            partial(self.positive, pairs=pairs, motion=motion)
            for pairs, motion in self.inequalities()
        ]
        x = solve(np.eye(self.unknowns)[-1], constraints).x
        if not np.all(np.isfinite(x)):
            return np.inf, ()
        p = tuple(self.p(x[None], corner)[0] for corner in range(len(self.corners)))
        if min(np.linalg.eigvalsh(part)[0] for part in p) <= 0.0:
            return np.inf, ()
        return max(
            _smallest_gamma(self.whole(x[None], pairs, motion)[0], self.loops[0])
            for pairs, motion in self.inequalities()
        ), p

    def inequalities(self) -> Iterator[tuple[Pairs, Matrix]]:
        return product(self.coefficients, self.motions)

    def p(self, x: Matrix, corner: int) -> Matrix:
        """Return P at a corner, for decision vectors (k, unknowns)."""
        return symmetric(x[:, corner * self.half : (corner + 1) * self.half], self.n)

    def positive(self, x: Matrix, pairs: Pairs, motion: Matrix) -> Matrix:
        """Return minus a Bernstein coefficient of the inequality, with gamma."""
        whole = -self.whole(x, pairs, motion)
        outer = np.arange(whole.shape[1] - _ports(self.loops[0]), whole.shape[1])
        whole[:, outer, outer] += x[:, -1:]
        return whole

    def whole(self, x: Matrix, pairs: Pairs, motion: Matrix) -> Matrix:
        """Return a Bernstein coefficient of the inequality without gamma."""
        inequalities = [
            _inequality(
                self.loops[j], self.p(x, i), self.moved(x, i, motion), self.drift(x, i, motion)
            )
            for i, j in pairs
        ]
        return np.asarray(np.mean(inequalities, axis=0))

    def drift(self, x: Matrix, corner: int, motion: Matrix) -> Matrix:
        """Return the rate of change of P at a corner, sum r_j' dP/dr_j, for r' = motion."""
        return sum(
            (speed * self.slope(x, corner, axis) for axis, speed in enumerate(motion) if speed),
            start=np.zeros((len(x), self.n, self.n)),
        )

    def slope(self, x: Matrix, corner: int, axis: int) -> Matrix:
        low, high = list(self.corners[corner]), list(self.corners[corner])
        low[axis], high[axis] = 0, 1
        return self.p(x, self.corners.index(tuple(high))) - self.p(
            x, self.corners.index(tuple(low))
        )

    def moved(self, x: Matrix, corner: int, motion: Matrix) -> Matrix:
        """Return P(corner + step); the extrapolation is exact since P is multi-affine."""
        values = np.add(self.corners[corner], motion)
        weights = [
            np.prod([v if bit else 1.0 - v for bit, v in zip(other, values, strict=True)])
            for other in self.corners
        ]
        return sum(
            (weight * self.p(x, k) for k, weight in enumerate(weights) if weight),
            start=np.zeros((len(x), self.n, self.n)),
        )


def _ports(loop: Lti) -> int:
    return int(loop.b.shape[1]) + len(loop.c)


def _inequality(loop: Lti, p: Matrix, moved: Matrix, drift: Matrix) -> Matrix:
    """Return the bounded-real inequality without its gamma.

    `p`, `moved` (P after a step) and `drift` have the shape (k, n, n).
    """
    n, w = loop.b.shape
    inner = 2 * n if loop.period else n
    whole = np.zeros((len(p), inner + w + len(loop.c), inner + w + len(loop.c)))
    if loop.period:
        whole[:, :n, :n], whole[:, n:inner, n:inner] = -0.5 * p, -0.5 * moved
        whole[:, n:inner, :n], whole[:, n:inner, inner : inner + w] = moved @ loop.a, moved @ loop.b
    else:
        whole[:, :n, :n] = p @ loop.a + 0.5 * drift
        whole[:, :n, n : n + w] = p @ loop.b
    whole[:, inner + w :, :n], whole[:, inner + w :, inner : inner + w] = loop.c, loop.d
    return np.asarray(whole + whole.transpose(0, 2, 1))


def _smallest_gamma(whole: Matrix, loop: Lti) -> float:
    """Return the smallest gamma with whole - diag(0, gamma I) < 0.

    It is infinite if the block without gamma is not negative.
    """
    inner = len(whole) - _ports(loop)
    decrease = -whole[:inner, :inner]
    cross = whole[inner:, :inner]
    rest = whole[inner:, inner:]
    if np.linalg.eigvalsh(decrease)[0] <= 0.0:
        return np.inf
    return float(np.linalg.eigvalsh(rest + cross @ np.linalg.solve(decrease, cross.T))[-1])
