"""Sine of the position, and the condition number of its regression (thesis 4.30 to 4.33).

If the equation is scaled by sqrt(2)/V with the top speed V, the condition number is 19 for every V,
the least possible value. The sine is therefore chosen by another criterion. For each sine that the
bench can follow, the largest of the relative Cramér-Rao bounds of inertia, viscous and Coulomb
friction is computed. The sine with the smallest result is chosen.
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

BEST_SPEED = math.sqrt(2.0)  # top speed with the smallest condition number (4.30)
SHORTEST_COUNTS = 20.0  # least length of a stroke minus the backlash, in encoder counts
CHOICES = 24  # number of distances tried


def condition(speed: float) -> float:
    """Return the condition number of the regression of friction along a sine (thesis 4.30).

    The regressors belong to viscous and Coulomb friction. `speed` is the top speed of the sine,
    rad/s | m/s.
    """
    half = 0.5 * speed**2 + 1.0
    product = speed**2 * (0.5 - 4.0 / math.pi**2)
    largest = half + math.sqrt(half**2 - 4.0 * product)
    # the smallest eigenvalue is product/largest; computed as a difference, it would lose its digits
    return largest**2 / (4.0 * product)


def longest_distance(limits: BenchLimits) -> float:
    """Return the length of the longest stroke [rad | m], which equals the travel.

    If the travel is infinite, return the length of a stroke of a 1 Hz sine at top speed.
    """
    return limits.travel if math.isfinite(limits.travel) else limits.speed / math.pi


def best_stroke(
    limits: BenchLimits, axis: PriorAxis, sensing: SensorPrecision, duration: float
) -> PlannedStroke:
    """Return the stroke of the sine that determines the parameters best within `duration` [s].

    The stroke minimises `largest_relative_bound`.
    """
    longest = longest_distance(limits)
    shortest = min(longest, max(longest / 50.0, axis.backlash + SHORTEST_COUNTS * sensing.step))
    strokes = [
        _lasting(distance, limits, duration)
        for distance in np.geomspace(shortest, longest, CHOICES)
    ]
    return min(strokes, key=lambda stroke: largest_relative_bound(stroke, axis, sensing))


def _lasting(distance: float, limits: BenchLimits, duration: float) -> PlannedStroke:
    stroke = PlannedStroke(reachable_speed(limits, distance), distance)
    return PlannedStroke(stroke.speed, distance, duration / (2.0 * stroke.duration))


def largest_relative_bound(
    stroke: PlannedStroke, axis: PriorAxis, sensing: SensorPrecision
) -> float:
    """Return the largest relative Cramér-Rao bound of inertia, viscous and Coulomb friction.

    A relative bound is the bound divided by the parameter; parameters that are 0 are left out.
    """
    values = (axis.inertia, axis.viscous, axis.coulomb)
    return max(
        float(bound) / value
        for bound, value in zip(cramer_rao([stroke], axis, sensing), values, strict=False)
        if value > 0.0
    )


def sine(stroke: PlannedStroke, limits: BenchLimits, period: float) -> Motion:
    """Return position, velocity and acceleration (n,) of a sine around the middle of the travel.

    The motion starts at the lowest position. The number of periods is `stroke.times`, rounded, but
    at least one.
    """
    middle = 0.5 * (limits.low + limits.high) if math.isfinite(limits.travel) else 0.0
    low = middle - 0.5 * stroke.distance
    high = middle + 0.5 * stroke.distance
    there_and_back = [
        half_sine(low, high, stroke.speed, period),
        half_sine(high, low, stroke.speed, period),
    ]
    return joined(there_and_back * max(1, round(stroke.times)), low)
