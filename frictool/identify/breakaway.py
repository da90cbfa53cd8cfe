"""Breakaway from ramps (4.3, figure 4.6): the effort at which rest ends, corrected for the delay with which the encoder shows it.

The thesis takes the largest effort before each motion is seen. The axis has then been moving for some time, in which the ramp went
on: the maximum is late by several steps of the ramp, always upwards. Here the ramp is a line fitted to the effort at rest, read at
the onset that the motion after it tells (`onset`), for which the inertia and the friction of slip have to be known: what is not known
of them widens the interval.

Breakaway is a function of position and direction, which `position_law` finds; a constant is its simplest. Friction in slip, which decides
how fast the axis is seen to move, is taken to follow it (4.42).

    breakaway = mean over the range and both directions, so that an offset of the effort cancels
    interval  = the spread from one onset to the next (each left out in turn), and the ranges of the axis's parameters, and of the place
                within its count in which the axis rests, as far as the spread does not show it (`unknowns`); half a step of a held
                ramp besides: the breakaway lies anywhere within the step, at the same place each time

Onsets inside the backlash after a reversal are left out: there only the motor moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from frictool.documents.bench import Bench
from frictool.identify.dwell import Rising, rising_friction
from frictool.identify.onset import OK, onset_time, search_span
from frictool.identify.outcome import Interval, NothingUsable
from frictool.identify.position_law import Places, Structure, choose_structure, fitted, sides_of
from frictool.identify.record import Record, Vector
from frictool.identify.regression import Singular, Solution
from frictool.identify.smoothing import effort_weights
from frictool.identify.strokes import find_strokes
from frictool.identify.unknowns import half_width

SHORTEST_REST = 30  # samples without a count, for a line to be fitted
STRAIGHT = 0.8  # least squared correlation of effort and time at rest: a ramp
MOVED_COUNTS = 0.5  # a motion ends further than this from where it began: one count to and fro is none
CHANGES_USED = 4  # of the encoder after the onset: later ones tell more of the inertia than of the onset
FEWEST_ONSETS = 5
RELATIVE_NOISE = 1e-3  # of the effort: the least that its noise is taken for
START = "start"
ROUNDS = 3  # of the friction's shape over position and the onsets that it tells
LEFT_THE_RAMP = 5.0  # standard deviations of the effort: the ramp was taken back


@dataclass(frozen=True)
class Onset:
    """One breakaway. direction +-1; `level` and `rate`: the line of |effort|, N m | N at time 0 and per s; time 0 is when motion is seen.

    `time` (n,) in s of the encoder's changes, `seen` (n,) the distance at each, from the first change. `position`: of the rest, rad | m,
    the middle of its count; `rested`: s without a count before it.
    """

    direction: float
    level: float
    rate: float
    time: Vector
    seen: Vector
    position: float
    rested: float


@dataclass(frozen=True)
class ByPosition:
    """Breakaway over [low, high], rad | m: its means forward and backward, and powers of the position, lowest first, in N m | N.

    `common`: the same in both directions.
    """

    low: float
    high: float
    forward: Interval
    backward: Interval
    powers: tuple[tuple[float, ...], tuple[float, ...]]
    common: bool


@dataclass(frozen=True)
class Breakaway:
    """The mean breakaway; mean |effort| forward and backward (nan where there is none), number of onsets; mean delay corrected, N m | N.

    by_position: None where the breakaway is one constant. rising: None where it does not grow with the time at rest; else `interval` is
    that after a long rest.
    """

    interval: Interval
    forward: float
    backward: float
    onsets: int
    delay: float
    by_position: ByPosition | None = None
    rising: Rising | None = None


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
    changed = np.flatnonzero(np.diff(seen, prepend=0.0) > 0.5 * record.resolution)[:CHANGES_USED]
    after = record.time[end:until] - record.time[end]
    below = direction * record.effort[end:until] - level - rate * after < -LEFT_THE_RAMP * max(noise, RELATIVE_NOISE * level)
    left = np.flatnonzero(below)
    changed = changed[: max(1, int(np.searchsorted(changed, left[0])))] if left.size else changed
    before = np.where(changed > 0, seen[changed - 1], 0.0)
    distance = 0.5 * (before + seen[changed] - record.resolution)
    level += rate * record.period * _above(record)
    place, rested = float(record.position[start]) + 0.5 * record.resolution, float(record.time[end] - record.time[start])
    return Onset(direction, float(level), float(rate), after[changed] - 0.5 * record.period, distance, place, rested)


def _above(record: Record) -> float:
    """By how many steps of the ramp the effort between two rows is above the line through them, on average.

    A held effort acts half a sample later than its row says; one that lags behind a held command bulges towards it.
    """
    before, _, after = effort_weights(record.period, record.lag)
    return after - before


def efforts(onsets: list[Onset], axis: Mapping[str, float], resolution: float, shape: Vector | None = None) -> Vector:
    """|effort| (n,) at each onset, for an axis with these `inertia`, `viscous`, `coulomb` and `offset` in SI.

    `start`: which share of a count the axis is expected to travel before the encoder changes. shape (n,): factors of `coulomb` where the
    onsets are.
    """
    out = np.empty(len(onsets))
    for k, onset in enumerate(onsets):
        # in the axis's own frame the offset takes its share of the effort before friction does
        ramp = np.array([onset.level - onset.direction * axis["offset"], onset.rate])
        coulomb = axis["coulomb"] * (1.0 if shape is None else shape[k])
        coefficients = np.array([axis["inertia"], axis["viscous"], coulomb])
        span = search_span(resolution, onset.rate, axis["inertia"], CHANGES_USED)
        t0, status = onset_time(onset.time, onset.seen, ramp, coefficients, resolution, axis[START] * resolution, span)
        out[k] = onset.level + onset.rate * t0 if status == OK else np.nan
    return out


@dataclass(frozen=True)
class Evidence:
    """The onsets that count, where they are, and what is known of their axis."""

    onsets: list[Onset]
    places: Places
    resolution: float
    offset: float | None  # N m | N, the bench's; None where one direction only makes it a parameter of the axis

    def friction(self, axis: Mapping[str, float], shape: Vector | None) -> Vector:
        """|effort| less the offset, (n,)."""
        offset = axis["offset"] if self.offset is None else self.offset
        return efforts(self.onsets, axis, self.resolution, shape) - offset * self.places.direction

    def shape(self, structure: Structure, value: Vector) -> Vector:
        """The factors (n,) of the friction at the onsets over their mean: friction in slip follows the breakaway (4.42)."""
        curve = self.places.design(structure) @ value
        if structure.common:
            curve = curve - value[-1] * self.places.direction
        return np.asarray(curve / np.mean(curve))


def breakaway(records: list[Record], bench: Bench, axis: Mapping[str, Interval], confidence: float) -> Breakaway:
    """The breakaway of ramp logs; `axis` gives `inertia`, `viscous`, `coulomb`, `offset` as far as they are known.

    Raises NothingUsable where fewer than five onsets are found in every direction. With one direction only, the offset is taken off.
    """
    evidence = _evidence(records, bench)
    axis = {**axis, START: Interval(0.5, 0.0, 1.0)}
    nominal = {name: known.value for name, known in axis.items()}
    try:
        structure, shape, solution, friction = _settled(evidence, nominal)
        moved = {name: _moved(evidence, structure, shape, nominal, name, known) for name, known in axis.items()}
    except Singular as error:
        raise NothingUsable(f"the breakaways do not tell friction over position: {error}") from None
    moved[START] *= _unseen(evidence, nominal, shape, friction - evidence.places.design(structure) @ solution.value)
    step = 0.5 * max(onset.rate for onset in evidence.onsets) * records[0].period if any(record.lag == 0.0 for record in records) else 0.0

    def interval(weights: Vector) -> Interval:
        value, statistical = float(weights @ solution.value), float(np.linalg.norm(weights * solution.half_width(confidence)))
        ranges = [0.5 * float(weights @ change) for change in moved.values()]
        half = step + half_width(confidence, statistical / float(ndtri(0.5 + 0.5 * confidence)), ranges)
        return Interval(value, value - half, value + half)

    rested = np.array([onset.rested for onset in evidence.onsets])
    rising = rising_friction(rested, evidence.places.direction, friction, confidence) if structure.constant else None
    levels = _levels(structure)
    mean = interval(np.mean(levels, axis=0))
    if rising is not None:
        mean = _wider(rising.full, mean.half_width)
    law = None if structure.constant or len(levels) < 2 else _by_position(evidence.places, structure, solution, list(map(interval, levels)))
    seen = efforts(evidence.onsets, nominal, evidence.resolution, shape)
    means = [
        float(np.mean(seen[side])) if side.any() else np.nan for side in (evidence.places.direction > 0.0, evidence.places.direction < 0.0)
    ]
    late = float(np.mean([onset.level for onset in evidence.onsets]) - np.mean(seen))
    return Breakaway(mean, means[0], means[1], len(evidence.onsets), late, law, rising)


def _wider(found: Interval, half: float) -> Interval:
    """With what is not known of the axis besides."""
    width = float(np.hypot(found.half_width, half))
    return Interval(found.value, found.value - width, found.value + width)


def _evidence(records: list[Record], bench: Bench) -> Evidence:
    """The onsets of the directions that have enough of them."""
    found = [onset for record in records for onset in find_onsets(record, bench)]
    used = [onset for onset in found if sum(o.direction == onset.direction for o in found) >= FEWEST_ONSETS]
    if not used:
        raise NothingUsable(f"{len(found)} breakaways under a growing effort; at least {FEWEST_ONSETS} in one direction are needed")
    position, direction = np.array([o.position for o in used]), np.array([o.direction for o in used])
    places = Places(position, direction, float(position.min()), float(position.max()))
    known = bench.mechanics.offset
    one_way = abs(float(np.sum(direction))) == direction.size
    return Evidence(used, places, records[0].resolution, None if one_way else 0.0 if known is None else known.value)


def _settled(evidence: Evidence, nominal: Mapping[str, float]) -> tuple[Structure, Vector | None, Solution, Vector]:
    """The structure, the shape that friction in slip has with it, the fit, and the friction (n,), in agreement with each other."""
    shape: Vector | None = None
    for _ in range(ROUNDS):
        friction = evidence.friction(nominal, shape)
        structure = choose_structure(evidence.places, friction)
        solution = fitted(evidence.places, friction, structure)
        if structure.constant:
            break
        shape = evidence.shape(structure, solution.value)
    return structure, shape, solution, friction


def _levels(structure: Structure) -> list[Vector]:
    """What the mean in each direction is of the coefficients: (p,) each, forward first; one where there is one direction."""
    if structure.common:
        unit = np.eye(structure.orders[0] + 2)
        return [unit[0], unit[0]]
    sizes = [order + 1 for order in structure.orders]
    unit = np.eye(sum(sizes))
    return [unit[first] for first, size in zip((0, sizes[0]), sizes, strict=True) if size]


def _moved(evidence: Evidence, structure: Structure, shape: Vector | None, nominal: dict[str, float], name: str, known: Interval) -> Vector:
    """How far the coefficients (p,) move from one end of what is known of a parameter to the other."""
    low, high = (evidence.friction({**nominal, name: value}, shape) for value in (known.low, known.high))
    return np.asarray(np.linalg.lstsq(evidence.places.design(structure), high - low, rcond=None)[0])


def _unseen(evidence: Evidence, nominal: dict[str, float], shape: Vector | None, residual: Vector) -> float:
    """Which share of what the place within a count does is common to all onsets, and so not in their spread `residual` (n,).

    Places that are spread over the count show at least as much spread as they cause; where there is less, the rests repeat one place.
    """
    low, high = (evidence.friction({**nominal, START: value}, shape) for value in (0.0, 1.0))
    caused = float(np.mean((high - low) ** 2)) / 12.0
    return float(np.sqrt(max(0.0, 1.0 - float(np.var(residual)) / caused))) if caused > 0.0 else 0.0


def _by_position(places: Places, structure: Structure, solution: Solution, levels: list[Interval]) -> ByPosition:
    forward, backward = (places.powers(side) for side in sides_of(structure, solution.value))
    return ByPosition(places.low, places.high, levels[0], levels[1], (forward, backward), structure.common)
