"""One sine of the position (4.25), and how well it conditions the regression (4.30)-(4.33).

With the scaling (4.33) by sqrt(2)/V every top speed V is conditioned alike, at the 19 of (4.30)'s
minimum. What is left to choose is what (4.3) and (4.4) ask for: speed against a count a sample, and
acceleration, which grows with the frequency. Among the sines that the bench can do the one is taken
whose worst relative Cramér-Rao bound of inertia, viscous and Coulomb friction is least.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.cramer_rao import (
    PlannedStroke,
    PriorAxis,
    SensorPrecision,
    cramer_rao,
)
from frictool.identify.excite.half_sines import Motion, half_sine, joined, reachable_speed

BEST_SPEED = math.sqrt(2.0)  # where (4.30) is least
SHORTEST_COUNTS = 20.0  # of a stroke, besides the backlash
CHOICES = 24  # distances tried


def condition(speed: float) -> float:
    """kappa(M_2) of (4.30): the ratio of eigenvalues of viscous and Coulomb friction under a sine
    of this top speed."""
    half, product = 0.5 * speed**2 + 1.0, speed**2 * (0.5 - 4.0 / math.pi**2)
    largest = half + math.sqrt(half**2 - 4.0 * product)
    return largest**2 / (
        4.0 * product
    )  # the smallest eigenvalue as product/largest: its difference would cancel


def longest_distance(limits: BenchLimits) -> float:
    """Of a stroke: the travel; where it has no end, what 1 Hz at the top speed takes."""
    return limits.travel if math.isfinite(limits.travel) else limits.speed / math.pi


def best_stroke(
    limits: BenchLimits, axis: PriorAxis, sensing: SensorPrecision, duration: float
) -> PlannedStroke:
    """The sine whose worst relative bound is least over `duration` [s]."""
    longest = longest_distance(limits)
    shortest = min(longest, max(longest / 50.0, axis.backlash + SHORTEST_COUNTS * sensing.step))
    strokes = [
        _lasting(distance, limits, duration)
        for distance in np.geomspace(shortest, longest, CHOICES)
    ]
    return min(strokes, key=lambda stroke: worst(stroke, axis, sensing))


def _lasting(distance: float, limits: BenchLimits, duration: float) -> PlannedStroke:
    stroke = PlannedStroke(reachable_speed(limits, distance), distance)
    return PlannedStroke(stroke.speed, distance, duration / (2.0 * stroke.duration))


def worst(stroke: PlannedStroke, axis: PriorAxis, sensing: SensorPrecision) -> float:
    """The largest of the relative bounds (standard deviation over value) of what the axis has."""
    values = (axis.inertia, axis.viscous, axis.coulomb)
    return max(
        float(bound) / value
        for bound, value in zip(cramer_rao([stroke], axis, sensing), values, strict=False)
        if value > 0.0
    )


def sine(stroke: PlannedStroke, limits: BenchLimits, period: float) -> Motion:
    """The sine played round(times) periods at least, about the middle of the travel, from its low
    end."""
    middle = 0.5 * (limits.low + limits.high) if math.isfinite(limits.travel) else 0.0
    low, high = middle - 0.5 * stroke.distance, middle + 0.5 * stroke.distance
    there_and_back = [
        half_sine(low, high, stroke.speed, period),
        half_sine(high, low, stroke.speed, period),
    ]
    return joined(there_and_back * max(1, round(stroke.times)), low)
