"""Strokes (motions between two reversals), whose residuals are taken as independent."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.smoothing import position_noise
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

# least motion back after a reversal, in encoder counts; quantisation alone causes a motion of one
# count back and forth
COUNTS = 1.5
# least motion back after a reversal, relative to the range; noise of a fine encoder causes less
SHARE_OF_RANGE = 1e-3
# least motion back after a reversal, in standard deviations of the position noise, if this standard
# deviation exceeds an encoder count
NOISES = 8.0


@kernel
def turning_points(position: Vector, threshold: float, points: NDArray[np.int64]) -> int:
    """Write the indices of the reversals of `position` (n,) into `points`; return their number.

    A change of direction is a reversal if the position then moves back by more than `threshold`.
    The first and the last sample are not reversals.
    """
    count, direction, extreme = 0, 0, 0
    lowest, highest = 0, 0
    for k in range(position.shape[0]):
        if direction == 0:
            if position[k] < position[lowest]:
                lowest = k
            if position[k] > position[highest]:
                highest = k
            if position[k] - position[lowest] > threshold:
                direction = 1
                extreme = k
            elif position[highest] - position[k] > threshold:
                direction = -1
                extreme = k
        elif direction * (position[k] - position[extreme]) >= 0.0:
            extreme = k
        elif direction * (position[extreme] - position[k]) > threshold:
            points[count] = extreme
            count += 1
            direction = -direction
            extreme = k
    return count


@kernel
def fill_strokes(
    position: Vector,
    starts: NDArray[np.int64],
    fresh: NDArray[np.bool_],
    threshold: float,
    number: NDArray[np.int64],
    sign: Vector,
    advance: Vector,
) -> None:
    """Compute the fields `number`, `sign` and `advance` (n,) of `Strokes`.

    - starts: first sample of each stroke, (m,)
    - fresh: True for the first stroke after a gap, (m,)
    - threshold: least distance of a stroke; a shorter stroke counts as rest, rad | m
    """
    n, strokes = position.shape[0], starts.shape[0]
    for stroke in range(strokes):
        start = starts[stroke]
        end = starts[stroke + 1] if stroke + 1 < strokes else n
        origin = position[start if fresh[stroke] else start - 1]
        travel = position[end - 1] - origin
        direction = 0.0
        if abs(travel) > threshold:
            direction = 1.0 if travel > 0.0 else -1.0
        for k in range(start, end):
            number[k] = stroke
            sign[k] = direction
            advance[k] = direction * (position[k] - origin)


@dataclass(frozen=True)
class Strokes:
    """Stroke (motion between two reversals) to which each sample of a record belongs.

    - number: number of the stroke, from 0, (n,)
    - sign: direction +-1, or 0 without motion, (n,)
    - advance: distance moved since the stroke's beginning, (n,), rad | m
    """

    number: NDArray[np.int64]
    sign: Vector
    advance: Vector


def find_strokes(record: MotionRecord) -> Strokes:
    """Return the strokes (motions between two reversals) of a record; a gap ends a stroke."""
    position = record.position
    threshold = max(COUNTS * record.resolution, SHARE_OF_RANGE * float(np.ptp(position)))
    noise = position_noise(record)
    if noise > record.resolution:
        threshold = max(threshold, NOISES * noise)
    points = np.empty(position.size, dtype=np.int64)
    edges = np.concatenate(([0], np.flatnonzero(np.diff(record.piece)) + 1, [position.size]))
    turns = [
        first + points[: turning_points(position[first:last], threshold, points)] + 1
        for first, last in itertools.pairwise(edges)
    ]
    starts = np.sort(np.concatenate((edges[:-1], *turns)).astype(np.int64))
    number = np.empty(position.size, dtype=np.int64)
    sign = np.empty(position.size)
    advance = np.empty(position.size)
    fill_strokes(position, starts, np.isin(starts, edges), threshold, number, sign, advance)
    return Strokes(number, sign, advance)
