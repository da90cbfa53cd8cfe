"""Repeated jumps of one size in a position: a wrap of any period, without a list of periods.

A step s is long if it exceeds half of the position's range, without single samples that leave and
come back. If the sensor wraps, the axis moves by u against the direction of s, and the period is P
= |s| + u. The four steps around s bound u, so that each long step gives an interval of P. The
search takes the period that lies in most of these intervals, and compares the motion around the
steps with it:

    forward     before and after the step, the axis moves against s, as one that goes on across the
                end of the period
    backward    before or after, it moves along s, as after a dropout; no wrap
    at rest     neither: noise, or an axis that stands

The motion on one side is the sum of 2, 8, 32 or 128 steps. It counts if it exceeds 4 times the mean
difference of neighbouring steps, which is noise, and 3 times the smallest of these steps, which is
a count. Noise at the end of the period makes several steps to and fro: the first of them counts if
their number is odd.

A sawtooth whose return takes one sample looks like a wrap, unless the drive can move the axis so
far in that time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.logs.log import Vector

Matrix = NDArray[np.float64]

NEIGHBOURS = 2  # number of steps before and after a step that bound the motion in between
SCALES = (2, 8, 32, 128)  # numbers of steps over which the motion before and after a step is summed
WINDOW = SCALES[-1]
TO_AND_FRO = 32  # samples between long steps of opposite signs that belong together
CLEAR = 4.0  # times the mean difference of neighbouring steps: what a motion has to exceed
COUNTS = 3.0  # times the smallest step: the same
FEWEST = 8.0  # encoder steps: nothing is decided in a narrower range
LONG = 0.5  # of the range: a longer step may be a wrap
BACK = (
    0.25  # of a step: a sample is out of range if the step after it undoes this step but for less
)
MOST = 5_000  # long steps kept
FASTEST = 0.45  # of the period: bound of the motion between two samples
KNOWN = 0.1  # of the period: bound of the mean width of the intervals that the long steps give
SLOW = 0.01  # of the period: bound of the motion in a step of a slow axis
MOSTLY = 0.9  # least share of wraps among the long steps
NEARLY_ALL = 0.95  # share of wraps beside which the axis is not faster than the bound
WILD = 3.0  # times the motion beside the wraps: a longer step is left out
MOVING = 0.25  # least share of wraps across which the axis moves on
RANGE_SLACK = 0.01  # of the period: tolerance of the position's range
CURVED = 0.5  # of the spread of the neighbouring steps: what the step between them may exceed it by
FORCE_SLACK = 4.0  # times the acceleration that drive and inertia of the bench give
SPEED_SLACK = 2.0  # times the top speed of the bench


@dataclass(frozen=True)
class RepeatedJump:
    """Steps that fit one period.

    low, high: bounds of the period. reach: range of the position, in rad or m as they are. count:
    number of steps; first: time in s and positions before and after the first. forward: number of
    steps across which the axis moves on. slow: it moves less than P / 100 in the steps beside.
    centred: all steps lead from one end of plus and minus half a period to the other. movable: the
    drive can move the axis that far in one sample.
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
    """Search for repeated jumps in a position [rad | m] of one bench, block after block."""

    def __init__(self, bench: Bench) -> None:
        mechanics, actuator = bench.mechanics, bench.actuator
        lightest = mechanics.inertia.interval[0] or mechanics.inertia.value
        self._acceleration = FORCE_SLACK * actuator.limit.value * actuator.constant.value / lightest
        self._speed = (
            math.inf if mechanics.top_speed is None else SPEED_SLACK * mechanics.top_speed.value
        )
        self._noise = 2.0 * bench.encoder.resolution
        self._narrow = FEWEST * bench.encoder.resolution
        self._low, self._high = math.inf, -math.inf
        self._time: Vector = np.empty(0)
        self._position: Vector = np.empty(0)
        self._first = 0  # number of the first sample kept
        self._judged = 0  # steps at the start of the samples kept that have been judged
        self._ends: Matrix = np.empty(
            (0, 5)
        )  # time before and after, position before and after, and number of each long step
        self._around: Matrix = np.empty(
            (0, 2 * WINDOW)
        )  # the steps around it; NaN outside of the log

    def take(self, time: Vector, position: Vector) -> None:
        """Add samples (n,) that follow those before: s, and rad or m."""
        if position.size:
            self._time, self._position = (
                np.append(self._time, time),
                np.append(self._position, position),
            )
            self._judge(self._position.size - 1 - WINDOW)

    def finish(self) -> None:
        """Judge the last steps too; call it after the last samples."""
        self._judge(self._position.size - 1)

    def found(self) -> RepeatedJump | None:
        """Return the jump of the steps judged so far, or None if none of one size repeats itself as
        a wrap does."""
        crossing = self._crossings()
        steps = (self._ends[:, 3] - self._ends[:, 2])[crossing]
        size, around = np.abs(steps), -np.sign(steps)[:, None] * self._around[crossing]
        beside = around[:, WINDOW - NEIGHBOURS : WINDOW + NEIGHBOURS].copy()
        beside[np.abs(beside) > self._long] = np.nan  # long steps themselves
        usable = np.isfinite(beside).sum(axis=1) >= NEIGHBOURS
        if not usable.any() or self._high - self._low < self._narrow:
            return None
        least, most = np.nanmin(beside[usable], axis=1), np.nanmax(beside[usable], axis=1)
        slack = CURVED * (most - least) + self._noise
        shortest, longest = size[usable] + least - slack, size[usable] + most + slack
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

    def _crossings(self) -> NDArray[np.intp]:
        """Return the first of each odd number of long steps to and fro; an even number leads back,
        as a glitch does."""
        sign, place = np.sign(self._ends[:, 3] - self._ends[:, 2]), self._ends[:, 4]
        starts = np.flatnonzero(
            (np.diff(sign, prepend=0.0) == 0.0) | (np.diff(place, prepend=-np.inf) > TO_AND_FRO)
        )
        length = np.diff(np.append(starts, sign.size))
        return np.asarray(starts[length % 2 == 1])

    @property
    def _long(self) -> float:
        return LONG * (self._high - self._low)

    def _judge(self, end: int) -> None:
        """Keep the long steps before `end` that have not been judged, and the samples that later
        steps need."""
        start = self._judged
        if end <= start:
            return
        steps = np.diff(self._position)
        self._extend(steps, start, end)
        place = start + np.flatnonzero(np.abs(steps[start:end]) > self._long)
        padded = np.pad(steps, WINDOW, constant_values=np.nan)
        offsets = np.delete(np.arange(2 * WINDOW + 1), WINDOW)
        time, position = self._time, self._position
        ends: Matrix = np.column_stack(
            (
                time[place],
                time[place + 1],
                position[place],
                position[place + 1],
                (self._first + place).astype(np.float64),
            )
        )
        self._ends = np.concatenate((self._ends, ends))[:MOST]
        self._around = np.concatenate((self._around, padded[place[:, None] + offsets]))[:MOST]
        kept = np.abs(self._ends[:, 3] - self._ends[:, 2]) > self._long
        self._ends, self._around = self._ends[kept], self._around[kept]
        dropped = max(0, end - WINDOW)
        self._time, self._position, self._judged = time[dropped:], position[dropped:], end - dropped
        self._first += dropped

    def _extend(self, steps: Vector, start: int, end: int) -> None:
        """Widen the range by the samples after the judged steps, without those that leave and come
        back."""
        after = np.append(steps[start + 1 :], 0.0)[: end - start]
        back = np.abs(steps[start:end] + after) < BACK * np.abs(steps[start:end])
        inside = self._position[start + 1 : end + 1][~back]
        if math.isinf(self._low):
            inside = np.append(self._position[start], inside)
        self._low, self._high = (
            float(inside.min(initial=self._low)),
            float(inside.max(initial=self._high)),
        )

    def _can_move(self, ends: Matrix) -> bool:
        """Return whether the axis can make one of the steps, from one speed to the same speed."""
        interval, size = ends[:, 1] - ends[:, 0], np.abs(ends[:, 3] - ends[:, 2])
        return bool(
            (
                size <= np.minimum(0.25 * self._acceleration * interval**2, self._speed * interval)
            ).any()
        )


def _directions(around: Matrix) -> tuple[int, int]:
    """Return the numbers of forward and of backward motions (m, 2 WINDOW), each the steps around
    one long step and against it."""
    change = np.abs(np.diff(around, axis=1))
    noise = np.nansum(change, axis=1) / np.maximum(np.isfinite(change).sum(axis=1), 1)
    size = np.abs(around)
    count = np.nanmin(np.where(size > 0.0, size, np.inf), axis=1, initial=np.inf)
    clear = np.maximum(CLEAR * noise, COUNTS * np.where(np.isfinite(count), count, 0.0))
    forward, backward = np.zeros(clear.size, np.bool_), np.zeros(clear.size, np.bool_)
    for scale in SCALES:  # the smallest scale at which both sides are clear decides
        before = np.nansum(around[:, WINDOW - scale : WINDOW], axis=1)
        after = np.nansum(around[:, WINDOW : WINDOW + scale], axis=1)
        decided = ~(forward | backward) & (np.abs(before) > clear) & (np.abs(after) > clear)
        forward |= decided & (before > 0.0) & (after > 0.0)
        backward |= decided & ~forward
    return int(forward.sum()), int(backward.sum())


def _most_covered(low: Vector, high: Vector) -> tuple[float, float]:
    """Return the bounds of the region that nearly the most of the intervals low to high (n,)
    cover."""
    ends = np.concatenate((low, high))
    opens = np.concatenate((np.ones(low.size), -np.ones(high.size)))
    order = np.lexsort((-opens, ends))
    cover = np.cumsum(opens[order])
    best = int(np.argmax(cover))
    thin = np.flatnonzero(cover < MOSTLY * cover[best])
    first = int(thin[thin < best].max(initial=-1)) + 1
    return float(ends[order][first]), float(ends[order][thin[thin > best].min()])
