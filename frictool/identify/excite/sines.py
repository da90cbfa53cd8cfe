"""Sines at several speeds (thesis 4.38): half sines between reversals, one speed after the other.

Each reversal is at a random position, within the last tenth of the distance. Strokes between
identical positions would have identical encoder errors, which averaging does not reduce.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.cramer_rao import PlannedStroke
from frictool.identify.excite.half_sines import Motion, half_sine, joined, reachable_speed
from frictool.identify.excite.sine import longest_distance

SPEEDS = 6
SLOWEST_SHARE = 0.2  # slowest speed relative to the fastest; slower strokes stick
SPREAD = 0.1  # share of the distance at either end over which the reversal positions vary
DURATION = 30.0  # s, default


def plan(
    limits: BenchLimits,
    duration: float = DURATION,
    speeds: int = SPEEDS,
    distance: float | None = None,
) -> list[PlannedStroke]:
    """Return one stroke of mean length for each speed, with its number of repetitions.

    Each speed lasts for an equal part of `duration` [s].
    """
    mean = (distance or longest_distance(limits)) * (1.0 - SPREAD)
    fastest = reachable_speed(limits, mean / (1.0 - SPREAD) * (1.0 - 2.0 * SPREAD))
    strokes = [
        PlannedStroke(float(speed), mean)
        for speed in np.linspace(SLOWEST_SHARE, 1.0, speeds) * fastest
    ]
    return [
        PlannedStroke(one.speed, mean, max(1, round(duration / (speeds * 2.0 * one.duration))))
        for one in strokes
    ]


def sines(strokes: list[PlannedStroke], limits: BenchLimits, period: float, seed: int) -> Motion:
    """Return position, velocity and acceleration (n,) of strokes, one speed after the other.

    `seed` determines the random reversal positions.
    """
    draw = np.random.default_rng(seed)
    middle = 0.5 * (limits.low + limits.high) if math.isfinite(limits.travel) else 0.0
    reach = 0.5 * strokes[0].distance / (1.0 - SPREAD)

    def turn(side: float) -> float:
        return middle + side * (reach - draw.uniform(0.0, 2.0 * SPREAD * reach))

    here = turn(-1.0)
    parts = []
    for stroke in strokes:
        for _ in range(round(stroke.times)):
            for side in (1.0, -1.0):
                end = turn(side)
                parts.append(half_sine(here, end, stroke.speed, period))
                here = end
    return joined(parts, here)
