"""Slow loops below the breakaway as what the laws of presliding see of them: a path of positions
and the friction along it.

The axis hardly accelerates, so that friction is the effort less its offset. As long as the encoder
stays within one count, the mean effort belongs to the middle of the count; where the effort turns
within a count it belongs to no one place, and the row only moves the path.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.rows.strokes import turning_points

FEWEST_BRANCHES = 6
TURN = 0.05  # of the effort's range: smaller turns are noise
FEWEST_ROWS = 10  # counts that a record's longest branch has to pass


@dataclass(frozen=True)
class PreslidingLoops:
    """n counts one after the other: `position` (n,) rad | m from the first, `speed` (n,), `force`
    (n,) N m | N, `branch` (n,); `used` (n,).

    breakaway: N m | N. count: rad | m of the encoder. starts: of each record, whose contact is
    taken to be relaxed there.
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
        return int(self.branch[-1]) + 1

    @property
    def reach(self) -> float:
        """Half the range of the positions, rad | m."""
        return 0.5 * float(np.ptp(self.position))


def find_loops(records: list[MotionRecord], breakaway: Interval) -> PreslidingLoops:
    """The loops of records that never slip. Raises UnusableLogs where there are too few, or the
    encoder does not see them."""
    parts, above = [], 0
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
            f"the encoder sees {rows.max()} counts of the longest branch below the breakaway; at least {FEWEST_ROWS} are needed to tell "
            f"presliding, a count of {records[0].resolution * max(int(rows.max()), 1) / FEWEST_ROWS:.2g} or less"
        )
    if above < FEWEST_BRANCHES:
        raise UnusableLogs(
            f"the effort of the loops reverses {above - len(records)} times; at least {FEWEST_BRANCHES - 1} are needed"
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
    """Numbers (n,) from 0 of what lies between two reversals of the effort."""
    points = np.empty(record.effort.size, dtype=np.int64)
    found = turning_points(record.effort, TURN * float(np.ptp(record.effort)), points)
    turns = np.zeros(record.effort.size, dtype=np.int64)
    turns[points[:found] + 1] = 1
    return np.cumsum(turns)


def _counts(
    record: MotionRecord, number: NDArray[np.int64], above: int
) -> tuple[NDArray[Any], ...]:
    """One row for each stay within a count: its middle, speed, mean effort, branch, whether of one
    branch, whether the record's first."""
    starts = np.flatnonzero(np.diff(record.position, prepend=np.inf) != 0.0)
    lengths = np.diff(np.append(starts, record.position.size))
    last = number[starts + lengths - 1]
    inside = number[starts] == last
    inside[0] = False  # how far into its first count the axis is nobody knows
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
