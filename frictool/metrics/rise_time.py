"""Rise time from 10 to 90 %."""

from __future__ import annotations

import math

import numpy as np

from frictool.metrics.final_value import final_value
from frictool.typing import Vector

FROM, TO = 0.1, 0.9  # levels, relative to the distance that the axis moves
LEAST_SHARE = 0.01  # least distance relative to the step; an axis that moves less has rise time 0


def rise_time(time: Vector, position: Vector, origin: float, target: float) -> float:
    """Return the time [s] in which the position moves from 10 to 90 % of its total displacement.

    The displacement is measured from the position at the step to the final value. `time` and
    `position` (n,) are the samples after a step of the reference from `origin` to `target`. The
    first passages through 10 and 90 % count, interpolated between samples. The result is infinite
    if the final value differs from the target by more than half of the step. Otherwise the result
    is 0 if the axis moves by at most 1 % of the step.
    """
    final = final_value(position)
    start = float(position[0])
    step = abs(target - origin)
    if abs(target - final) > 0.5 * step:
        return math.inf
    if abs(final - start) <= LEAST_SHARE * step:
        return 0.0
    share = (position - start) / (final - start)
    return _passage(time, share, TO) - _passage(time, share, FROM)


def _passage(time: Vector, share: Vector, level: float) -> float:
    k = int(np.argmax(share >= level))
    part = (level - share[k - 1]) / (share[k] - share[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))
