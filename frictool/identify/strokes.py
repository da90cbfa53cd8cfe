"""Strokes: what lies between two reversals of the motion. They are the units in which residuals are independent of each other."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.identify.record import Record, Vector
from frictool.kernels import kernel

COUNTS = 1.5  # a reversal shows by more counts than this: one count to and fro is the encoder's own doing
SHARE_OF_RANGE = 1e-3  # ... and by more than this fraction of the range, against the noise of a fine encoder


@kernel
def turning_points(position: Vector, threshold: float, points: NDArray[np.int64]) -> int:
    """Indices of the reversals of `position` (n,) that show by more than `threshold`.

    Writes them into `points` (n,), which is filled from 0, and returns their number; the first and last sample are not among them.
    """
    found, direction, extreme = 0, 0, 0
    lowest, highest = 0, 0
    for k in range(position.shape[0]):
        if direction == 0:
            if position[k] < position[lowest]:
                lowest = k
            if position[k] > position[highest]:
                highest = k
            if position[k] - position[lowest] > threshold:
                direction, extreme = 1, k
            elif position[highest] - position[k] > threshold:
                direction, extreme = -1, k
        elif direction * (position[k] - position[extreme]) >= 0.0:
            extreme = k
        elif direction * (position[extreme] - position[k]) > threshold:
            points[found] = extreme
            found += 1
            direction, extreme = -direction, k
    return found


@dataclass(frozen=True)
class Strokes:
    """`number` (n,) of the stroke of each sample, from 0; `sign` (n,) of its direction, 0 where there is no motion;

    `advance` (n,): how far, rad | m, the axis is from where the stroke began, positive along the stroke.
    """

    number: NDArray[np.int64]
    sign: Vector
    advance: Vector


def find_strokes(record: Record) -> Strokes:
    """The strokes of a record; a break of the clock ends one."""
    position = record.position
    threshold = max(COUNTS * record.resolution, SHARE_OF_RANGE * float(np.ptp(position)))
    number = np.zeros(position.size, dtype=np.int64)
    sign, advance = np.zeros(position.size), np.zeros(position.size)
    points = np.empty(position.size, dtype=np.int64)
    count = 0
    edges = np.concatenate(([0], np.flatnonzero(np.diff(record.piece)) + 1, [position.size]))
    for first, last in itertools.pairwise(edges):
        found = turning_points(position[first:last], threshold, points)
        starts = np.concatenate(([first], first + points[:found] + 1)).astype(np.int64)
        ends = np.concatenate((starts[1:], [last])).astype(np.int64)
        for start, end in zip(starts, ends, strict=True):
            origin = position[max(start - 1, first)]
            travel = position[end - 1] - origin
            direction = float(np.sign(travel)) if abs(travel) > threshold else 0.0
            number[start:end], sign[start:end] = count, direction
            advance[start:end] = direction * (position[start:end] - origin)
            count += 1
    return Strokes(number, sign, advance)
