"""Straight pieces of friction over speed, with the knees between them found and not given (figure
4.10, 4.2.6.2).

    friction = (coulomb + sum_j viscous_j (min(|v|, knee_j+1) - knee_j)+) sign(v)        knee_0 = 0

A row is a mean over a part of a stroke: each piece is averaged over the speeds that the part holds,
so that a knee that falls within one is not smeared. For given knees the rest is linear. Knees are
added one at a time, each placed anew in turn; Schwarz's criterion, the independent strokes counted
as the data, says when to stop: a knee costs two parameters, its place and its slope. What else may
bend the means over speed (an inertia that is not quite the bench's, times a mean acceleration) is
free while knees are looked for: what it explains is no evidence of one. The interval of a knee
comes from the same jackknife as the others': the derivative by its place is one more column of the
regression.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from frictool.identify.motion_record import Vector
from frictool.identify.regression.regression import LeastSquaresSolution, Matrix, solve

MOST_KNEES = 2
PLACES = 40  # of the first search for a knee
SWEEPS = 3  # each knee anew, the others held
FEWEST_ROWS = 4  # means on either side of a knee that tell a slope there
EVIDENCE = (
    6.0  # by which Schwarz's criterion has to fall for a knee: "strong" of Kass and Raftery (1995)
)


@dataclass(frozen=True)
class StrokeMeans:
    """m rows, each a mean over a part of a stroke; `speed` (n,) |v| within all parts, part after
    part, `starts` (m,) of each.

    columns (m, p): of the regression besides the pieces. effort (m,), sign (m,), weight (m,),
    cluster (m,). nuisance (m, q): what may explain the effort too as long as knees are looked for.
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
        """The mean (m,) over each part of values (n,)."""
        lengths = np.diff(np.append(self.starts, self.speed.size))
        return np.asarray(np.add.reduceat(values, self.starts) / lengths)

    def piece(self, low: float, high: float) -> Vector:
        """What a unit viscous friction between two speeds adds to each row (m,)."""
        return self.sign * self.mean(np.clip(self.speed, low, high) - low)

    def share_beyond(self, knee: float) -> Vector:
        """The share (m,) of each part that is faster, signed."""
        return self.sign * self.mean((self.speed > knee).astype(np.float64))


@dataclass(frozen=True)
class PiecewiseFriction:
    """`solution` over [viscous of each piece, columns, derivatives by the knees]; `knees` rising,
    rad/s | m/s; `residual` (m,)."""

    solution: LeastSquaresSolution
    knees: tuple[float, ...]
    residual: Vector


def fit_pieces(means: StrokeMeans, most: int = MOST_KNEES) -> PiecewiseFriction:
    """The straight pieces that the rows ask for, at most `most` knees. Raises Singular where they
    do not even tell one piece."""
    knees: tuple[float, ...] = ()
    found: tuple[float, ...] = ()
    least = _criterion(means, knees)
    for _ in range(most):
        placed = _with_one_more(means, knees)
        if placed is None:
            break
        knees, value = placed, _criterion(means, placed)
        if value < least - EVIDENCE * (len(knees) - len(found)):
            found, least = knees, value
    return _solved(means, found)


def design(means: StrokeMeans, knees: tuple[float, ...]) -> Matrix:
    """The regressors (m, 1 + number of knees + p): the pieces, then the columns."""
    edges = (0.0, *knees, np.inf)
    return np.column_stack(
        [*(means.piece(low, high) for low, high in itertools.pairwise(edges)), means.columns]
    )


def _squares(means: StrokeMeans, knees: tuple[float, ...]) -> float:
    """The weighted sum of squares that these knees leave, and what the nuisance does not
    explain."""
    rows, right = design(means, knees), means.effort * means.weight
    if means.nuisance is not None:
        rows = np.column_stack((rows, means.nuisance))
    rows *= means.weight[:, None]
    return float(np.sum((right - rows @ np.linalg.lstsq(rows, right, rcond=None)[0]) ** 2))


def _criterion(means: StrokeMeans, knees: tuple[float, ...]) -> float:
    """Schwarz's: the less, the better."""
    count, parameters = (
        int(np.unique(means.cluster).size),
        means.columns.shape[1] + 1 + 2 * len(knees),
    )
    floor = (np.finfo(np.float64).eps * float(np.linalg.norm(means.effort * means.weight))) ** 2
    return float(
        count * np.log((_squares(means, knees) + floor) / count) + parameters * np.log(count)
    )


def _with_one_more(means: StrokeMeans, knees: tuple[float, ...]) -> tuple[float, ...] | None:
    """The best place of one knee more, the others placed anew, or None where there is no room."""
    slow = np.sort(means.mean(means.speed))
    fast = np.sort(np.maximum.reduceat(means.speed, means.starts))
    if slow.size < 2 * FEWEST_ROWS or slow[FEWEST_ROWS - 1] >= fast[-FEWEST_ROWS]:
        return None
    low, high = float(slow[FEWEST_ROWS - 1]), float(fast[-FEWEST_ROWS])
    places = np.linspace(low, high, PLACES)
    free = [
        float(place)
        for place in places
        if all(abs(place - knee) > 2.0 * (places[1] - places[0]) for knee in knees)
    ]
    if not free:
        return None
    current = [*knees, min(free, key=lambda place: _squares(means, (*knees, place)))]
    for _ in range(SWEEPS if len(current) > 1 else 1):
        for index, start in enumerate(current):
            others = tuple(knee for other, knee in enumerate(current) if other != index)
            reach = places[1] - places[0]
            bounds = (max(start - reach, low), min(start + reach, high))
            current[index] = float(
                minimize_scalar(
                    lambda place: _squares(means, (*others, place)),  # noqa: B023  # used at once
                    bounds=bounds,
                    method="bounded",
                ).x
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
