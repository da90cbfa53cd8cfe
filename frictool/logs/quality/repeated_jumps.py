"""Detection of a wrap with any period: repeated jumps of the same size in a position.

A step s from one sample to the next is long if it exceeds half of the position's range; the range
does not include outliers of one sample. At a wrap, the axis moves by u against the direction of s,
and the period is P = |s| + u. The two steps before s and the two after it bound u. Each long step
gives an interval that contains P. The search chooses a P in as many of these intervals as possible.
Then the search classifies the motion around each long step:

    forward     the axis moves against s before and after the step: it continues across the end of
                the period
    backward    the axis moves along s before or after the step, as after a dropout: no wrap
    at rest     the axis rests, or its motion is smaller than the noise

The motion before the step is the sum of the last n steps, and the motion after the step is the sum
of the next n steps. n is the smallest of 2, 8, 32 and 128 for which both sums clearly exceed noise
and one count.

Noise at the end of the period causes several long steps of alternating signs. If the number of
these steps is odd, the first step counts as the wrap. If the number is even, there is no wrap.

The motion of an axis that rests, reverses or creeps at an end of the period may be smaller than
the noise. Then the positions before and after each long step must be the ends of a known period. A
sawtooth motion that returns within one sample looks like a wrap. Therefore `RepeatedJump.movable`
states whether the drive can move the axis that far in one sample.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.typing import Matrix, Vector

NEIGHBOURS = 2  # number of steps before and after a step, which bound the motion during the step
SCALES = (2, 8, 32, 128)  # numbers of steps over which the motion before and after a step is summed
WINDOW = SCALES[-1]
TO_AND_FRO = 32  # most samples between successive long steps of opposite signs in one group
CLEAR = 4.0  # least ratio of a motion to the mean difference of neighbouring steps
COUNTS = 3.0  # least ratio of a motion to the smallest step other than 0
FEWEST = 8.0  # least range of the position for a decision, in encoder steps
LONG = 0.5  # least step that may be a wrap, relative to the range
BACK = 0.25  # a step leads to an outlier if the next step leaves less than this share of its length
MOST = 5_000  # maximum number of long steps kept
FASTEST = 0.45  # largest motion between two samples, relative to the period
KNOWN = 0.1  # largest mean width of the intervals for the period, relative to the period
SLOW = 0.01  # largest motion of a slow axis between two samples, relative to the period
MOSTLY = 0.9  # least share of wraps among the long steps
# quantile of the motion around the wraps that is treated as the axis's fastest motion
NEARLY_ALL = 0.95
WILD = 3.0  # steps longer than this multiple of the fastest motion are left out
MOVING = 0.25  # least share of wraps with forward motion
RANGE_SLACK = 0.01  # tolerance of the position's range, relative to the period
# the motion during a jump may lie outside the range of the neighbouring steps by this share of the
# range
CURVED = 0.5
FORCE_SLACK = 4.0  # factor on the acceleration that the bench's drive and inertia allow
SPEED_SLACK = 2.0  # factor on the top speed of the bench


@dataclass(frozen=True)
class RepeatedJump:
    """Repeated jump of a position, which may be a wrap with the period P.

    low, high: bounds of P in rad or m.
    reach: difference of the largest and the smallest raw position in rad or m.
    count: number of jumps.
    first: time in s of the first jump, and the positions before and after this jump.
    forward: number of jumps around which the axis moves forward, as defined at the top of this
        file.
    slow: True if the axis moves by less than P / 100 in the steps before and after a jump.
    centred: True if every jump leads from one end of the range [-P/2, P/2] to the other.
    movable: True if the drive can move the axis in one sample as far as a jump.
    """

    low: float
    high: float
    reach: float
    count: int
    first: tuple[float, float, float]
    forward: int
    slow: bool
    centred: bool
    movable: bool


class RepeatedJumps:
    """Search for repeated jumps in a position, block after block."""

    def __init__(self, bench: Bench) -> None:
        mechanics, actuator = bench.mechanics, bench.actuator
        lightest = mechanics.inertia.interval[0] or mechanics.inertia.value
        self._acceleration = FORCE_SLACK * actuator.limit.value * actuator.constant.value / lightest
        self._speed = (
            math.inf if mechanics.top_speed is None else SPEED_SLACK * mechanics.top_speed.value
        )
        self._noise = 2.0 * bench.encoder.resolution
        self._narrow = FEWEST * bench.encoder.resolution
        self._low = math.inf
        self._high = -math.inf
        self._time: Vector = np.empty(0)
        self._position: Vector = np.empty(0)
        self._first = 0  # index in the log of the first sample kept
        self._judged = 0  # number of steps already judged, from the first sample kept
        # for each long step: time before and after, position before and after, index
        self._ends: Matrix = np.empty((0, 5))
        # steps around each long step; NaN outside of the log
        self._around: Matrix = np.empty((0, 2 * WINDOW))

    def take(self, time: Vector, position: Vector) -> None:
        """Add the next samples (n,): time in s, position in rad or m."""
        if position.size:
            self._time = np.append(self._time, time)
            self._position = np.append(self._position, position)
            self._judge(self._position.size - 1 - WINDOW)

    def finish(self) -> None:
        """Search the last samples; `take` must not be called afterwards."""
        self._judge(self._position.size - 1)

    def result(self) -> RepeatedJump | None:
        """Return the repeated jump in the samples so far; None if no jump repeats like a wrap."""
        crossing = self._crossings()
        steps = (self._ends[:, 3] - self._ends[:, 2])[crossing]
        size = np.abs(steps)
        around = -np.sign(steps)[:, None] * self._around[crossing]
        neighbours = around[:, WINDOW - NEIGHBOURS : WINDOW + NEIGHBOURS].copy()
        neighbours[np.abs(neighbours) > self._long] = np.nan  # exclude long steps
        usable = np.isfinite(neighbours).sum(axis=1) >= NEIGHBOURS
        if not usable.any() or self._high - self._low < self._narrow:
            return None
        least, most = np.nanmin(neighbours[usable], axis=1), np.nanmax(neighbours[usable], axis=1)
        slack = CURVED * (most - least) + self._noise
        shortest = size[usable] + least - slack
        longest = size[usable] + most + slack
        low, high = _most_covered(shortest, longest)
        period = 0.5 * (low + high)
        fits = (shortest <= period) & (period <= longest)
        if not fits.any() or self._high - self._low > (1.0 + RANGE_SLACK) * high:
            return None
        fastest = float(np.quantile(np.maximum(np.abs(least), np.abs(most))[fits], NEARLY_ALL))
        wraps = np.zeros(size.size, np.bool_)
        wraps[usable] = fits & (size[usable] > 0.5 * period)
        vague = (
            fastest > FASTEST * period
            or float(np.mean((longest - shortest)[fits])) > KNOWN * period + 2.0 * self._noise
        )
        if vague or wraps.sum() < MOSTLY * size.size:
            return None
        motion = (around - period * np.rint(around / period))[wraps]
        motion[np.abs(motion) > WILD * fastest + self._noise] = np.nan
        forward, backward = _directions(motion)
        if forward <= MOVING * wraps.sum() or backward > (1.0 - MOSTLY) * forward:
            return None
        ends = self._ends[crossing][wraps]
        centred = bool((np.abs(ends[:, 2] + ends[:, 3]) <= 2.0 * fastest + self._noise).all())
        first = float(ends[0, 1]), float(ends[0, 2]), float(ends[0, 3])
        reach = self._high - self._low
        return RepeatedJump(
            low,
            high,
            reach,
            len(ends),
            first,
            forward,
            fastest < SLOW * period,
            centred,
            self._can_move(ends),
        )

    def between(self, low: float, high: float) -> RepeatedJump | None:
        """Return the jumps from one end of a period to the other, whatever the motion around them.

        low, high: ends of the period in rad or m.

        The result is None if the share of these jumps among the long steps (module docstring) is
        below MOSTLY, or if the position leaves the period.
        """
        near = np.abs(self._around[:, WINDOW - NEIGHBOURS : WINDOW + NEIGHBOURS])
        motion = near[near <= self._long]
        if not motion.size:
            return None
        fastest = float(np.quantile(motion, NEARLY_ALL))
        margin = WILD * fastest + self._noise
        away = np.abs(np.sort(self._ends[:, 2:4], axis=1) - [low, high]).max(axis=1)
        ends = self._ends[away <= margin]
        if (
            margin > KNOWN * (high - low)
            or len(ends) < MOSTLY * len(away)
            or not low - margin <= self._low < self._high <= high + margin
        ):
            return None
        return RepeatedJump(
            high - low,
            high - low,
            self._high - self._low,
            len(ends),
            (float(ends[0, 1]), float(ends[0, 2]), float(ends[0, 3])),
            0,
            fastest < SLOW * (high - low),
            low == -high,
            self._can_move(ends),
        )

    def _crossings(self) -> NDArray[np.intp]:
        """Return the index of the first long step of each group with an odd number of steps.

        Long steps of alternating signs that follow each other closely form a group. A group with an
        even number of steps is left out, because it returns to its start, as a glitch does.
        """
        sign = np.sign(self._ends[:, 3] - self._ends[:, 2])
        index = self._ends[:, 4]
        starts = np.flatnonzero(
            (np.diff(sign, prepend=0.0) == 0.0) | (np.diff(index, prepend=-np.inf) > TO_AND_FRO)
        )
        length = np.diff(np.append(starts, sign.size))
        return np.asarray(starts[length % 2 == 1])

    @property
    def _long(self) -> float:
        return LONG * (self._high - self._low)

    def _judge(self, end: int) -> None:
        start = self._judged
        if end <= start:
            return
        steps = np.diff(self._position)
        self._extend(steps, start, end)
        index = start + np.flatnonzero(np.abs(steps[start:end]) > self._long)
        padded = np.pad(steps, WINDOW, constant_values=np.nan)
        offsets = np.delete(np.arange(2 * WINDOW + 1), WINDOW)
        time, position = self._time, self._position
        ends: Matrix = np.column_stack(
            (
                time[index],
                time[index + 1],
                position[index],
                position[index + 1],
                (self._first + index).astype(np.float64),
            )
        )
        self._ends = np.concatenate((self._ends, ends))[:MOST]
        self._around = np.concatenate((self._around, padded[index[:, None] + offsets]))[:MOST]
        kept = np.abs(self._ends[:, 3] - self._ends[:, 2]) > self._long
        self._ends, self._around = self._ends[kept], self._around[kept]
        dropped = max(0, end - WINDOW)
        self._time = time[dropped:]
        self._position = position[dropped:]
        self._judged = end - dropped
        self._first += dropped

    def _extend(self, steps: Vector, start: int, end: int) -> None:
        """Extend the position's range by the samples at the ends of the steps start to end - 1.

        The step steps[k] leads from sample k to sample k + 1. If the next step returns nearly to
        sample k, sample k + 1 is an outlier and is left out.
        """
        after = np.append(steps[start + 1 :], 0.0)[: end - start]
        back = np.abs(steps[start:end] + after) < BACK * np.abs(steps[start:end])
        inside = self._position[start + 1 : end + 1][~back]
        if math.isinf(self._low):
            inside = np.append(self._position[start], inside)
        self._low = float(inside.min(initial=self._low))
        self._high = float(inside.max(initial=self._high))

    def _can_move(self, ends: Matrix) -> bool:
        """Return True if the drive can move the axis in one sample as far as a jump.

        The axis is assumed to have the same speed before and after the jump.
        """
        interval = ends[:, 1] - ends[:, 0]
        size = np.abs(ends[:, 3] - ends[:, 2])
        return bool(
            (
                size <= np.minimum(0.25 * self._acceleration * interval**2, self._speed * interval)
            ).any()
        )


def _directions(around: Matrix) -> tuple[int, int]:
    change = np.abs(np.diff(around, axis=1))
    noise = np.nansum(change, axis=1) / np.maximum(np.isfinite(change).sum(axis=1), 1)
    size = np.abs(around)
    count = np.nanmin(np.where(size > 0.0, size, np.inf), axis=1, initial=np.inf)
    clear = np.maximum(CLEAR * noise, COUNTS * np.where(np.isfinite(count), count, 0.0))
    forward, backward = np.zeros(clear.size, np.bool_), np.zeros(clear.size, np.bool_)
    for scale in SCALES:  # the first scale at which both motions are clear decides
        before = np.nansum(around[:, WINDOW - scale : WINDOW], axis=1)
        after = np.nansum(around[:, WINDOW : WINDOW + scale], axis=1)
        decided = ~(forward | backward) & (np.abs(before) > clear) & (np.abs(after) > clear)
        forward |= decided & (before > 0.0) & (after > 0.0)
        backward |= decided & ~forward
    return int(forward.sum()), int(backward.sum())


def _most_covered(low: Vector, high: Vector) -> tuple[float, float]:
    """Return the bounds of the range of values that lies in the largest number of intervals.

    The range is then extended as long as it lies in at least MOSTLY times this number of
    intervals.

    low, high: bounds (n,) of the intervals.
    """
    ends = np.concatenate((low, high))
    opens = np.concatenate((np.ones(low.size), -np.ones(high.size)))
    order = np.lexsort((-opens, ends))
    cover = np.cumsum(opens[order])
    best = int(np.argmax(cover))
    thin = np.flatnonzero(cover < MOSTLY * cover[best])
    first = int(thin[thin < best].max(initial=-1)) + 1
    return float(ends[order][first]), float(ends[order][thin[thin > best].min()])
