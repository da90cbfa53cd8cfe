"""What a test of sliding can tell at most: the Cramér-Rao bound, from the trajectory that it is planned to follow.

The equation of motion at sample k, with positions measured to a count and efforts to the noise of their measurement,

    inertia D2 x + viscous D1 x + coulomb sign(v) + offset = u + r,      r = e_u + (inertia D2 + viscous D1) e_x

D1 and D2 are central differences, e_u is white, e_x is white over a count (variance step^2/12, 4.2.2). r is a moving average of two
samples either way: over a stroke its covariance V has five diagonals. With regressors G (n, 4) of the trajectory a stroke tells

    M = G' V^-1 G

and strokes add up: the variance of no unbiased estimator is below the diagonal of M^-1. Where the axis passes less than a count a sample
e_x is a sawtooth and not white; it then disturbs low frequencies less than it is charged with here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

Vector = NDArray[np.float64]
SLIDING = ("inertia", "viscous", "coulomb", "offset")  # the order of the columns of G and of every bound
NOISE_COUNTS = 2.0  # past the backlash: as the slip mask leaves out
SLOWEST = 0.02  # of the top speed of a stroke


@dataclass(frozen=True)
class Sensing:
    """What is measured, and how well: period [s], step of the encoder [rad | m], noise of the effort (standard deviation) [N m | N]."""

    period: float
    step: float
    noise: float


@dataclass(frozen=True)
class Friction:
    """The a-priori axis in SI that a test is judged with; `backlash` is the full width that a stroke passes before it counts."""

    inertia: float
    viscous: float
    coulomb: float
    backlash: float = 0.0


@dataclass(frozen=True)
class Stroke:
    """A half sine of the position between two places: top speed V [rad/s | m/s], distance [rad | m] > 0, how often either way."""

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


def information(strokes: list[Stroke], axis: Friction, sensing: Sensing) -> Vector:
    """M (4, 4) of all strokes, each as often in one direction as in the other."""
    total = np.zeros((4, 4))
    for stroke in strokes:
        rows = regressors(stroke, axis, sensing)
        if rows.shape[0] < 2:
            continue
        whitened = solveh_banded(_covariance(rows.shape[0], axis, sensing), rows, lower=True, check_finite=False)
        one_way = rows.T @ whitened
        total += stroke.times * both_ways(one_way)
    return total


def both_ways(one_way: Vector) -> Vector:
    """(4, 4) of a forward stroke and of the same one backward: there a, v and sign(v) change their signs and the offset does not."""
    mirror = np.array([1.0, 1.0, 1.0, -1.0])
    return np.asarray(one_way + mirror[:, None] * one_way * mirror)


def cramer_rao(strokes: list[Stroke], axis: Friction, sensing: Sensing) -> Vector:
    """Least standard deviations (4,) of SLIDING in SI; inf where the strokes do not tell them."""
    matrix = information(strokes, axis, sensing)
    scale = np.sqrt(np.diag(matrix))
    if not np.all(scale > 0.0):
        return np.full(4, math.inf)
    unit = matrix / np.outer(scale, scale)
    if np.linalg.cond(unit) > 1e12:
        return np.full(4, math.inf)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(unit))) / scale)


def regressors(stroke: Stroke, axis: Friction, sensing: Sensing) -> Vector:
    """G (n, 4) of the samples of a forward stroke that slip for certain, past the backlash."""
    rate = math.pi / stroke.duration
    angle = rate * sensing.period * (np.arange(max(0, math.floor(stroke.duration / sensing.period))) + 0.5)
    advance, velocity = 0.5 * stroke.distance * (1.0 - np.cos(angle)), stroke.speed * np.sin(angle)
    free = axis.backlash + NOISE_COUNTS * sensing.step if axis.backlash > 0.0 else 0.0
    kept = (advance > free) & (velocity > SLOWEST * stroke.speed)
    ones = np.ones(int(np.count_nonzero(kept)))
    return np.column_stack((stroke.speed * rate * np.cos(angle)[kept], velocity[kept], ones, ones))


def _covariance(n: int, axis: Friction, sensing: Sensing) -> Vector:
    """V of n samples as its diagonals (3, n), the lower half."""
    variance = sensing.step**2 / 12.0
    second, first = axis.inertia / sensing.period**2, 0.5 * axis.viscous / sensing.period
    taps = np.array([second - first, -2.0 * second, second + first])
    out = np.zeros((3, n))
    for lag in range(3):
        out[lag] = variance * float(taps[: 3 - lag] @ taps[lag:])
    out[0] += sensing.noise**2
    return out
