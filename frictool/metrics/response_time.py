"""Response time to 95 % of a step."""

from __future__ import annotations

import math

import numpy as np

from frictool.metrics.final_value import final_value, tail_samples
from frictool.typing import Vector

ZONE = 0.05  # half width of the zone, relative to the step's amplitude
# factor on a limit, so that a position exactly at the limit stays inside despite rounding
ROUNDED = 1.0 + 1e-9


def zone_half_width(origin: float, target: float, resolution: float) -> float:
    """Return the half width of the 95 % zone [rad or m]: 5 % of the step, at least `resolution`."""
    return max(ZONE * abs(target - origin), resolution) * ROUNDED


def response_time_95(
    time: Vector, position: Vector, origin: float, target: float, resolution: float = 0.0
) -> float:
    """Return the time [s] after which `position` stays in the 95 % zone around its final value.

    `time` and `position` (n,) are the samples after a step of the reference from `origin` to
    `target`. `resolution` is the step of the position sensor [rad or m]. `zone_half_width` returns
    the half width of the zone. The result is infinite if the position is outside the zone in the
    last tenth of the samples. The result is also infinite if the final value differs from the
    target by more than half of the step.
    """
    final = final_value(position)
    if abs(target - final) > 0.5 * abs(target - origin):
        return math.inf
    outside = (np.abs(position - final) > zone_half_width(origin, target, resolution)).nonzero()[0]
    if outside.size == 0:
        return 0.0
    last = int(outside[-1])
    if last >= position.size - tail_samples(position.size):
        return math.inf
    return float(time[last + 1] - time[0])
