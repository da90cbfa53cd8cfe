"""Breakaway from ramps (4.3, figure 4.6): the effort at which rest ends, corrected for the delay with which the encoder shows it.

The thesis takes the largest effort before each motion is seen. The axis has then been moving for some time, in which the ramp went
on: the maximum is late by several steps of the ramp, always upwards. Here the ramp is a line fitted to the effort at rest, read at
the onset that the motion after it tells (`onset`), for which the inertia and the friction of slip have to be known: what is not known
of them widens the interval.

    breakaway = mean of the mean in either direction, so that an offset of the effort cancels
    interval  = Student's, of the spread from one onset to the next, and the ranges of the axis's parameters, and of the place within
                its count in which the axis rests, taken as uniform; added in quadrature

Onsets inside the backlash after a reversal are left out: there only the motor moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit

from frictool.documents.bench import Bench
from frictool.identify.onset import OK, onset_time, search_span
from frictool.identify.outcome import Interval, NothingUsable
from frictool.identify.record import Record, Vector
from frictool.identify.strokes import find_strokes

SHORTEST_REST = 30  # samples without a count, for a line to be fitted
STRAIGHT = 0.8  # least squared correlation of effort and time at rest: a ramp
MOVED_COUNTS = 0.5  # a motion ends further than this from where it began: one count to and fro is none
CHANGES_USED = 4  # of the encoder after the onset: later ones tell more of the inertia than of the onset
FEWEST_ONSETS = 5
RELATIVE_NOISE = 1e-3  # of the effort: the least that its noise is taken for
START = "start"
LEFT_THE_RAMP = 5.0  # standard deviations of the effort: the ramp was taken back


@dataclass(frozen=True)
class Onset:
    """One breakaway. direction +-1; `level` and `rate`: the line of |effort|, N m | N at time 0 and per s; time 0 is when motion is seen.

    `time` (n,) in s of the encoder's changes, `seen` (n,) the distance at each, from the first change.
    """

    direction: float
    level: float
    rate: float
    time: Vector
    seen: Vector


@dataclass(frozen=True)
class Breakaway:
    """The mean breakaway; mean |effort| forward and backward (nan where there is none), number of onsets; mean delay corrected, N m | N."""

    interval: Interval
    forward: float
    backward: float
    onsets: int
    delay: float


def is_ramp(record: Record, bench: Bench) -> bool:
    """Whether a log is one of breakaway ramps: at rest for most of its time, and rest ends under an effort that grows along a line."""
    moving = np.abs(np.diff(record.position)) > 0.5 * record.resolution
    starts, ends = _rests(record)
    if starts.size < FEWEST_ONSETS or np.mean(moving) > 0.5 or np.sum(ends - starts) < 0.5 * record.time.size:
        return False
    return len(find_onsets(record, bench)) >= max(FEWEST_ONSETS, starts.size // 4)


def _rests(record: Record) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First sample of each rest, and the first sample after it at which the encoder has moved."""
    changed = np.flatnonzero((np.abs(np.diff(record.position)) > 0.5 * record.resolution) | (np.diff(record.piece) > 0)) + 1
    edges = np.concatenate(([0], changed))
    starts, ends = edges[:-1], edges[1:]
    long = ends - starts >= SHORTEST_REST
    return starts[long], ends[long]


def find_onsets(record: Record, bench: Bench) -> list[Onset]:
    """Every breakaway under a growing effort, with the load attached."""
    width = bench.mechanics.backlash
    gap = 0.0 if width is None else max(width.interval) + 2.0 * record.resolution
    strokes, (starts, ends) = find_strokes(record), _rests(record)
    following = np.append(starts[1:] + 1, record.position.size)  # a rest begins with the place where the motion has ended
    found = []
    for start, end, until in zip(starts, ends, following, strict=True):
        direction = float(strokes.sign[end])
        if direction == 0.0 or strokes.advance[end] < gap or record.piece[end] != record.piece[end - 1]:
            continue
        onset = _onset(record, int(start), int(end), int(until), direction)
        if onset is not None:
            found.append(onset)
    return found


def _onset(record: Record, start: int, end: int, until: int, direction: float) -> Onset | None:
    """The breakaway that ends the rest [start, end), seen until `until`, or None where the effort is no ramp or the motion too small."""
    ramp = slice(start + (end - start) // 2, end)
    time, effort = record.time[ramp] - record.time[end], direction * record.effort[ramp]
    if float(np.ptp(effort)) == 0.0:
        return None
    rate, level = np.polyfit(time, effort, 1)
    noise = float(np.std(effort - level - rate * time))
    seen = direction * (record.position[end:until] - record.position[end - 1])
    if rate <= 0.0 or np.corrcoef(time, effort)[0, 1] ** 2 < STRAIGHT or seen[-1] < MOVED_COUNTS * record.resolution:
        return None
    # a held effort acts half a sample later than its row says
    shift = 0.5 * record.period if record.lag == 0.0 else 0.0
    changed = np.flatnonzero(np.diff(seen, prepend=0.0) > 0.5 * record.resolution)[:CHANGES_USED]
    after = record.time[end:until] - record.time[end]
    below = direction * record.effort[end:until] - level - rate * after < -LEFT_THE_RAMP * max(noise, RELATIVE_NOISE * level)
    left = np.flatnonzero(below)
    changed = changed[: max(1, int(np.searchsorted(changed, left[0])))] if left.size else changed
    before = np.where(changed > 0, seen[changed - 1], 0.0)
    distance = 0.5 * (before + seen[changed] - record.resolution)
    return Onset(direction, float(level - rate * shift), float(rate), after[changed] - 0.5 * record.period, distance)


def efforts(onsets: list[Onset], axis: Mapping[str, float], resolution: float) -> Vector:
    """|effort| (n,) at each onset, for an axis with these `inertia`, `viscous`, `coulomb` and `offset` in SI.

    `start`: which share of a count the axis is expected to travel before the encoder changes.
    """
    out = np.empty(len(onsets))
    for k, onset in enumerate(onsets):
        # in the axis's own frame the offset takes its share of the effort before friction does
        ramp = np.array([onset.level - onset.direction * axis["offset"], onset.rate])
        coefficients = np.array([axis["inertia"], axis["viscous"], axis["coulomb"]])
        span = search_span(resolution, onset.rate, axis["inertia"], CHANGES_USED)
        t0, status = onset_time(onset.time, onset.seen, ramp, coefficients, resolution, axis[START] * resolution, span)
        out[k] = onset.level + onset.rate * t0 if status == OK else np.nan
    return out


def breakaway(records: list[Record], bench: Bench, axis: Mapping[str, Interval], confidence: float) -> Breakaway:
    """The breakaway of ramp logs; `axis` gives `inertia`, `viscous`, `coulomb`, `offset` as far as they are known.

    Raises NothingUsable where fewer than five onsets are found in every direction. With one direction only, the offset is taken off.
    """
    onsets = [onset for record in records for onset in find_onsets(record, bench)]
    sides = {side: [o for o in onsets if o.direction == side] for side in (1.0, -1.0)}
    used = {side: group for side, group in sides.items() if len(group) >= FEWEST_ONSETS}
    if not used:
        raise NothingUsable(f"{len(onsets)} breakaways under a growing effort; at least {FEWEST_ONSETS} in one direction are needed")
    axis = {**axis, START: Interval(0.5, 0.0, 1.0)}
    nominal, step = {name: known.value for name, known in axis.items()}, records[0].resolution
    by_side = {side: _friction(group, nominal, step, len(used)) for side, group in used.items()}
    means = {side: float(np.mean(values)) for side, values in by_side.items()}
    value = float(np.mean(list(means.values())))
    statistical = _statistical(list(by_side.values()), confidence)
    variance = _variance_of_unknowns(used, axis, nominal, step) + _variance_of_steps(onsets, records)
    half = float(np.hypot(statistical, ndtri(0.5 + 0.5 * confidence) * np.sqrt(variance)))
    late = np.mean([np.mean([o.level for o in group]) for group in used.values()])
    early = np.mean([np.mean(efforts(group, nominal, step)) for group in used.values()])
    interval = Interval(value, value - half, value + half)
    return Breakaway(interval, means.get(1.0, np.nan), means.get(-1.0, np.nan), sum(map(len, used.values())), float(late - early))


def _friction(group: list[Onset], axis: Mapping[str, float], resolution: float, sides: int) -> Vector:
    """|effort| (n,) at the onsets of one direction; less the offset where no other direction cancels it."""
    offset = group[0].direction * axis["offset"] if sides == 1 else 0.0
    return efforts(group, axis, resolution) - offset


def _statistical(groups: list[Vector], confidence: float) -> float:
    """Half width for the mean of the groups' means: Welch's."""
    parts = np.array([np.var(values, ddof=1) / values.size for values in groups]) / len(groups) ** 2
    total = float(np.sum(parts))
    if total == 0.0:
        return 0.0
    freedom = total**2 / float(np.sum(parts**2 / np.array([values.size - 1 for values in groups])))
    return float(stdtrit(freedom, 0.5 + 0.5 * confidence) * np.sqrt(total))


def _variance_of_unknowns(
    used: dict[float, list[Onset]], axis: Mapping[str, Interval], nominal: dict[str, float], resolution: float
) -> float:
    """What the ranges of the axis's parameters add to the variance: each moved to its ends, uniform within."""
    variance = 0.0
    for name, known in axis.items():
        ends = [
            float(np.mean([np.mean(_friction(group, {**nominal, name: value}, resolution, len(used))) for group in used.values()]))
            for value in (known.low, known.high)
        ]
        variance += (ends[1] - ends[0]) ** 2 / 12.0
    return variance


def _variance_of_steps(onsets: list[Onset], records: list[Record]) -> float:
    """A held effort grows in steps, and the breakaway lies anywhere within one; the same place each time if the ramp starts from 0."""
    held = any(record.lag == 0.0 for record in records)
    return (max(onset.rate for onset in onsets) * records[0].period) ** 2 / 12.0 if held else 0.0
