"""Recognition of breakaway ramps.

In a breakaway ramp, the drive signal rises along a line while the axis rests. Then the axis starts,
and the drive signal falls back. A log of breakaway ramps has several ramps.

A creeping axis also rests between two counts of its encoder. During such a rest, the drive signal
of a servo also rises along a line, by the servo's gain times one count. The height of the rise
distinguishes a ramp from creep. In a ramp, the drive begins at a low level and rises by at least
half of the friction. The axis then starts in the direction of the drive. If the axis creeps, the
drive changes by a small share of its level. If the axis follows a load such as gravity, the drive
brakes the load.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from frictool.typing import Vector

REST = 30  # least number of samples of a rest: enough to fit a line to the drive
STRAIGHT = 0.8  # least squared correlation of drive and time in the second half of a rest
BLOCKS = 32  # least number of means from which this correlation is computed; fewer for few samples
# least rise in the second half of a rest, relative to the drive at the start of the motion; a ramp
# from 0 has 0.5
RISE = 0.25
FEWEST_RAMPS = 5  # least number of ramps
RAMP_SHARE = 0.75  # least duration of all ramps, relative to all rests that end in motion
REST_SHARE = 0.5  # least duration of all rests, relative to the duration of the log


def rests_of(moved: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return (first sample, index after the last sample) of each rest of at least REST samples.

    moved: array (n - 1,) that is True where the position changes between two samples.
    """
    edges = [0, *(np.flatnonzero(moved) + 1).tolist()]
    return [(start, end) for start, end in itertools.pairwise(edges) if end - start >= REST]


def without_flicker(position: Vector, count: float) -> Vector:
    """Return the position (n,) without flicker between two neighbouring counts of an encoder.

    Flicker is a sequence of three or more changes by one count whose signs alternate. It occurs if
    the axis rests near the edge of a count and vibrates, or if the sensor is noisy. During the
    flicker, the result is the position after the flicker.

    count: encoder step, in the unit of the position.
    """
    steps = np.diff(position)
    changes = np.flatnonzero(np.abs(steps) > 0.5 * count)
    size = steps[changes]
    single = np.abs(size) < 1.5 * count
    returns = single[:-1] & single[1:] & (size[:-1] * size[1:] < 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], returns.astype(np.int8), [0]))))
    steady = position.copy()
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if last - first > 1:
            after = changes[last] + 1
            steady[changes[first] + 1 : after] = position[after]
    return steady


def are_ramps(rests: Sequence[tuple[int, int]], position: Vector, drive: Vector) -> bool:
    """Return True if a log consists of breakaway ramps; for the parameters see `ramps_among`."""
    if resting_time(rests) < REST_SHARE * position.size:
        return False
    ramps = ramps_among(rests, position, drive)
    enough = int(np.sum(ramps)) >= FEWEST_RAMPS
    return enough and ramp_share(rests, ramps, position) >= RAMP_SHARE


def resting_time(rests: Sequence[tuple[int, int]]) -> int:
    """Return the number of samples in all rests."""
    return sum(end - start for start, end in rests)


def ramp_share(
    rests: Sequence[tuple[int, int]], ramps: NDArray[np.bool_], position: Vector
) -> float:
    """Return the duration of all ramps, divided by the duration of all rests that end in motion.

    `ramps`: result of `ramps_among`.
    """
    length = np.array([end - start for start, end in rests], dtype=np.int64)
    moved = np.array([_direction(position, end) != 0.0 for _, end in rests], dtype=np.bool_)
    return float(np.sum(length[ramps])) / max(float(np.sum(length[moved])), 1.0)


def ramps_among(
    rests: Sequence[tuple[int, int]], position: Vector, drive: Vector
) -> NDArray[np.bool_]:
    """Return a mask (m,) that is True at each rest that is a breakaway ramp.

    rests: (first sample, index after the last sample) of each of m rests of at least REST samples.
    position: position (n,) in any unit.
    drive: effort, current or voltage (n,) in any unit.

    If the axis starts in both directions, the constant part of the drive signal is estimated and
    subtracted. This part comes from a load or from the offset of a sensor.
    """
    direction = np.array([_direction(position, end) for _, end in rests])
    lines = [
        _line(side * drive[start:end]) for (start, end), side in zip(rests, direction, strict=True)
    ]
    level, rise, straight = np.array(lines).reshape(-1, 3).T
    driving = level - direction * _zero(level, direction)
    return np.asarray(
        (direction != 0.0) & (straight >= STRAIGHT) & (driving > 0.0) & (rise >= RISE * driving),
        dtype=np.bool_,
    )


def _direction(position: Vector, end: int) -> float:
    return float(np.sign(position[min(end + REST, position.size) - 1] - position[end - 1]))


def _line(drive: Vector) -> tuple[float, float, float]:
    """Return (level, rise, squared correlation with time) of the drive (n,) during a rest.

    The level is the drive at the end of the rest. Rise and correlation are computed from the second
    half of the rest.
    """
    half = drive[drive.size // 2 :]
    if np.ptp(half) == 0.0:
        return float(half[-1]), 0.0, 0.0
    steps = np.arange(half.size) - half.size
    slope, level = np.polyfit(steps, half, 1)
    return float(level), float(slope * half.size), straightness(half)


def straightness(drive: Vector) -> float:
    """Return the squared correlation of a drive (n,) with time, from BLOCKS means or more.

    The means contain less white noise than the samples, but rise as much.
    """
    size = max(1, drive.size // BLOCKS)
    means = drive[drive.size % size :].reshape(-1, size).mean(axis=1)
    if np.ptp(means) == 0.0:
        return 0.0
    return float(np.corrcoef(np.arange(means.size), means)[0, 1] ** 2)


def _zero(level: Vector, direction: Vector) -> float:
    forward = level[direction > 0.0]
    backward = level[direction < 0.0]
    return (
        0.5 * float(np.median(forward) - np.median(backward))
        if forward.size and backward.size
        else 0.0
    )
