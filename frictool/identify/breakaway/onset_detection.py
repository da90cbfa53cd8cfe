"""Detection of breakaways in a log of ramps.

Each breakaway is described by a line that is fitted to the effort at rest, and by the times at
which the encoder's count changes after the onset of motion. Onsets inside the backlash after a
reversal are left out, because only the motor moves there.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.strokes import find_strokes
from frictool.logs.quality.ramps import STRAIGHT, are_ramps, ramps_among, rests_of
from frictool.plant.weak_form import effort_weights
from frictool.typing import Vector

MOVED_COUNTS = 0.5  # least net distance of a motion, in counts
# number of encoder changes used after an onset; later changes depend more on the inertia
CHANGES_USED = 4
FEWEST_ONSETS = 5
FEWEST_SAMPLES = 12  # least number of samples of the line at the end of a ramp
# least difference at the end of a ramp between a cubic and a line at which the ramp is curved: in
# standard deviations, and relative to the effort
SIGNIFICANT, CURVED = 4.0, 2e-3
RELATIVE_NOISE = 1e-3  # least noise of the effort, relative to its level
# the ramp has ended if the effort is below the line by more than this many standard deviations
LEFT_THE_RAMP = 5.0


@dataclass(frozen=True, eq=False)
class BreakawayOnset:
    """One breakaway; the time is 0 at the first visible motion.

    - direction: direction of the motion, +1 or -1
    - level, rate: value at time 0 [N m | N] and slope [N m/s | N/s] of the line that is fitted to
      |effort| at rest
    - time: times at which the encoder's count changes, (n,), s
    - seen: distance from the first change to each change, (n,), rad | m
    - position: middle of the encoder count in which the axis rested, rad | m
    - rested: time at rest before the onset, s
    - timing: weight of the expected rest position, defined in `onset.py`
    """

    direction: float
    level: float
    rate: float
    time: Vector
    seen: Vector
    position: float
    rested: float
    timing: float


def is_ramp(record: MotionRecord, bench: Bench) -> bool:
    """Return True if a log consists of breakaway ramps, and has at least FEWEST_ONSETS onsets."""
    if not are_ramps(_rests(record), record.position, record.effort):
        return False
    return len(list(itertools.islice(_onsets(record, bench), FEWEST_ONSETS))) == FEWEST_ONSETS


def why_unusable(record: MotionRecord, bench: Bench) -> str | None:
    """Return why a log of ramps has too few breakaways for `is_ramp`; None without ramps."""
    rests = _rests(record)
    if not are_ramps(rests, record.position, record.effort):
        return None
    ramps = int(np.sum(ramps_among(rests, record.position, record.effort)))
    usable = len(find_onsets(record, bench))
    text = (
        f"{Path(record.name).name} has {ramps} ramps, but {usable} usable breakaways; needed: "
        f"{FEWEST_ONSETS}"
    )
    if bench.mechanics.backlash is None:
        return f"{text}: from rest, raise the effort evenly until the axis moves, and repeat"
    unit = "rad" if bench.axis == "rotary" else "m"
    return (
        f"{text}; after a reversal, move the axis {_least_motion(record, bench):.3g} {unit} "
        "(backlash) and stop it; then raise the effort evenly in the same direction"
    )


def _rests(record: MotionRecord) -> list[tuple[int, int]]:
    """Return (start, stop) of each interval at rest; the position changes at the sample `stop`."""
    return rests_of(
        (np.abs(np.diff(record.position)) > 0.5 * record.resolution) | (np.diff(record.piece) > 0)
    )


def find_onsets(record: MotionRecord, bench: Bench) -> list[BreakawayOnset]:
    """Return every breakaway of a record under a growing effort and outside the backlash."""
    return list(_onsets(record, bench))


def _onsets(record: MotionRecord, bench: Bench) -> Iterator[BreakawayOnset]:
    gap = _least_motion(record, bench)
    strokes, rests = find_strokes(record), _rests(record)
    # a rest begins at the position at which the motion has ended
    following = [start + 1 for start, _ in rests[1:]] + [record.position.size]
    for (start, end), until, ramp in zip(
        rests, following, ramps_among(rests, record.position, record.effort), strict=False
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
            yield onset


def _least_motion(record: MotionRecord, bench: Bench) -> float:
    """Return the motion [rad | m] that closes the backlash after a reversal; 0 without backlash."""
    width = bench.mechanics.backlash
    return 0.0 if width is None else max(width.interval) + 2.0 * record.resolution


def _onset(
    record: MotionRecord, start: int, end: int, until: int, direction: float
) -> BreakawayOnset | None:
    """Return the breakaway after a rest with the samples [start, end).

    The motion is examined up to the sample `until`. Return None if the effort is not a ramp or the
    motion is too small.
    """
    first = _straight_from(record, start + (end - start) // 2, end)
    if first is None:
        return None
    ramp = slice(first, end)
    time = record.time[ramp] - record.time[end]
    effort = direction * record.effort[ramp]
    if float(np.ptp(effort)) == 0.0:
        return None
    rate, level = np.polyfit(time, effort, 1)
    noise = float(np.std(effort - level - rate * time))
    seen = direction * (record.position[end:until] - record.position[end - 1])
    if (
        rate <= 0.0
        or np.corrcoef(time, effort)[0, 1] ** 2 < STRAIGHT
        or seen[-1] < MOVED_COUNTS * record.resolution
    ):
        return None
    changed = np.flatnonzero(np.diff(seen, prepend=0.0) > 0.5 * record.resolution)[:CHANGES_USED]
    after = record.time[end:until] - record.time[end]
    below = direction * record.effort[end:until] - level - rate * after < -LEFT_THE_RAMP * max(
        noise, RELATIVE_NOISE * level
    )
    left = np.flatnonzero(below)
    changed = changed[: max(1, int(np.searchsorted(changed, left[0])))] if left.size else changed
    before = np.where(changed > 0, seen[changed - 1], 0.0)
    distance = 0.5 * (before + seen[changed] - record.resolution)
    level += rate * record.period * _above(record)
    position = float(record.position[start]) + 0.5 * record.resolution
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
    )


def _straight_from(record: MotionRecord, first: int, end: int) -> int | None:
    """Return the first sample of the line that the effort follows up to the sample `end`.

    A ramp that is set by hand may be straight near its end only. The interval [first, end) is
    therefore halved until it is straight: a cubic and a line through the effort differ at `end` by
    noise only, or by at most the fraction CURVED of the effort. Return None if fewer than
    FEWEST_SAMPLES are left.
    """
    while end - first >= FEWEST_SAMPLES:
        effort = record.effort[first:end]
        x = np.linspace(-1.0, 1.0, effort.size)
        fit = np.polynomial.legendre.legfit(x, effort, 3)
        noise = float(np.std(effort - np.polynomial.legendre.legval(x, fit)))
        # standard deviation of the curve at its end, for independent noise
        error = noise * np.sqrt((5.0 + 7.0) / effort.size)
        if abs(fit[2]) + abs(fit[3]) <= max(SIGNIFICANT * error, CURVED * abs(float(np.sum(fit)))):
            return first
        first += (end - first) // 2
    return None


def _timing(time: Vector, distance: Vector, record: MotionRecord) -> float:
    """Return the weight `timing` of an onset, the mean square distance per sample [counts^2]."""
    if time.size < 2:
        return 1.0  # any positive number: one change alone does not determine the position
    return float(
        np.mean((np.diff(distance) / np.diff(time) * record.period / record.resolution) ** 2)
    )


def _above(record: MotionRecord) -> float:
    """Return the time [samples] by which the acting effort of a ramp leads the logged effort."""
    before, _, after = effort_weights(record.period, record.lag)
    return after - before
