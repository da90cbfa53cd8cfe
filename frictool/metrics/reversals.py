"""Reversals of the motion after a step.

A *reversal* is a change of the direction of motion after the position has first entered the 95 %
zone. After the turn the position must move back by more than two sensor steps and more than 1 % of
the step.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.metrics.final_value import final_value
from frictool.metrics.response_time import ROUNDED, zone_half_width
from frictool.typing import Vector

LEAST_RETURN = 0.01  # least motion back after a turn, relative to the step
LEAST_SENSOR_STEPS = 2.0  # least motion back after a turn, in sensor steps


def turning_points(position: Vector, threshold: float, direction: float = 0.0) -> list[int]:
    """Return the indices of turns after which `position` (n,) moves back by more than `threshold`.

    - threshold: distance [rad or m]
    - direction: initial direction of motion, 1 or -1; 0 to use the direction of the first motion
      that exceeds `threshold`
    """
    increments = position[1:] - position[:-1]
    moving = increments.nonzero()[0]
    rising = increments[moving] > 0.0
    turns = moving[1:][rising[1:] != rising[:-1]]
    turning: list[int] = []
    low = high = extreme = 0
    for sample in [*turns.tolist(), position.size - 1]:
        value = position[sample]
        if direction == 0.0:
            low = sample if value < position[low] else low
            high = sample if value > position[high] else high
            if position[high] - position[low] > threshold:
                direction, extreme = (1.0, high) if high > low else (-1.0, low)
        elif direction * (value - position[extreme]) > 0.0:
            extreme = sample
        elif direction * (position[extreme] - value) > threshold:
            turning.append(extreme)
            direction = -direction
            extreme = sample
    return turning


def reversals(position: Vector, origin: float, target: float, resolution: float = 0.0) -> int:
    """Return the number of reversals of `position` (n,) after a step.

    The number is 0 if the position never enters the 95 % zone: final value ± the larger of 5 % of
    the step and one sensor step.
    """
    zone = zone_half_width(origin, target, resolution)
    inside = (np.abs(position - final_value(position)) <= zone).nonzero()[0]
    if inside.size == 0:
        return 0
    least = max(LEAST_SENSOR_STEPS * resolution, LEAST_RETURN * abs(target - origin))
    direction = math.copysign(1.0, target - origin)
    return len(turning_points(position[inside[0] :], least * ROUNDED, direction))
