"""Detection of breakaways in a log of ramps.

Each breakaway is described by a line that is fitted to the effort at rest, and by the times at
which the encoder's count changes after the onset of motion. Onsets inside the backlash after a
reversal are left out, because only the motor moves there.

Flicker of the encoder between two counts is no motion. A motion by a single count, or within the
backlash, is no onset if a long pause follows while the effort keeps rising: the drive train has
yielded. A sliding axis would have reached the next count sooner (`_later`).

The detection uses only the changes of the measured effort, so that a constant load or offset does
not change the detected onsets. The effort of a known load is subtracted from the level of each
onset.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.identify.breakaway.onset import travel
from frictool.identify.fit_result import Interval
from frictool.identify.motion_record import MotionRecord, once_per_record
from frictool.identify.rows.strokes import find_strokes
from frictool.logs.quality.ramps import (
    FEWEST_RAMPS,
    RAMP_SHARE,
    REST_SHARE,
    STRAIGHT,
    are_ramps,
    ramp_share,
    ramps_among,
    resting_time,
    rests_of,
    straightness,
    without_flicker,
)
from frictool.plant.weak_form import effort_weights
from frictool.typing import Vector

MOVED_COUNTS = 0.5  # least net distance of a motion, in counts
# number of encoder changes used after an onset; later changes depend more on the inertia
CHANGES_USED = 4
FEWEST_ONSETS = 5
FEWEST_SAMPLES = 12  # least number of samples of the line at the end of a ramp
# a ramp is curved if a cubic and a line differ at its end by more than SIGNIFICANT standard
# deviations, and by more than CURVED times the rise of the effort during the rest
SIGNIFICANT, CURVED = 4.0, 2e-3
LEAST_CHANGE = float(np.finfo(np.float64).tiny) ** 0.5  # N m | N; squares of less underflow
RELATIVE_NOISE = 1e-3  # least noise of the effort, relative to its rise during the rest
# the ramp has ended if the effort is below the line by more than this many standard deviations
LEFT_THE_RAMP = 5.0
# numbers of changes after the first one up to which a ramp is fitted if noise hides its rise
FURTHER = (0, 1, 3, 7, 15, 31)
CLEARLY = 4.0  # least difference of a mean effort that noise does not explain, in standard errors
MEDIAN = 0.6745  # median of |x| of a normal distribution with the standard deviation 1
# a motion of at least ADVANCED counts has returned if the axis moves back by more than the fraction
# RETURNED of the motion, and if the opposite effort stays below OPPOSED times the effort at the
# onset; a yielding drive train moves back by less
ADVANCED, RETURNED, OPPOSED = 8.0, 0.5, 0.5


@dataclass(frozen=True, eq=False)
class BreakawayOnset:
    """One breakaway; times count from the first visible motion.

    - direction: direction of the motion, +1 or -1
    - level, rate: value at time 0 [N m | N] and slope [N m/s | N/s] of the line that is fitted to
      |effort| at rest; the effort of the record's known load is subtracted
    - time: times at which the encoder's count changes, (n,), s
    - seen: distance from the first change to each change, (n,), rad | m
    - position: middle of the encoder count in which the axis rested, rad | m
    - rested: time at rest before the onset, s
    - timing: weight of the expected rest position, defined in `onset.py`
    - yields: True if the encoder moved by a count or more during the rest, because the drive train
      yielded
    - after_reversal: True if the motion before the rest had the other direction, or if the log has
      no motion before the rest
    """

    direction: float
    level: float
    rate: float
    time: Vector
    seen: Vector
    position: float
    rested: float
    timing: float
    yields: bool = False
    after_reversal: bool = False

    @property
    def later(self) -> BreakawayOnset:
        """Return the onset without its first encoder change, or unchanged if it has only one."""
        if self.time.size == 1:
            return self
        return replace(self, time=self.time[1:], seen=self.seen[1:] - self.seen[1])


def is_ramp(record: MotionRecord, bench: Bench) -> bool:
    """Return True if a log consists of breakaway ramps, and has at least FEWEST_ONSETS onsets."""
    steady = _steady(record)
    if not are_ramps(_rests(steady, _heaviest(bench)), steady.position, steady.effort):
        return False
    return len(list(itertools.islice(_onsets(record, bench), FEWEST_ONSETS))) == FEWEST_ONSETS


def why_unusable(record: MotionRecord, bench: Bench) -> str | None:
    """Return why `is_ramp` rejects a log that contains ramps; None if there are hardly any."""
    record = _steady(record)
    rests = _rests(record, _heaviest(bench))
    if resting_time(rests) < REST_SHARE * record.position.size:
        return None
    among = ramps_among(rests, record.position, record.effort)
    ramps = int(np.sum(among))
    name = Path(record.name).name
    if ramps < FEWEST_RAMPS:
        return None
    share = ramp_share(rests, among, record.position)
    if share < RAMP_SHARE:
        return (
            f"{name} is read as sliding: its {ramps} ramps take {100.0 * share:.2g} % of the time "
            f"at rest before motions, needed: {100.0 * RAMP_SHARE:g} %; if it is a log of ramps, "
            "use --ramp"
        )
    usable = len(find_onsets(record, bench))
    text = f"{name} has {ramps} ramps, but {usable} usable breakaways; needed: {FEWEST_ONSETS}"
    if bench.mechanics.backlash is None:
        return f"{text}: from rest, raise the effort evenly until the axis moves, and repeat"
    unit = "rad" if bench.axis == "rotary" else "m"
    return (
        f"{text}; after a reversal, move the axis {_least_motion(record, bench):.3g} {unit} "
        "(backlash) and stop it; then raise the effort evenly in the same direction"
    )


@once_per_record
def _steady(record: MotionRecord) -> MotionRecord:
    """Return the record without flicker of the position between two neighbouring encoder counts."""
    steady = without_flicker(record.position, record.resolution)
    return record if np.array_equal(steady, record.position) else replace(record, position=steady)


def _count_changes(record: MotionRecord) -> NDArray[np.bool_]:
    return np.asarray(
        (np.abs(np.diff(record.position)) > 0.5 * record.resolution) | (np.diff(record.piece) > 0)
    )


def share_at_rest(record: MotionRecord) -> float:
    """Return the total duration of the rests before motions, relative to the record's duration."""
    rests = rests_of(_count_changes(_steady(record)))
    return sum(end - start for start, end in rests) / record.position.size


class _Heaviest(NamedTuple):
    """Axis with the largest possible inertia, viscous friction and backlash, in SI units."""

    inertia: float
    viscous: float
    gap: float


def _heaviest(bench: Bench, axis: Mapping[str, Interval] | None = None) -> _Heaviest:
    """Return the upper ends of the intervals in `axis`, or of the bench if `axis` is None."""
    mechanics = bench.mechanics
    gap = 0.0 if mechanics.backlash is None else max(mechanics.backlash.interval)
    if axis is None:
        return _Heaviest(max(mechanics.inertia.interval), max(mechanics.viscous.interval), gap)
    return _Heaviest(axis["inertia"].high, max(axis["viscous"].high, 0.0), gap)


def _rests(record: MotionRecord, heaviest: _Heaviest) -> list[tuple[int, int]]:
    """Return (start, stop) of each rest before a motion: at sample `stop`, the position changes.

    A change of the position because the drive train yields does not end a rest.
    """
    moved = _count_changes(record)
    changes = [*(np.flatnonzero(moved) + 1).tolist(), record.position.size]
    rests: list[tuple[int, int]] = []
    for start, change in rests_of(moved):
        if rests and start < rests[-1][1]:
            continue
        k = bisect.bisect_left(changes, change)
        while k + 1 < len(changes) and (later := _later(record, heaviest, start, changes, k)) > k:
            k = later
        if changes[k] < record.position.size:
            rests.append((start, changes[k]))
    return rests


def _later(
    record: MotionRecord, heaviest: _Heaviest, start: int, changes: Sequence[int], k: int
) -> int:
    """Return the index, `k` or above, of the first encoder change that may be the onset of motion.

    Change k is no onset in two cases. In both, the effort after the change stays on the line fitted
    before the change:
    - The position returns.
    - The position changes by one count, or within the width of the backlash, and then does not
      change for a time in which the heaviest axis, accelerated from rest by the rise of the effort
      alone, would have slid by more than one count.
    """
    end = changes[k]
    middle = start + (end - start) // 2
    parts = (slice(start, middle), slice(middle, end), slice(end, changes[k + 1]))
    first, second, after = (float(np.mean(record.effort[part])) for part in parts)
    error = _noise(record) / math.sqrt(changes[k + 1] - end)
    rises = (second - first) * (after - second) > 0.0
    if not rises and abs(after - second) > CLEARLY * error:  # most logs
        return k
    ramp = _visible_ramp(record, start, changes, k) if heaviest.inertia > 0.0 else None
    if ramp is None:
        return k
    line, zero = ramp
    until = int(np.searchsorted(record.piece, record.piece[end - 1], side="right"))
    until = min(max(2 * end - start, changes[k + 1]), until)
    left = np.flatnonzero(line.left(record, zero, end, until))
    until = end + int(left[0]) if left.size else until
    moved = line.direction * (record.position[end:until] - record.position[end - 1])
    back = np.flatnonzero(moved < 0.5 * record.resolution)
    if back.size:
        return bisect.bisect_right(changes, end + int(back[-1]))
    most = max(heaviest.gap, 1.5 * record.resolution)
    for j in range(k, bisect.bisect_left(changes, until)):
        if moved[changes[j] - end] > most:
            break
        duration = float(record.time[min(until, changes[j + 1]) - 1] - record.time[changes[j]])
        if travel(duration, 0.0, line.rate, heaviest.inertia, heaviest.viscous) > record.resolution:
            return j + 1
    return k


def _visible_ramp(
    record: MotionRecord, start: int, changes: Sequence[int], k: int
) -> tuple[_Line, int] | None:
    """Return the line of the effort since the sample `start`, and the sample of its time 0.

    The line ends at change k, or at the first later change at which noise does not hide the rise of
    the effort. Return None if there is no such change before the effort stops rising.
    """
    for further in FURTHER:
        end = changes[min(k + further, len(changes) - 1)]
        if end == record.position.size:
            return None
        if further:
            quarters = [float(np.mean(one)) for one in np.array_split(record.effort[start:end], 4)]
            steps = np.sign(np.diff(quarters))
            if record.piece[start] != record.piece[end - 1] or abs(np.sum(steps)) != steps.size:
                return None
        line = _line(record, start, end)
        if line is not None and line.tolerance < line.rise:
            return line, end
    return None


@once_per_record
def _noise(record: MotionRecord) -> float:
    """Return the standard deviation of white noise of the effort, N m | N.

    The median makes the result independent of the few samples at which a ramp ends.
    """
    steps = np.abs(np.diff(record.effort))
    return float(np.median(steps)) / (MEDIAN * math.sqrt(2.0)) if steps.size else 0.0


def returning_share(record: MotionRecord, bench: Bench) -> float:
    """Return the fraction (0 to 1) of motions after which the axis moves back without the drive.

    Only a load that exceeds the breakaway moves the axis back to its rest position.
    """
    steady = _steady(record)
    rests = _rests(steady, _heaviest(bench))
    following = [start + 1 for start, _ in rests[1:]] + [record.position.size]
    returned = []
    for (_, end), until in zip(rests, following, strict=False):
        effort = record.effort[end:until] * np.sign(record.effort[end - 1])
        moved = steady.position[end:until] - steady.position[end - 1]
        moved = moved * np.sign(record.effort[end - 1])
        last = int(np.argmax(moved))
        if moved[last] >= ADVANCED * record.resolution:
            least = -OPPOSED * abs(float(record.effort[end - 1]))
            back = moved[last] - moved[-1] > RETURNED * moved[last]
            returned.append(bool(back and np.min(effort[last:]) >= least))
    return float(np.mean(returned)) if returned else 0.0


def passages_of(record: MotionRecord, position: float) -> int:
    """Return how often the axis passes `position` [rad | m] by more than ADVANCED counts."""
    beyond = (record.position - position) / (ADVANCED * record.resolution)
    sides = np.sign(beyond[np.abs(beyond) > 1.0])
    return int(np.count_nonzero(np.diff(sides)))


def find_onsets(
    record: MotionRecord, bench: Bench, axis: Mapping[str, Interval] | None = None
) -> list[BreakawayOnset]:
    """Return every breakaway of a record under a growing effort and outside the backlash.

    axis: intervals of `inertia` and `viscous`; None to use the bench's ranges
    """
    return list(_onsets(record, bench, axis))


def _onsets(
    record: MotionRecord, bench: Bench, axis: Mapping[str, Interval] | None = None
) -> Iterator[BreakawayOnset]:
    record = _steady(record)
    gap = _least_motion(record, bench)
    strokes, rests = find_strokes(record), _rests(record, _heaviest(bench, axis))
    # a rest begins at the position at which the motion has ended
    following = [start + 1 for start, _ in rests[1:]] + [record.position.size]
    drive = record.effort
    if record.load is not None:  # the load's mean looks like an offset, and is left out
        drive = drive - (record.load - np.mean(record.load))
    for k, ((start, end), until, ramp) in enumerate(
        zip(rests, following, ramps_among(rests, record.position, drive), strict=False)
    ):
        direction = float(strokes.sign[end])
        if (
            not ramp
            or direction == 0.0
            or strokes.advance[end] < gap
            or record.piece[end] != record.piece[end - 1]
        ):
            continue
        onset = _onset(record, start, end, until, direction)
        if onset is not None:
            before = record.position[start] - record.position[rests[k - 1][1] - 1] if k else 0.0
            yield replace(onset, after_reversal=bool(direction * before <= 0.0))


def _least_motion(record: MotionRecord, bench: Bench) -> float:
    """Return the motion [rad | m] that certainly closes the backlash after a reversal."""
    width = bench.mechanics.backlash
    return 0.0 if width is None else max(width.interval) + 2.0 * record.resolution


def _onset(
    record: MotionRecord, start: int, end: int, until: int, direction: float
) -> BreakawayOnset | None:
    """Return the breakaway after a rest with the samples [start, end).

    The motion after the rest is examined up to the sample `until`. Return None if the effort is not
    a ramp, or if the motion is too small.
    """
    line = _line(record, start, end)
    if line is None or line.direction != direction:
        return None
    level, rate = line.level, line.rate
    seen = np.maximum.accumulate(
        direction * (record.position[end:until] - record.position[end - 1])
    )
    if seen[-1] < MOVED_COUNTS * record.resolution:
        return None
    changed = np.flatnonzero(np.diff(seen, prepend=0.0) > 0.5 * record.resolution)[:CHANGES_USED]
    after = record.time[end:until] - record.time[end]
    below = line.left(record, end, end, until)
    left = np.flatnonzero(below)
    changed = changed[: max(1, int(np.searchsorted(changed, left[0])))] if left.size else changed
    before = np.where(changed > 0, seen[changed - 1], 0.0)
    distance = 0.5 * (before + seen[changed] - record.resolution)
    level += rate * record.period * _effort_lead(record)
    if record.load is not None:
        level -= direction * float(record.load[end - 1])
    position = float(record.position[end - 1]) + 0.5 * record.resolution
    rested = float(record.time[end] - record.time[start])
    time = after[changed] - 0.5 * record.period
    return BreakawayOnset(
        direction,
        float(level),
        float(rate),
        time,
        distance,
        position,
        rested,
        _timing(time, distance, record),
        bool(np.ptp(record.position[start:end]) > 0.5 * record.resolution),
    )


class _Line(NamedTuple):
    """Line fitted to |effort| over time; time 0 is a change of the encoder's count.

    Level at time 0 and rate of the line, and rms noise around the line, are in SI units. `rise` is
    the difference between `level` and the lowest |effort| during the rest, N m | N.
    """

    level: float
    rate: float
    noise: float
    direction: float
    rise: float

    @property
    def tolerance(self) -> float:
        """Return the largest allowed distance of the effort below the line, N m | N."""
        return LEFT_THE_RAMP * max(self.noise, RELATIVE_NOISE * self.rise)

    def left(self, record: MotionRecord, zero: int, end: int, until: int) -> NDArray[np.bool_]:
        """Return, for each sample from `end` to `until`, whether the effort is below the line.

        zero: sample of time 0.
        """
        after = record.time[end:until] - record.time[zero]
        expected = self.level + self.rate * after
        below = self.direction * record.effort[end:until] - expected
        return np.asarray(below < -self.tolerance, dtype=np.bool_)


@once_per_record
def _line(record: MotionRecord, start: int, end: int) -> _Line | None:
    """Return the line that |effort| follows up to the sample `end`; None if there is no ramp."""
    first = _straight_from(record, start, end)
    if first is None:
        return None
    time = record.time[first:end] - record.time[end]
    effort = record.effort[first:end]
    constant = float(np.ptp(effort)) <= LEAST_CHANGE
    if constant or straightness(effort) < STRAIGHT:
        return None
    rate, level = np.polyfit(time, effort, 1)
    direction = float(np.sign(rate))
    noise = float(np.std(effort - level - rate * time))
    rise = float(np.max(direction * (level - record.effort[start:end])))
    return _Line(direction * float(level), abs(float(rate)), noise, direction, rise)


def _straight_from(record: MotionRecord, start: int, end: int) -> int | None:
    """Return the first sample of the line that the effort follows up to the sample `end`.

    A ramp that is set by hand may be straight near its end only. The second half of the rest
    [start, end) is therefore halved until the effort is straight: a cubic and a line through the
    effort differ at `end` by noise only, or by at most the fraction CURVED of the rise during the
    rest. Return None if fewer than FEWEST_SAMPLES are left.
    """
    lowest, highest = np.min(record.effort[start:end]), np.max(record.effort[start:end])
    first = start + (end - start) // 2
    while end - first >= FEWEST_SAMPLES:
        effort = record.effort[first:end]
        x = np.linspace(-1.0, 1.0, effort.size)
        fit = np.polynomial.legendre.legfit(x, effort, 3)
        noise = float(np.std(effort - np.polynomial.legendre.legval(x, fit)))
        # standard deviation of cubic minus line at the end, for independent noise
        error = noise * np.sqrt((5.0 + 7.0) / effort.size)
        rise = abs(float(np.sum(fit)) - (lowest if fit[1] > 0.0 else highest))
        if abs(fit[2]) + abs(fit[3]) <= max(SIGNIFICANT * error, CURVED * rise):
            return first
        first += (end - first) // 2
    return None


def _timing(time: Vector, distance: Vector, record: MotionRecord) -> float:
    """Return the weight `timing`, the ratio of two variances in count^2 (onset.py).

    Sampling causes the variance (counts moved per sample)^2/12 of the position at a change. The
    unknown start has the variance 1/12. The ratio is averaged over the intervals between changes.
    """
    if time.size < 2:
        return 1.0  # any positive number: one change alone does not determine the position
    return float(
        np.mean((np.diff(distance) / np.diff(time) * record.period / record.resolution) ** 2)
    )


def _effort_lead(record: MotionRecord) -> float:
    """Return the time [samples] by which the acting effort of a ramp leads the logged effort."""
    before, _, after = effort_weights(record.period, record.effort_lag)
    return after - before
