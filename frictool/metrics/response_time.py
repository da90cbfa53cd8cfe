"""Response time at 95 %."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.final_value import final_value, tail_samples

ZONE = 0.05  # of the step's amplitude


def zone_half_width(origin: float, target: float, resolution: float) -> float:
    """5 % of the step, rad or m; never below the sensor's step, within which a final value cannot
    be told."""
    return max(ZONE * abs(target - origin), resolution)


def response_time_95(
    time: NDArray[np.float64],
    position: NDArray[np.float64],
    origin: float,
    target: float,
    resolution: float = 0.0,
) -> float:
    """Time [s] from the step to the first sample from which `position` stays within 5 % of the
    step's amplitude around its final value.

    `time`, `position` (n,): the hold, from the step's sample on. Infinite where the axis does not
    settle (it still leaves the zone in the last tenth of the hold) or stops short of half of the
    step.
    """
    final = final_value(position)
    if abs(target - final) > 0.5 * abs(target - origin):
        return math.inf
    outside = np.flatnonzero(np.abs(position - final) > zone_half_width(origin, target, resolution))
    if outside.size == 0:
        return 0.0
    last = int(outside[-1])
    if last >= position.size - tail_samples(position.size):
        return math.inf
    return float(time[last + 1] - time[0])
