"""A set of sines over speeds for (4.38): half strokes between turning places, several speeds one
after the other.

Turning places are drawn anew for each stroke, from a seed, over a tenth of the travel: strokes that
repeat each other to the count repeat the encoder's error too, which no averaging then removes.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.cramer_rao import PlannedStroke
from frictool.identify.excite.half_sines import Motion, half_sine, joined, reachable_speed
from frictool.identify.excite.sine import longest_distance

SPEEDS = 6
SLOWEST_SHARE = 0.2  # of the fastest: slower ones stick
SPREAD = 0.1  # of the distance, at either end, over which strokes turn
DURATION = 30.0  # s


def plan(
    limits: BenchLimits,
    duration: float = DURATION,
    speeds: int = SPEEDS,
    distance: float | None = None,
) -> list[PlannedStroke]:
    """The mean stroke of each speed, and how often it is made there and back; each speed has an
    equal share of `duration` [s]."""
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
    """The strokes of a plan, one speed after the other, each turning at places of its own."""
    draw = np.random.default_rng(seed)
    middle = 0.5 * (limits.low + limits.high) if math.isfinite(limits.travel) else 0.0
    reach = 0.5 * strokes[0].distance / (1.0 - SPREAD)

    def turn(side: float) -> float:
        return middle + side * (reach - draw.uniform(0.0, 2.0 * SPREAD * reach))

    here, parts = turn(-1.0), []
    for stroke in strokes:
        for _ in range(round(stroke.times)):
            for side in (1.0, -1.0):
                end = turn(side)
                parts.append(half_sine(here, end, stroke.speed, period))
                here = end
    return joined(parts, here)
