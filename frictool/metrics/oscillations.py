"""Oscillations before the axis stands still.

A *reversal* is a turn of the motion, after the position has first entered the 95 % zone, from which it moves back by more than two
sensor steps and more than 1 % of the step. Two reversals make one oscillation: an overshoot and its return (one reversal, or
two with the undershoot that follows) is one oscillation; three and four reversals are two.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.final_value import final_value
from frictool.metrics.response_time import zone_half_width

LEAST_RETURN = 0.01  # of the step
LEAST_SENSOR_STEPS = 2.0


def reversals(position: NDArray[np.float64], threshold: float) -> int:
    """Turns of `position` (n,) that start upwards, each followed by a way back of more than `threshold`."""
    increments = np.diff(position)
    moving = np.flatnonzero(increments)
    turns = moving[1:][np.sign(increments[moving[1:]]) != np.sign(increments[moving[:-1]])]
    extremes = [*position[:1], *position[turns], *position[-1:]]
    count, direction, extreme = 0, 1.0, float(position[0])
    for value in extremes:
        if direction * (value - extreme) > 0.0:
            extreme = value
        elif direction * (extreme - value) > threshold:
            count, direction, extreme = count + 1, -direction, value
    return count


def oscillations(position: NDArray[np.float64], origin: float, target: float, resolution: float = 0.0) -> int:
    """Number of oscillations of `position` (n,) after a step; 0 where the 95 % zone around the final value is not reached."""
    inside = np.flatnonzero(np.abs(position - final_value(position)) <= zone_half_width(origin, target, resolution))
    if inside.size == 0:
        return 0
    forward = position[inside[0] :] * math.copysign(1.0, target - origin)
    threshold = max(LEAST_SENSOR_STEPS * resolution, LEAST_RETURN * abs(target - origin))
    return math.ceil(reversals(forward, threshold) / 2)
