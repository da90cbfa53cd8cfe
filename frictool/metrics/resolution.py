"""The position sensor's step, as the record shows it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

NEAR_MULTIPLES = 100  # further multiples lose the grid to rounding
GRID_TOLERANCE = 0.02  # of a step


def seen_resolution(position: NDArray[np.float64]) -> float:
    """The smallest increment of `position` (n,), rad or m, where every small increment is a multiple of it; else 0 (no grid is seen).

    >>> seen_resolution(np.array([0.0, 0.5, 0.5, 2.0, 1.5]))
    0.5
    """
    increments = np.abs(np.diff(position))
    span = float(np.ptp(position)) if position.size else 0.0
    increments = increments[increments > 1e-9 * span]
    if increments.size == 0:
        return 0.0
    step = float(increments.min())
    multiples = increments[increments < NEAR_MULTIPLES * step] / step
    on_grid = bool(np.all(np.abs(multiples - np.round(multiples)) < GRID_TOLERANCE))
    return step if on_grid else 0.0
