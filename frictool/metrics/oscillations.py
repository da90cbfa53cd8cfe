"""Number of oscillations until the axis stands still; thesis 5.4.1 allows one.

Two reversals are one oscillation; the number of oscillations is rounded up.
"""

from __future__ import annotations

import math

from frictool.metrics.reversals import reversals
from frictool.typing import Vector


def oscillations(position: Vector, origin: float, target: float, resolution: float = 0.0) -> int:
    """Return the number of oscillations of `position` (n,) after a step.

    The number is 0 if the position never enters the 95 % zone: final value ± the larger of 5 % of
    the step and one sensor step.
    """
    return math.ceil(reversals(position, origin, target, resolution) / 2)
