"""What a test of sliding can tell at most: the Cramér-Rao bound, from the trajectory that it is
planned to follow.

The equation of motion at sample k, with positions measured to a count and efforts to the noise of
their measurement,

    inertia D2 x + viscous D1 x + coulomb sign(v) + offset = u + r,      r = e_u + (inertia D2 +
                                                                         viscous D1) e_x

D1 and D2 are central differences, e_u is white, e_x is white over a count (variance step^2/12,
4.2.2). r is a moving average of two samples either way: over a stroke its covariance V has five
diagonals. With regressors G (n, 4) of the trajectory a stroke tells

    M = G' V^-1 G

and strokes add up. Where the bench names a load (`load.terms`), G has a column more for each of its
parameters, at the positions of strokes about the middle of the travel, and none for an offset that
is said to be none. The variance of no unbiased estimator is below the diagonal of M^-1. Where the
axis passes less than a count a sample e_x is a sawtooth and not white; it then disturbs low
frequencies less than it is charged with here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

Vector = NDArray[np.float64]
SLIDING = (
    "inertia",
    "viscous",
    "coulomb",
    "offset",
)  # the order of the columns of G and of every bound
NOISE_COUNTS = 2.0  # past the backlash: as the slip mask leaves out
SLOWEST = 0.02  # of the top speed of a stroke


@dataclass(frozen=True)
class SensorPrecision:
    """What is measured, and how well: period [s], step of the encoder [rad | m], noise of the
    effort (standard deviation) [N m | N]."""

    period: float
    step: float
    noise: float


@dataclass(frozen=True)
class DeclaredLoads:
    """What acts beside friction: an `offset`, and `terms` of rows/load_terms.py, each with its wave
    number, 1/rad | 1/m.

    plain: nothing but an offset, which every method knows.
    """

    offset: bool = True
    terms: tuple[tuple[str, float], ...] = ()
    plain: bool = True


@dataclass(frozen=True)
class PriorAxis:
    """The a-priori axis in SI that a test is judged with; `backlash` is the full width that a
    stroke passes before it counts.

    middle: of the travel, rad | m, about which strokes go.
    """

    inertia: float
    viscous: float
    coulomb: float
    backlash: float = 0.0
    beside: DeclaredLoads = DeclaredLoads()
    middle: float = 0.0


@dataclass(frozen=True)
class PlannedStroke:
    """A half sine of the position between two places: top speed V [rad/s | m/s], distance [rad | m]
    > 0, how often either way."""

    speed: float
    distance: float
    times: float = 1.0

    @property
    def duration(self) -> float:
        """s, of one stroke: distance = 2 V/w, half a period is pi/w."""
        return 0.5 * math.pi * self.distance / self.speed

    @property
    def frequency(self) -> float:
        """Hz of the sine, (4.25)."""
        return 0.5 / self.duration


def information(strokes: list[PlannedStroke], axis: PriorAxis, sensing: SensorPrecision) -> Vector:
    """M (p, p) of all strokes, each as often in one direction as in the other; p columns as of
    `regressors`."""
    total: Vector | None = None
    for stroke in strokes:
        for side in (1.0, -1.0):
            rows = regressors(stroke, axis, sensing, side)
            total = np.zeros((rows.shape[1], rows.shape[1])) if total is None else total
            if rows.shape[0] >= 2:
                whitened = solveh_banded(
                    _covariance(rows.shape[0], axis, sensing), rows, lower=True, check_finite=False
                )
                total += stroke.times * (rows.T @ whitened)
    return np.zeros((4, 4)) if total is None else total


def of_sliding(values: Vector, axis: PriorAxis) -> Vector:
    """Of values (p,) of all columns those (4,) of SLIDING; 0 of an offset that is none."""
    return np.asarray([*values[:3], values[3] if axis.beside.offset else 0.0])


def cramer_rao(strokes: list[PlannedStroke], axis: PriorAxis, sensing: SensorPrecision) -> Vector:
    """Least standard deviations (4,) of SLIDING in SI; inf where the strokes do not tell them."""
    matrix = information(strokes, axis, sensing)
    scale = np.sqrt(np.diag(matrix))
    if not np.all(scale > 0.0):
        return np.full(4, math.inf)
    unit = matrix / np.outer(scale, scale)
    if np.linalg.cond(unit) > 1e12:
        return np.full(4, math.inf)
    return of_sliding(np.sqrt(np.diag(np.linalg.inv(unit))) / scale, axis)


def regressors(
    stroke: PlannedStroke, axis: PriorAxis, sensing: SensorPrecision, side: float = 1.0
) -> Vector:
    """G (n, p) of the samples of a stroke forward, or backward (side -1), that slip for certain,
    past the backlash.

    Columns: SLIDING, without an offset that is none, then what acts beside.
    """
    rate = math.pi / stroke.duration
    angle = (
        rate
        * sensing.period
        * (np.arange(max(0, math.floor(stroke.duration / sensing.period))) + 0.5)
    )
    advance, velocity = 0.5 * stroke.distance * (1.0 - np.cos(angle)), stroke.speed * np.sin(angle)
    free = axis.backlash + NOISE_COUNTS * sensing.step if axis.backlash > 0.0 else 0.0
    kept = (advance > free) & (velocity > SLOWEST * stroke.speed)
    ones, speed = np.ones(int(np.count_nonzero(kept))), side * velocity[kept]
    columns = [
        side * stroke.speed * rate * np.cos(angle)[kept],
        speed,
        side * ones,
        *([ones] if axis.beside.offset else []),
    ]
    position = axis.middle + side * (advance[kept] - 0.5 * stroke.distance)
    for term, wave in axis.beside.terms:
        columns += _of_term(term, wave, position, speed)
    return np.column_stack(columns)


def _of_term(term: str, wave: float, position: Vector, velocity: Vector) -> list[Vector]:
    """The columns (n,) of a term of rows/load_terms.py."""
    if wave > 0.0:
        return [np.sin(wave * position), np.cos(wave * position)]
    return [position if term == "spring" else np.minimum(velocity, 0.0)]


def _covariance(n: int, axis: PriorAxis, sensing: SensorPrecision) -> Vector:
    """V of n samples as its diagonals (3, n), the lower half."""
    variance = sensing.step**2 / 12.0
    second, first = axis.inertia / sensing.period**2, 0.5 * axis.viscous / sensing.period
    taps = np.array([second - first, -2.0 * second, second + first])
    out = np.zeros((3, n))
    for lag in range(3):
        out[lag] = variance * float(taps[: 3 - lag] @ taps[lag:])
    out[0] += sensing.noise**2
    return out
