"""Bounds of the load's position behind a backlash, computed from the motor's position.

|motor - load| <= backlash/2, and the load stays at rest while the backlash is open (thesis 4.45).
The play operator therefore gives the load's position from the motor's position. The load's position
increases with the motor's position and with the load's unknown initial position. The lowest values
of these two positions give the lower bound, the highest values the upper bound. After a motion
longer than the backlash, the distance between the bounds depends only on the sensor's step and the
interval of the backlash.
"""

from __future__ import annotations

import numpy as np

from frictool.metrics.final_value import final_value, tail_samples
from frictool.metrics.overshoot import overshoot_percent
from frictool.metrics.static_error import moves
from frictool.typing import Vector


def load_bounds(position: Vector, backlash: float, unsure: float) -> tuple[Vector, Vector]:
    """Return the lower and upper bound (n,) [rad or m] of the load's position behind a backlash.

    - position: motor positions (n,) [rad or m]
    - backlash: full width [rad or m]
    - unsure: largest error of a motor position plus half the largest error of the backlash
      [rad or m]
    """
    half = 0.5 * backlash
    low = _play(position, half, float(position[0]) - half)
    high = _play(position, half, float(position[0]) + half)
    return low - unsure, high + unsure


def load_static_error(
    load: tuple[Vector, Vector], target: float, resolution: float = 0.0
) -> tuple[float, float]:
    """Return the lower and upper bound of the load's static error [rad or m].

    - load: result of `load_bounds`
    - resolution: sensor step [rad or m], 0 if unknown

    If the load may still move at the end of the hold, the largest error at the end is bounded
    instead (static_error.py).
    """
    ends = [one[-tail_samples(one.size) :] for one in load]
    if any(moves(end, resolution) for end in ends):
        below, above = ends[0] - target, target - ends[1]
        least = float(np.max(np.maximum(np.maximum(below, above), 0.0)))
        return least, float(np.max(np.abs([below, above])))
    low, high = map(final_value, load)
    errors = abs(target - low), abs(target - high)
    return 0.0 if low <= target <= high else min(errors), max(errors)


def load_overshoot(
    load: tuple[Vector, Vector], origin: float, target: float
) -> tuple[float, float]:
    """Return (lower, upper) bound of the load's overshoot [% of the step].

    - load: lower and upper bound (n,) of the load's position
    - origin and target: reference before and after the step
    """
    low, high = sorted(overshoot_percent(one, origin, target) for one in load)
    return low, high


def _play(position: Vector, half: float, start: float) -> Vector:
    """Return the load's position y: y[k] is the value nearest to y[k-1] in position[k] +- `half`.

    `start` is y[-1].
    """
    load = start
    out = []
    for value in position.tolist():
        load = min(max(load, value - half), value + half)
        out.append(load)
    return np.array(out)
