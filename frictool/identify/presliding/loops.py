"""Positions and friction along slow effort loops below the breakaway.

The axis hardly accelerates, so that friction is the effort minus the offset of the effort. Each row
stands for the time during which the encoder shows one count. The row contains the mean effort of
this time, and the position of the middle of the count. If the effort reverses during this time, its
mean belongs to no unique position. Such a row is a part of the path, but its force is not fitted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.strokes import turning_points
from frictool.typing import Vector

FEWEST_BRANCHES = 6
TURN = 0.05  # share of the effort's range below which a reversal is noise
FEWEST_ROWS = 10  # least number of counts in the longest branch of a record


@dataclass(frozen=True)
class PreslidingLoops:
    """Rows (n,) of presliding loops, one for each time during which the encoder shows one count.

    - position: distance from the first count of the record, rad | m
    - speed: mean speed in the row, rad/s | m/s
    - force: mean friction in the row, N m | N
    - branch: number of the branch, which is the path between two reversals of the effort
    - used: True for rows whose samples all belong to one branch
    - starts: True for the first row of each record, at which the contact is assumed to be relaxed
    - breakaway: interval of the breakaway, N m | N
    - count: encoder resolution, rad | m
    """

    position: Vector
    speed: Vector
    force: Vector
    branch: NDArray[np.int64]
    used: NDArray[np.bool_]
    starts: NDArray[np.bool_]
    breakaway: Interval
    count: float

    @property
    def branches(self) -> int:
        """Return the number of branches, the paths between two reversals of the effort."""
        return int(self.branch[-1]) + 1

    @property
    def reach(self) -> float:
        """Return half of the range of the positions, rad | m."""
        return 0.5 * float(np.ptp(self.position))


def find_loops(records: list[MotionRecord], breakaway: Interval) -> PreslidingLoops:
    """Return the rows of presliding loops in records of an axis that never slips.

    `breakaway` is the interval of the breakaway, N m | N. Raises UnusableLogs if there are too few
    loops, or if the encoder is too coarse for the loops.
    """
    parts = []
    above = 0
    for record in records:
        number = branches_of(record)
        parts.append(_counts(record, number, above))
        above += int(number[-1]) + 1
    position, speed, force, branch, used, starts = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    rows = np.bincount(branch[used], minlength=above)
    if rows.max() < FEWEST_ROWS:
        raise UnusableLogs(
            f"the longest branch between two reversals has {rows.max()} encoder counts; "
            f"presliding needs at least {FEWEST_ROWS}; use an encoder with a step of at most "
            f"{records[0].resolution * max(int(rows.max()), 1) / FEWEST_ROWS:.2g} rad or m"
        )
    if above < FEWEST_BRANCHES:
        raise UnusableLogs(
            f"the effort of the loops reverses {above - len(records)} times; needed: at least "
            f"{FEWEST_BRANCHES - 1} reversals"
        )
    return PreslidingLoops(
        position,
        speed,
        force,
        branch.astype(np.int64),
        used.astype(np.bool_),
        starts.astype(np.bool_),
        breakaway,
        records[0].resolution,
    )


def branches_of(record: MotionRecord) -> NDArray[np.int64]:
    """Return the number of the branch (path between effort reversals) of each sample, (n,)."""
    points = np.empty(record.effort.size, dtype=np.int64)
    turning = turning_points(record.effort, TURN * float(np.ptp(record.effort)), points)
    turns = np.zeros(record.effort.size, dtype=np.int64)
    turns[points[:turning] + 1] = 1
    return np.cumsum(turns)


def _counts(
    record: MotionRecord, number: NDArray[np.int64], above: int
) -> tuple[NDArray[Any], ...]:
    """Return six columns (m,), with one row for each time during which the encoder shows one count.

    The columns are: middle of the count, speed, mean effort, number of the branch, True if all
    samples of the row lie in one branch, True for the record's first row.
    """
    starts = np.flatnonzero(np.diff(record.position, prepend=np.inf) != 0.0)
    lengths = np.diff(np.append(starts, record.position.size))
    last = number[starts + lengths - 1]
    inside = number[starts] == last
    inside[0] = False  # the position within the first count is unknown
    position = record.position[starts] - record.position[0]
    first = np.arange(starts.size) == 0
    if starts.size < 2:
        return position, 0.0 * position, record.effort[starts], last + above, inside, first
    speed = np.gradient(position) / np.gradient((starts + 0.5 * lengths) * record.period)
    return (
        position,
        speed,
        np.add.reduceat(record.effort, starts) / lengths,
        last + above,
        inside,
        first,
    )
