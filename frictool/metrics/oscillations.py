"""Oscillations before the axis stands still: thesis 5.4.1 allows one.

Two reversals make one oscillation: an overshoot and its return (one reversal, or two with the
undershoot that follows) is one oscillation; three and four reversals are two.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.reversals import reversals


def oscillations(
    position: NDArray[np.float64], origin: float, target: float, resolution: float = 0.0
) -> int:
    """Number of oscillations of `position` (n,) after a step; 0 where the 95 % zone around the
    final value is not reached."""
    return math.ceil(reversals(position, origin, target, resolution) / 2)
