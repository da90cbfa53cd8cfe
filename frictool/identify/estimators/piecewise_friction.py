"""Friction as a piecewise linear function of the speed, with estimated knees (thesis 4.2.6.2).

    friction = (coulomb + sum_j viscous_j max(min(|v|, knee_{j+1}) - knee_j, 0)) sign(v)
    knee_0 = 0

A knee is a speed at which the slope changes. Each row of the regression is a mean over a part of a
stroke. The formula is averaged over all speeds in this part, because the value at the mean speed
would blur a knee. For fixed knees the model is linear in the parameters. Knees are added one at a
time; after each addition, all knees are optimised in turn. Schwarz's criterion (BIC) for n strokes
and p parameters decides when to stop; a knee adds two parameters, its speed and its slope. The
penalty p log n is multiplied by n/(n - p - 2), which matters if there are few strokes (McQuarrie,
1999).

The criterion assumes equal independent errors of all strokes. One stroke with a large error (a
transient of a soft belt, for example) can therefore justify a knee. For this reason, the change of
slope at each knee must also differ significantly from 0 in a jackknife, which does not need this
assumption.

The search for knees has an additional regressor, the mean acceleration, because an error of the
inertia in bench.yaml can also look like a knee. The intervals of all parameters come from a
jackknife, in which the derivative of the friction with respect to the speed of each knee is an
additional regressor.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.regression import (
    LeastSquaresSolution,
    SingularRegressors,
    solve,
)
from frictool.typing import Matrix, Vector

MOST_KNEES = 2
GRID_POINTS = 40  # grid points of the first search for a knee
SWEEPS = 3  # passes over all knees, each placed again with the others fixed
FEWEST_ROWS = 4  # least number of rows on either side of a knee, to determine a slope there
# least decrease of Schwarz's criterion for a knee: "strong" in Kass and Raftery (1995)
EVIDENCE = 6.0


@dataclass(frozen=True)
class _SortedSpeeds:
    """Speeds of m parts, sorted within each part, for means of min(|v|, knee) without all samples.

    - key: number of the part plus half of (speed)/(largest speed), ascending, (n,)
    - sums: sum of all sorted speeds before each sample, (n + 1,)
    - ends: index of the first sample of each part, and n, (m + 1,)
    - largest: largest speed, rad/s | m/s
    """

    key: Vector
    sums: Vector
    ends: NDArray[np.int64]
    largest: float

    @classmethod
    def of(cls, speed: Vector, lengths: NDArray[np.int64]) -> _SortedSpeeds:
        """Return the sorted speeds of `speed` (n,), |v| of parts with `lengths` (m,) samples.

        A noisy speed may be negative near a reversal; it counts as 0, as in all pieces.
        """
        part = np.repeat(np.arange(lengths.size), lengths)
        ordered = np.maximum(speed, 0.0)[np.lexsort((speed, part))]
        largest = max(float(ordered.max(initial=0.0)), np.finfo(np.float64).tiny)
        return cls(
            part + 0.5 / largest * ordered,
            np.concatenate(([0.0], np.cumsum(ordered))),
            np.concatenate(([0], np.cumsum(lengths))),
            largest,
        )

    def mean_up_to(self, knee: float) -> Vector:
        """Return the mean of min(|v|, knee) over each part, (m,)."""
        first, end = self.ends[:-1], self.ends[1:]
        share = 0.5 * min(knee, self.largest) / self.largest
        below = np.searchsorted(self.key, np.arange(first.size) + share, side="right")
        below = np.clip(below, first, end)
        faster = np.where(end > below, (end - below) * min(knee, self.largest), 0.0)
        return np.asarray((self.sums[below] - self.sums[first] + faster) / (end - first))


@dataclass(frozen=True)
class StrokeMeans:
    """Regression rows (m,), each a mean over a part of a stroke.

    - columns: regressors of the other parameters, such as Coulomb friction and offset, (m, p)
    - effort, sign: mean effort [N m | N] and direction (+-1) of each part, (m,)
    - weight, cluster: weight of each row, and number of its cluster, (m,)
    - speed: |v| of the samples of all parts, (n,), rad/s | m/s
    - starts: index in `speed` of the first sample of each part, (m,)
    - nuisance: additional regressors, used only in the search for knees, (m, q), or None
    """

    columns: Matrix
    effort: Vector
    sign: Vector
    weight: Vector
    cluster: NDArray[np.int64]
    speed: Vector
    starts: NDArray[np.int64]
    nuisance: Matrix | None = None

    def mean(self, values: Vector) -> Vector:
        """Return the means (m,) over the parts of `values` (n,), which has one value per sample."""
        return np.asarray(np.add.reduceat(values, self.starts) / self._lengths)

    @cached_property
    def _lengths(self) -> NDArray[np.int64]:
        return np.diff(np.append(self.starts, self.speed.size))

    @cached_property
    def _sorted(self) -> _SortedSpeeds:
        return _SortedSpeeds.of(self.speed, self._lengths)

    def piece(self, low: float, high: float) -> Vector:
        """Return the regressor (m,) of viscous friction between two speeds [rad/s | m/s].

        A sample of the speed |v| has the value min(max(|v|, low), high) - low, with the sign of the
        direction. If `high` is below `low`, every sample has the value high - low.
        """
        if high < low:
            return self.sign * (high - low)
        return self.sign * (self._sorted.mean_up_to(high) - self._sorted.mean_up_to(low))

    def share_beyond(self, knee: float) -> Vector:
        """Return the fraction (m,) of each part's samples faster than `knee` [rad/s | m/s].

        The fraction is multiplied by the direction, and is thus negative for backward motion.
        """
        return self.sign * self.mean((self.speed > knee).astype(np.float64))


@dataclass(frozen=True)
class PiecewiseFriction:
    """Least-squares fit of friction that is piecewise linear in the speed.

    - solution: coefficients with half widths, in three groups: viscous friction in each speed range
      between knees, coefficients of `StrokeMeans.columns`, and correction of the speed of each
      knee. The half width of a correction is the half width of the knee's speed.
    - knees: speeds at which the viscous friction changes, in ascending order, rad/s | m/s
    - residual: residual of each row, (m,)
    """

    solution: LeastSquaresSolution
    knees: tuple[float, ...]
    residual: Vector


def fit_pieces(
    means: StrokeMeans, most: int = MOST_KNEES, confidence: float = 0.95
) -> PiecewiseFriction:
    """Return the piecewise linear friction with at most `most` knees.

    A knee is used only if the knee lowers Schwarz's criterion sufficiently, and if 0 is outside the
    interval of the change of slope at the knee. This interval has the confidence `confidence`.

    Raises SingularRegressors if the rows do not determine friction without knees.
    """
    knees: tuple[float, ...] = ()
    chosen = [knees]
    least = _criterion(means, knees)
    for _ in range(most):
        placed = _with_one_more(means, knees)
        if placed is None:
            break
        knees = placed
        value = _criterion(means, placed)
        if value < least - EVIDENCE * (len(knees) - len(chosen[-1])):
            chosen.append(placed)
            least = value
    return _solved(means, next(one for one in chosen[::-1] if _bends(means, one, confidence)))


def design(means: StrokeMeans, knees: tuple[float, ...]) -> Matrix:
    """Return the regressors (m, 1 + k + p) for k knees.

    The first 1 + k columns belong to the viscous friction in each speed range between knees. The p
    columns of `means.columns` follow.
    """
    edges = (0.0, *knees, np.inf)
    return np.column_stack(
        [*(means.piece(low, high) for low, high in itertools.pairwise(edges)), means.columns]
    )


def _squares(means: StrokeMeans, knees: tuple[float, ...]) -> float:
    rows = design(means, knees)
    right = means.effort * means.weight
    if means.nuisance is not None:
        rows = np.column_stack((rows, means.nuisance))
    rows *= means.weight[:, None]
    return float(np.sum((right - rows @ np.linalg.lstsq(rows, right, rcond=None)[0]) ** 2))


def _criterion(means: StrokeMeans, knees: tuple[float, ...]) -> float:
    count = int(np.unique(means.cluster).size)
    parameters = means.columns.shape[1] + 1 + 2 * len(knees)
    free = max(count - parameters - 2, 1)
    floor = (np.finfo(np.float64).eps * float(np.linalg.norm(means.effort * means.weight))) ** 2
    return float(
        count * np.log((_squares(means, knees) + floor) / count)
        + parameters * np.log(count) * count / free
    )


def _bends(means: StrokeMeans, knees: tuple[float, ...], confidence: float) -> bool:
    """Return whether, at every knee, the change of slope differs significantly from 0.

    The intervals of the changes, with the confidence `confidence`, come from a jackknife over
    clusters. The result is False if the regressors are singular.
    """
    if not knees:
        return True
    bends = [means.piece(knee, np.inf) for knee in knees]
    moved = [means.share_beyond(knee) for knee in knees]
    columns = np.column_stack([*bends, *moved, means.piece(0.0, np.inf), means.columns])
    if means.nuisance is not None:
        columns = np.column_stack((columns, means.nuisance))
    try:
        solution = solve(columns, means.effort, means.weight, means.cluster)
    except SingularRegressors:
        return False
    half = solution.half_width(confidence)[: len(knees)]
    return bool(np.all(np.abs(solution.value[: len(knees)]) > half))


def _with_one_more(means: StrokeMeans, knees: tuple[float, ...]) -> tuple[float, ...] | None:
    """Return `knees` and one more knee, all at their best speeds; None if none can be added."""
    slow = np.sort(means.mean(means.speed))
    fast = np.sort(np.maximum.reduceat(means.speed, means.starts))
    if slow.size < 2 * FEWEST_ROWS or slow[FEWEST_ROWS - 1] >= fast[-FEWEST_ROWS]:
        return None
    low = float(slow[FEWEST_ROWS - 1])
    high = float(fast[-FEWEST_ROWS])
    speeds = np.linspace(low, high, GRID_POINTS)
    free = [
        float(speed)
        for speed in speeds
        if all(abs(speed - knee) > 2.0 * (speeds[1] - speeds[0]) for knee in knees)
    ]
    if not free:
        return None
    current = [*knees, min(free, key=lambda speed: _squares(means, (*knees, speed)))]
    for _ in range(SWEEPS if len(current) > 1 else 1):
        for index, start in enumerate(current):
            others = tuple(knee for other, knee in enumerate(current) if other != index)
            reach = speeds[1] - speeds[0]
            current[index] = bounded_minimum(
                lambda speed: _squares(means, (*others, speed)),  # noqa: B023  # used at once
                max(start - reach, low),
                min(start + reach, high),
            )
    return tuple(sorted(current))


def _solved(means: StrokeMeans, knees: tuple[float, ...]) -> PiecewiseFriction:
    rows = design(means, knees)
    value = np.linalg.lstsq(rows * means.weight[:, None], means.effort * means.weight, rcond=None)[
        0
    ]
    bends = np.diff(value[: len(knees) + 1])
    moved = [-bend * means.share_beyond(knee) for bend, knee in zip(bends, knees, strict=True)]
    solution = solve(np.column_stack([rows, *moved]), means.effort, means.weight, means.cluster)
    return PiecewiseFriction(solution, knees, means.effort - rows @ value)
