"""Cramér-Rao bound of the sliding parameters for a test with a planned trajectory.

The equation of motion at sample k contains the measured position x and effort u with their errors
e_x and e_u:

    inertia D2 x + viscous D1 x + coulomb sign(v) + offset = u + r
    r = e_u + (inertia D2 + viscous D1) e_x

D1 and D2 are the first and the second central difference. e_u is white noise, and e_x is white
noise with the variance step^2/12. r depends on e_x at up to two samples on either side, so that the
covariance V of r over a stroke has five diagonals. With the regressors G (n, 4) of the trajectory,
a stroke has the information

    M = G' V^-1 G

The information of the test is the sum of M over all strokes. No unbiased estimator has a variance
below the diagonal of the inverse of this sum. If the bench declares loads (`load.terms`), G has an
additional column for each load parameter; the strokes are centred on the middle of the travel. If
the bench declares that there is no offset, G has no column for the offset.

Effects that a test must separate from friction and inertia (`PriorAxis.effects`) add columns to G.
A spring has the column x - middle. A delay of the effort has the column -du/dt, where u = inertia a
+ viscous v between the reversals. Along half sines of equal distance and duration, the acceleration
is proportional to x - middle, and du/dt is a sum of acceleration, speed and a constant. Only
strokes of different lengths therefore separate these effects from the parameters.

If the axis moves less than a count per sample, e_x is a sawtooth and not white noise. The power of
e_x at low frequencies is then smaller than assumed here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from frictool.identify.excite.stroke_profile import TOP_SPEED, unit_profile
from frictool.identify.rows.load_terms import SPRING
from frictool.typing import Vector

# order of the columns of G and of every bound
SLIDING = ("inertia", "viscous", "coulomb", "offset")
DELAY = "delay"
NOISE_COUNTS = 2.0  # distance from the end of the backlash, counts; closer samples are not used
SLOWEST = 0.02  # smallest speed of a used sample, relative to the top speed of the stroke


@dataclass(frozen=True)
class SensorPrecision:
    """Sample period [s], encoder step [rad | m] and noise (rms) of the effort [N m | N]."""

    period: float
    step: float
    noise: float


@dataclass(frozen=True)
class DeclaredLoads:
    """Loads that the bench declares in addition to friction.

    - offset: True if the effort may have an offset
    - terms: load terms, each with its wave number, 1/rad | 1/m
    - plain: True if the only load is an offset, so that every method can fit the loads
    """

    offset: bool = True
    terms: tuple[tuple[str, float], ...] = ()
    plain: bool = True


@dataclass(frozen=True)
class PriorAxis:
    """Axis with a-priori parameters in SI units, for the design of a test.

    - backlash: full width of the backlash, rad | m; samples inside the backlash are not used
    - middle: middle of the travel and of the strokes, rad | m
    - effects: effects of unknown size, `delay` or `spring`, each of which adds a regressor
    """

    inertia: float
    viscous: float
    coulomb: float
    backlash: float = 0.0
    loads: DeclaredLoads = DeclaredLoads()
    middle: float = 0.0
    effects: tuple[str, ...] = ()


@dataclass(frozen=True)
class PlannedStroke:
    """Stroke between two reversals, with a speed that is a half sine in time.

    - speed: top speed V, rad/s | m/s
    - distance: distance between the reversals, rad | m
    - times: number of repetitions in each direction
    """

    speed: float
    distance: float
    times: float = 1.0

    @property
    def duration(self) -> float:
        """Return the duration of one stroke, s, from distance = 2 V duration/pi."""
        return TOP_SPEED * self.distance / self.speed

    @property
    def frequency(self) -> float:
        """Return the frequency of the sine, Hz."""
        return 0.5 / self.duration


def information(strokes: list[PlannedStroke], axis: PriorAxis, sensing: SensorPrecision) -> Vector:
    """Return the information matrix (p, p) of all strokes, each in both directions.

    Rows and columns are in the order of the columns of `regressors`.
    """
    total: Vector | None = None
    for stroke in strokes:
        for side in (1.0, -1.0):
            rows = regressors(stroke, axis, sensing, side)
            total = np.zeros((rows.shape[1], rows.shape[1])) if total is None else total
            if rows.shape[0] >= 2:
                whitened = scipy.linalg.solveh_banded(
                    _covariance(rows.shape[0], axis, sensing), rows, lower=True, check_finite=False
                )
                total += stroke.times * (rows.T @ whitened)
    return np.zeros((4, 4)) if total is None else total


def of_sliding(values: Vector, axis: PriorAxis) -> Vector:
    """Return the inertia, viscous, Coulomb and offset entries (4,) of `values` (p,).

    If the axis has no offset, the offset entry is 0.
    """
    return np.asarray([*values[:3], values[3] if axis.loads.offset else 0.0])


def cramer_rao(strokes: list[PlannedStroke], axis: PriorAxis, sensing: SensorPrecision) -> Vector:
    """Return the least standard deviations (4,) of inertia, viscous, Coulomb and offset (SI).

    A standard deviation is inf if the test does not determine the parameter.
    """
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
    """Return the regressors (n, p) at the n samples of a stroke in slip outside the backlash.

    `side` is 1 for forward and -1 for backward. The columns are inertia, viscous friction, Coulomb
    friction, the offset if the axis has one, the loads, and the effects.
    """
    duration = stroke.duration
    samples = max(0, math.floor(duration / sensing.period))
    share = np.asarray(sensing.period / duration * (np.arange(samples) + 0.5))
    advance, speed, acceleration = unit_profile(share)
    advance = stroke.distance * advance
    velocity = stroke.distance / duration * speed
    acceleration = stroke.distance / duration**2 * acceleration
    free = axis.backlash + NOISE_COUNTS * sensing.step if axis.backlash > 0.0 else 0.0
    kept = (advance > free) & (velocity > SLOWEST * stroke.speed)
    ones = np.ones(int(np.count_nonzero(kept)))
    along = side * velocity[kept]
    columns = [
        side * acceleration[kept],
        along,
        side * ones,
        *([ones] if axis.loads.offset else []),
    ]
    position = axis.middle + side * (advance[kept] - 0.5 * stroke.distance)
    for term, wave in axis.loads.terms:
        columns += _of_term(term, wave, position, along)
    # derivative of the acceleration along a half sine
    jerk = -((math.pi / duration) ** 2) * along
    effects = {
        SPRING: position - axis.middle,
        DELAY: -(axis.inertia * jerk + axis.viscous * side * acceleration[kept]),
    }
    return np.column_stack([*columns, *(effects[name] for name in axis.effects)])


def _of_term(term: str, wave: float, position: Vector, velocity: Vector) -> list[Vector]:
    if wave > 0.0:
        return [np.sin(wave * position), np.cos(wave * position)]
    return [position if term == SPRING else np.minimum(velocity, 0.0)]


def _covariance(n: int, axis: PriorAxis, sensing: SensorPrecision) -> Vector:
    """Return the lower diagonals (3, n) of the noise covariance of n samples of a stroke."""
    variance = sensing.step**2 / 12.0
    second = axis.inertia / sensing.period**2
    first = 0.5 * axis.viscous / sensing.period
    taps = np.array([second - first, -2.0 * second, second + first])
    out = np.zeros((3, n))
    for lag in range(3):
        out[lag] = variance * float(taps[: 3 - lag] @ taps[lag:])
    out[0] += sensing.noise**2
    return out
