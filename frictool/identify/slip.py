"""Which samples of a record are certain to slip with the load attached, in one direction (the mask of (4.18), without its tuning).

A sample is used where every sample that its smoothing window touches
    lies in one stroke and one unbroken piece of the clock,
    is past the backlash, counted from the stroke's beginning, and
    moves along the stroke faster than the encoder's noise in one window and than 2 % of the record's top speed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.identify.record import Record, Vector
from frictool.identify.strokes import Strokes

NOISE_COUNTS = 2.0  # a window that sees less motion than this many counts may stand still
SPEED_SHARE = 0.02  # of the top speed: below it breakaway, Stribeck effect and stick are near


def slip_mask(record: Record, strokes: Strokes, velocity: Vector, window: int, backlash: float) -> NDArray[np.bool_]:
    """True (n,) where a sample is certain to slip; `velocity` (n,) may hold nan at the ends; `backlash` is the full width, rad | m."""
    finite = np.isfinite(velocity)
    if not finite.any():
        return finite
    along = np.where(finite, velocity, 0.0) * strokes.sign
    slowest = max(NOISE_COUNTS * record.resolution / (window * record.period), SPEED_SHARE * float(along.max()))
    margin = 2.0 * record.resolution if backlash > 0.0 else 0.0
    free = finite & (along > slowest) & (strokes.advance > backlash + margin)
    reach = (window - 1) // 2
    return _all_around(free, strokes.number, reach)


def _all_around(free: NDArray[np.bool_], number: NDArray[np.int64], reach: int) -> NDArray[np.bool_]:
    """True (n,) where `free` holds from `reach` samples before to `reach` samples after, all in one stroke."""
    n = free.size
    blocked = np.concatenate(([0], np.cumsum(~free)))
    first, last = np.arange(n) - reach, np.arange(n) + reach
    inside = (first >= 0) & (last < n)
    first, last = np.clip(first, 0, n - 1), np.clip(last, 0, n - 1)
    return np.asarray(inside & (blocked[last + 1] == blocked[first]) & (number[first] == number[last]))
