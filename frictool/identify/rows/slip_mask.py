"""Mask of the samples at which the axis certainly slips in one direction with the load attached.

The mask follows thesis (4.18), with a threshold derived from the encoder and the motion. A sample
is used if all samples in its smoothing window

- are in one stroke without gaps;
- are farther from the beginning of the stroke than the backlash;
- move in the direction of the stroke at more than NOISE_COUNTS encoder counts per window, and at
  more than 2 % of the record's top speed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.strokes import Strokes
from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Vector

NOISE_COUNTS = 2.0  # least motion in a window, in counts; with less, the axis may be at rest
# share of the top speed; below it breakaway, Stribeck effect and stick-slip may act
SPEED_SHARE = 0.02


@kernel
def mark_slip(
    velocity: Vector,
    sign: Vector,
    advance: Vector,
    number: IntVector,
    slowest: float,
    gap: float,
    reach: int,
    mask: NDArray[np.bool_],
) -> None:
    """Set `mask` (n,) to True for samples that slip together with `reach` samples on either side.

    A sample slips if its velocity along the stroke exceeds `slowest`, and if the distance `advance`
    since the beginning of the stroke exceeds the backlash `gap`. The samples within `reach` must be
    in one stroke. A sample with a NaN velocity does not slip. The mask must be False before the
    call.
    """
    first = 0
    n = velocity.shape[0]
    for k in range(n + 1):
        free = k < n and velocity[k] * sign[k] > slowest and advance[k] > gap
        if not free or number[k] != number[first]:
            for i in range(first + reach, k - reach):
                mask[i] = True
            first = k if free else k + 1


def slip_mask(
    record: MotionRecord, strokes: Strokes, velocity: Vector, window: int, backlash: float
) -> NDArray[np.bool_]:
    """Return a mask (n,) of the samples at which the axis certainly slips.

    The module docstring states the conditions. `velocity` (n,) is smoothed over `window` samples,
    and may be NaN at the ends. `backlash` is the full width, rad | m.
    """
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
def keep_rows(mask: NDArray[np.bool_], values: Vector | IntVector) -> None:
    """Move the values selected by `mask` (n,) to the front of `values` (n,), in order."""
    kept = 0
    for k in range(mask.shape[0]):
        if mask[k]:
            values[kept] = values[k]
            kept += 1
