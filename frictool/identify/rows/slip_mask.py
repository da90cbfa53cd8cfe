"""Mask of the samples at which the axis certainly slips in one direction with the load attached.

The mask follows thesis (4.18), with a threshold derived from the encoder and the motion. A sample
is used if all samples in its smoothing window

- are in one stroke without gaps;
- have the backlash closed: if the bench has a backlash, they are farther from the beginning of the
  stroke than the backlash plus two encoder steps;
- move in the direction of the stroke at more than NOISE_COUNTS encoder counts per window, and at
  more than 2 % of the record's top speed.

Two velocities must meet the last condition:

- The first velocity is smoothed over the window. Up to half a window before and after a motion,
  this velocity is not 0, although the axis rests.
- The second velocity is the mean over the shortest motion that the encoder certainly shows
  (`mean_velocity`), and 0 where the axis may rest at the end of a stroke. This velocity is also set
  to 0 where the axis may rest between faster parts of a stroke (`remove_rests`).

If the position sensor has a lag, the true velocity is the reported velocity plus the lag times its
derivative. The true velocity then replaces the first velocity. Because the effort is filtered by
the same lag, the first SETTLED time constants of each slip are not used: the filtered friction
still contains the effort before this slip.

Even a few samples at rest would shift the parameters, because the effort at rest takes any value up
to the breakaway.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.smoothing import position_noise
from frictool.identify.rows.strokes import COUNTS, Strokes
from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Vector

NOISE_COUNTS = 2.0  # least motion in a window, counts; with less motion, the axis may be at rest
# share of the top speed; below this speed, breakaway, Stribeck effect and stick-slip may act
SPEED_SHARE = 0.02
# speed between two faster parts of a stroke, relative to the slower of these parts, below which the
# axis may rest
REST_SHARE = 0.1
SETTLED = 4.0  # time constants after which a filtered change of the friction is below 2 %
# An axis that turns without a rest stays in the last count of a stroke for at most TURN times the
# duration of one count at the speed before this count.
TURN = 4.0


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
    if record.sensor_lag > 0.0:
        velocity = velocity + record.sensor_lag * np.gradient(velocity, record.period)
    top = float(np.nanmax(velocity * strokes.sign, initial=0.0))
    slowest = max(NOISE_COUNTS * record.resolution / (window * record.period), SPEED_SHARE * top)
    gap = backlash + (2.0 * record.resolution if backlash > 0.0 else 0.0)
    certain = np.empty(velocity.size)
    mean_velocity(record.position, strokes.number, _certain_motion(record), record.period, certain)
    certain *= strokes.sign
    remove_rests(certain, strokes.number, np.empty(velocity.size))
    along = np.minimum(velocity * strokes.sign, certain)
    if record.sensor_lag > 0.0:
        settled = round(SETTLED * record.sensor_lag / record.period)
        starts = np.flatnonzero(np.diff(along > slowest, prepend=False) & (along > slowest))
        first = np.minimum(starts[:, None] + np.arange(settled), along.size - 1)
        along[first.ravel()] = 0.0
    mark_slip(
        strokes.sign * along,
        strokes.sign,
        strokes.advance,
        strokes.number,
        slowest,
        gap,
        (window - 1) // 2,
        mask,
    )
    return mask


def _certain_motion(record: MotionRecord) -> float:
    """Return the smallest change of position [rad | m] that noise alone cannot cause."""
    return COUNTS * math.sqrt(12.0) * position_noise(record)


@kernel
def mean_velocity(
    position: Vector, number: IntVector, distance: float, period: float, out: Vector
) -> None:
    """Fill `out` (n,) with mean velocities, each over the time in which the axis moves `distance`.

    `number` (n,) is the number of the stroke of each sample. The first motion begins at the
    beginning of the stroke, and each further motion at the end of the previous one. The last motion
    of a stroke may be shorter: it ends where the last position of the stroke is first reached.

    After this end, the axis rests or turns. An axis that turns with a constant deceleration,
    without a rest, stays in its last count for at most TURN c/v. Here c [rad | m] is the encoder
    count, and v the speed before the last count. If the axis stays longer, the velocity in this
    count is 0, else the velocity of the last motion.
    """
    turn = TURN / COUNTS * distance
    first = 0
    n = position.shape[0]
    for k in range(1, n + 1):
        if k == n or number[k] != number[first]:
            reached = first
            while position[reached] != position[k - 1]:
                reached += 1
            if reached > first:
                out[first:reached] = (position[reached] - position[first]) / (
                    (reached - first) * period
                )
            last = out[reached - 1] if reached > 0 and number[reached - 1] == number[first] else 0.0
            out[reached:k] = last if abs(last) * (k - reached) * period <= turn else 0.0
            first = k
        elif abs(position[k] - position[first]) >= distance:
            out[first:k] = (position[k] - position[first]) / ((k - first) * period)
            first = k


@kernel
def remove_rests(speed: Vector, number: IntVector, before: Vector) -> None:
    """Set the speed (n,) to 0 where the axis may rest between faster parts of a stroke.

    At such samples, the speed is below REST_SHARE times an earlier speed in the stroke, and below
    REST_SHARE times a later speed. `number` is the number of the stroke of each sample, (n,).
    `before` (n,) is a work array.
    """
    n = speed.shape[0]
    fastest = 0.0
    for k in range(n):
        fastest = max(fastest if k > 0 and number[k] == number[k - 1] else 0.0, speed[k])
        before[k] = fastest
    for k in range(n - 1, -1, -1):
        fastest = max(fastest if k < n - 1 and number[k] == number[k + 1] else 0.0, speed[k])
        if speed[k] < REST_SHARE * min(before[k], fastest):
            speed[k] = 0.0


@kernel
def keep_rows(mask: NDArray[np.bool_], values: Vector | IntVector) -> None:
    """Move the values selected by `mask` (n,) to the front of `values` (n,), in order."""
    kept = 0
    for k in range(mask.shape[0]):
        if mask[k]:
            values[kept] = values[k]
            kept += 1
