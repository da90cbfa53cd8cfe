"""Overshoot beyond the reference."""

from __future__ import annotations

import numpy as np

from frictool.metrics.response_time import ROUNDED
from frictool.typing import Vector


def overshoot_percent(
    position: Vector, origin: float, target: float, resolution: float = 0.0
) -> float:
    """Return the overshoot of `position` (n,) beyond `target` in % of the step; 0 if there is none.

    An overshoot of at most one sensor step is treated as 0, since it may come from the sensor's
    rounding.
    """
    amplitude = target - origin
    excess = float(((position - target) * np.sign(amplitude)).max())
    return 100.0 * excess / abs(amplitude) if excess > resolution * ROUNDED else 0.0
