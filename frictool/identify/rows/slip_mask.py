"""Which samples of a record are certain to slip with the load attached, in one direction (the mask
of (4.18), without its tuning).

A sample is used where every sample that its smoothing window touches
    lies in one stroke and one unbroken piece of the clock,
    is past the backlash, counted from the stroke's beginning, and
    moves along the stroke faster than the encoder's noise in one window and than 2 % of the
    record's top speed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.rows.strokes import Strokes
from frictool.runtime.kernels import kernel

NOISE_COUNTS = 2.0  # a window that sees less motion than this many counts may stand still
SPEED_SHARE = 0.02  # of the top speed: below it breakaway, Stribeck effect and stick are near

Numbers = NDArray[np.int64]


@kernel
def mark_slip(
    velocity: Vector,
    sign: Vector,
    advance: Vector,
    number: Numbers,
    slowest: float,
    gap: float,
    reach: int,
    mask: NDArray[np.bool_],
) -> None:
    """Fills `mask` (n,), False before: True where velocity along the stroke is above `slowest` and
    the advance above `gap` over

    `reach` samples before and after, all of one stroke. A velocity that is nan does not slip.
    """
    first, n = 0, velocity.shape[0]
    for k in range(n + 1):
        free = k < n and velocity[k] * sign[k] > slowest and advance[k] > gap
        if not free or number[k] != number[first]:
            for i in range(first + reach, k - reach):
                mask[i] = True
            first = k if free else k + 1


def slip_mask(
    record: MotionRecord, strokes: Strokes, velocity: Vector, window: int, backlash: float
) -> NDArray[np.bool_]:
    """True (n,) where a sample is certain to slip; `velocity` (n,) may hold nan at the ends;
    `backlash` is the full width, rad | m."""
    mask = np.zeros(velocity.size, dtype=np.bool_)
    top = float(np.nanmax(velocity * strokes.sign, initial=0.0))
    slowest = max(NOISE_COUNTS * record.resolution / (window * record.period), SPEED_SHARE * top)
    gap = backlash + (2.0 * record.resolution if backlash > 0.0 else 0.0)
    mark_slip(
        velocity,
        strokes.sign,
        strokes.advance,
        strokes.number,
        slowest,
        gap,
        (window - 1) // 2,
        mask,
    )
    return mask


@kernel
def keep_rows(mask: NDArray[np.bool_], values: Vector | Numbers) -> None:
    """Moves the `values` (n,) where `mask` (n,) is True to the front, in order and in place."""
    kept = 0
    for k in range(mask.shape[0]):
        if mask[k]:
            values[kept] = values[k]
            kept += 1
