"""Breakaway from ramps (4.3, figure 4.6): the effort at which rest ends, corrected for the delay
with which the encoder shows it.

The thesis takes the largest effort before each motion is seen. The axis has then been moving for
some time, in which the ramp went on: the maximum is late by several steps of the ramp, always
upwards. Here the ramp is a line fitted to the effort at rest, read at the onset that the motion
after it tells (`onset`), for which the inertia and the friction of slip have to be known: what is
not known of them widens the interval.

Breakaway is a function of position and direction, which `position_law` finds; a constant is its
simplest. Friction in slip, which decides how fast the axis is seen to move, is taken to follow it
(4.42).

    breakaway = mean over the range and both directions, so that an offset of the effort cancels
    fall      = the Stribeck velocity that another log gives, or those that the changes of the
              encoder allow (`fall`): the value is that
                of a fall at once where that is allowed, and the interval holds the breakaways of
                all that are allowed
    interval  = the spread from one onset to the next (each left out in turn), and the ranges of the
    axis's parameters (`unknowns`); half
                a step of a held ramp besides: the breakaway lies anywhere within the step, at the
                same place each time; and as motion then begins with a sample, its changes are late
                by as much each time: anything within half a sample

Where within its count the axis rests follows from its changes too, but for what the timing hides. A
test that takes the ramp back when the encoder has changed so many times brings the axis to rest at
much the same place each time: it is the mean of all onsets (`Rest`) that decides what a single one
leaves open.

Onsets inside the backlash after a reversal are left out: there only the motor moves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.special import ndtri

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.breakaway.onset import OK, onset_time, search_span
from frictool.identify.breakaway.position_law import (
    FOLLOWING,
    BreakawayPositions,
    PolynomialOrders,
    choose_structure,
    fit_polynomials,
    sides_of,
)
from frictool.identify.breakaway.rising_friction import RisingFriction, rising_friction
from frictool.identify.breakaway.stribeck_velocity import StribeckVelocityRange, allowed_fall
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.regression.regression import LeastSquaresSolution, SingularRegressors
from frictool.identify.rows.strokes import find_strokes
from frictool.logs.quality.ramps import STRAIGHT, are_ramps, ramps_among, rests_of
from frictool.plant.weak_form import effort_weights

MOVED_COUNTS = (
    0.5  # a motion ends further than this from where it began: one count to and fro is none
)
CHANGES_USED = (
    4  # of the encoder after the onset: later ones tell more of the inertia than of the onset
)
FEWEST_ONSETS = 5
RELATIVE_NOISE = 1e-3  # of the effort: the least that its noise is taken for
PRIOR = 12.0  # precision of a place that is anywhere within its count
UNIFORM = float(np.sqrt(3.0))  # half a range over its standard deviation
ONSETS_COMPARED = (
    100  # at most, evenly spaced, when Stribeck velocities are compared: they count as one anyway
)
ROUNDS = 3  # of the friction's shape over position and the onsets that it tells
PLACES = 200  # over the range of the breakaways, at which their law has to be positive
LEFT_THE_RAMP = 5.0  # standard deviations of the effort: the ramp was taken back


@dataclass(frozen=True)
class BreakawayOnset:
    """One breakaway. direction +-1; `level` and `rate`: the line of |effort|, N m | N at time 0 and
    per s; time 0 is when motion is seen.

    `time` (n,) in s of the encoder's changes, `seen` (n,) the distance at each, from the first
    change. `position`: of the rest, rad | m, the middle of its count; `rested`: s without a count
    before it. `timing`: see `onset`.
    """

    direction: float
    level: float
    rate: float
    time: Vector
    seen: Vector
    position: float
    rested: float
    timing: float


@dataclass(frozen=True)
class BreakawayOverPosition:
    """Breakaway over [low, high], rad | m: its means forward and backward, and powers of the
    position, lowest first, in N m | N.

    unsure: the interval of each power. `common`: the same in both directions.
    """

    low: float
    high: float
    forward: Interval
    backward: Interval
    powers: tuple[tuple[float, ...], tuple[float, ...]]
    unsure: tuple[tuple[Interval, ...], tuple[Interval, ...]]
    common: bool


@dataclass(frozen=True)
class Breakaway:
    """The mean breakaway; mean |effort| forward and backward (nan where there is none), number of
    onsets; mean delay corrected, N m | N.

    position, direction, friction (n,): each breakaway's place in rad | m, +-1, and |effort| less
    the offset.

    fall: Stribeck velocities that the interval holds.

    by_position: None where the breakaway is one constant. rising: None where it does not grow with
    the time at rest; else `interval` is that after a long rest.
    """

    interval: Interval
    forward: float
    backward: float
    onsets: int
    delay: float
    position: Vector
    direction: Vector
    friction: Vector
    fall: StribeckVelocityRange
    by_position: BreakawayOverPosition | None = None
    rising: RisingFriction | None = None


def is_ramp(record: MotionRecord, bench: Bench) -> bool:
    """Return whether a log is one of breakaway ramps, with enough of them for `breakaway`."""
    return (
        are_ramps(_rests(record), record.position, record.effort)
        and len(find_onsets(record, bench)) >= FEWEST_ONSETS
    )


def _rests(record: MotionRecord) -> list[tuple[int, int]]:
    """First sample of each rest, and the first sample after it at which the encoder has moved."""
    return rests_of(
        (np.abs(np.diff(record.position)) > 0.5 * record.resolution) | (np.diff(record.piece) > 0)
    )


def find_onsets(record: MotionRecord, bench: Bench) -> list[BreakawayOnset]:
    """Every breakaway under a growing effort, with the load attached."""
    width = bench.mechanics.backlash
    gap = 0.0 if width is None else max(width.interval) + 2.0 * record.resolution
    strokes, rests = find_strokes(record), _rests(record)
    following = [start + 1 for start, _ in rests[1:]] + [
        record.position.size
    ]  # a rest begins with the place where the motion has ended
    found = []
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
            found.append(onset)
    return found


def _onset(
    record: MotionRecord, start: int, end: int, until: int, direction: float
) -> BreakawayOnset | None:
    """The breakaway that ends the rest [start, end), seen until `until`, or None where the effort
    is no ramp or the motion too small."""
    ramp = slice(start + (end - start) // 2, end)
    time, effort = record.time[ramp] - record.time[end], direction * record.effort[ramp]
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
    place, rested = (
        float(record.position[start]) + 0.5 * record.resolution,
        float(record.time[end] - record.time[start]),
    )
    time = after[changed] - 0.5 * record.period
    return BreakawayOnset(
        direction,
        float(level),
        float(rate),
        time,
        distance,
        place,
        rested,
        _timing(time, distance, record),
    )


def _timing(time: Vector, distance: Vector, record: MotionRecord) -> float:
    """How far the axis moves in a sample, in counts, squared: the mean over its changes."""
    if time.size < 2:
        return 1.0  # any positive number: nothing is left to weigh it against
    return float(
        np.mean((np.diff(distance) / np.diff(time) * record.period / record.resolution) ** 2)
    )


def _above(record: MotionRecord) -> float:
    """By how many steps of the ramp the effort between two rows is above the line through them, on
    average.

    A held effort acts half a sample later than its row says; one that lags behind a held command
    bulges towards it.
    """
    before, _, after = effort_weights(record.period, record.lag)
    return after - before


def efforts(
    onsets: list[BreakawayOnset],
    axis: Mapping[str, float],
    resolution: float,
    start: float,
    shape: Vector | None = None,
    velocity: float = 0.0,
) -> tuple[Vector, Vector, Vector]:
    """|effort| (n,) at each onset, place of rest within its count (n,), 0 to 1, and misfit (n,) of
    the encoder's changes over `timing`.

    axis: `inertia`, `viscous`, `coulomb` and `offset` in SI. start: the place that is expected.
    shape (n,): factors of `coulomb` where the onsets are. velocity: Stribeck velocity; 0: friction
    falls at once; inf: it does not.
    """
    out, places, squares = np.empty(len(onsets)), np.empty(len(onsets)), np.empty(len(onsets))
    for k, onset in enumerate(onsets):
        # in the axis's own frame the offset takes its share of the effort before friction does
        ramp = np.array([onset.level - onset.direction * axis["offset"], onset.rate])
        coulomb = axis["coulomb"] * (1.0 if shape is None else shape[k])
        coefficients = np.array([axis["inertia"], axis["viscous"], coulomb])
        span = search_span(resolution, onset.rate, axis["inertia"], CHANGES_USED)
        t0, place, left, status = onset_time(
            onset.time,
            onset.seen,
            ramp,
            coefficients,
            resolution,
            start * resolution,
            onset.timing,
            span,
            velocity,
        )
        out[k], places[k] = (
            (onset.level + onset.rate * t0, place / resolution)
            if status == OK
            else (np.nan, np.nan)
        )
        squares[k] = 12.0 * left / (onset.timing * resolution**2)
    return out, places, squares


@dataclass(frozen=True)
class OnsetData:
    """The onsets that count, where they are, and what is known of their axis."""

    onsets: list[BreakawayOnset]
    places: BreakawayPositions
    resolution: float
    offset: (
        float | None
    )  # N m | N, the bench's; None where one direction only makes it a parameter of the axis
    velocity: float = 0.0  # rad/s | m/s: the Stribeck velocity that is assumed

    def misfit(self, axis: Mapping[str, float], shape: Vector | None, velocity: float) -> float:
        """Return the mean misfit of an onset (`efforts`) with friction that falls over a Stribeck
        velocity."""
        every = slice(None, None, math.ceil(len(self.onsets) / ONSETS_COMPARED))
        factors = None if shape is None else shape[every]
        return float(
            np.mean(efforts(self.onsets[every], axis, self.resolution, 0.5, factors, velocity)[2])
        )

    def fall(
        self, axis: Mapping[str, Interval], shape: Vector | None, confidence: float
    ) -> StribeckVelocityRange:
        """Return the Stribeck velocities that the onsets allow with parameters in the intervals of
        `axis`."""
        nominal = {name: known.value for name, known in axis.items()}
        ends = [
            {**nominal, name: end}
            for name, known in axis.items()
            for end in (known.low, known.high)
            if end != known.value
        ]
        ends = [end for end in ends if end["inertia"] > 0.0]
        rate = float(np.mean([onset.rate for onset in self.onsets]))
        scale = float(np.cbrt(self.resolution**2 * rate / nominal["inertia"]))
        misfits = [partial(self.misfit, parameters, shape) for parameters in (nominal, *ends)]
        return allowed_fall(misfits[0], misfits[1:], scale, confidence)

    def rest(self, axis: Mapping[str, float], shape: Vector | None) -> tuple[float, float]:
        """The mean place of rest within a count, 0 to 1, and its standard deviation.

        What is found leans towards what is expected: found = told + lean expected. Where found is
        expected, told/(1 - lean), the timing decides alone; as far as it decides nothing, anywhere
        within the count is as likely.
        """
        low, high = (
            efforts(self.onsets, axis, self.resolution, expected, shape, self.velocity)[1]
            for expected in (0.0, 1.0)
        )
        told, tells = float(np.mean(low)), max(1.0 - float(np.mean(high - low)), 1e-6)
        independent = max(1.0, low.size / FOLLOWING)
        spread = max(float(np.var(0.5 * (low + high))), 1e-9) / (tells**2 * independent)
        repeated = max(1.0 - tells, 0.0) / (
            12.0 * tells
        )  # variance that the timing leaves to one onset; all repeat the same errors
        mean = (min(max(told / tells, 0.0), 1.0) / spread + 0.5 * PRIOR) / (1.0 / spread + PRIOR)
        return mean, float(1.0 / np.sqrt(1.0 / (spread + repeated) + PRIOR))

    def friction(
        self, axis: Mapping[str, float], shape: Vector | None, beside: float = 0.0
    ) -> Vector:
        """|effort| less the offset, (n,); with the place of rest so many standard deviations
        `beside` its mean."""
        offset = axis["offset"] if self.offset is None else self.offset
        mean, deviation = self.rest(axis, shape)
        start = mean + beside * deviation
        return (
            efforts(self.onsets, axis, self.resolution, start, shape, self.velocity)[0]
            - offset * self.places.direction
        )

    def shape(self, structure: PolynomialOrders, value: Vector) -> Vector:
        """The factors (n,) of the friction at the onsets over their mean: friction in slip follows
        the breakaway (4.42)."""
        curve = self.places.design(structure) @ value
        if structure.common:
            curve = curve - value[-1] * self.places.direction
        return np.asarray(curve / np.mean(curve))


def breakaway(
    records: list[MotionRecord],
    bench: Bench,
    axis: Mapping[str, Interval],
    confidence: float,
    stribeck: Interval | None = None,
) -> Breakaway:
    """The breakaway of ramp logs; `axis` gives `inertia`, `viscous`, `coulomb`, `offset` as far as
    they are known.

    stribeck: the Stribeck velocity in rad/s | m/s where another log gives it; else the onsets bound
    it.

    Raises NothingUsable where fewer than five onsets are found in every direction, or where a load
    starts the axis. With one direction only, the offset is taken off.
    """
    evidence = _evidence(records, bench)
    nominal = {name: known.value for name, known in axis.items()}
    try:
        structure, shape, solution, friction = _settled(evidence, nominal)
        fall = (
            evidence.fall(axis, shape, confidence)
            if stribeck is None
            else StribeckVelocityRange(stribeck.value, stribeck.low, stribeck.high, known=True)
        )
        if fall.velocity > 0.0:
            evidence = replace(evidence, velocity=fall.velocity)
            structure, shape, solution, friction = _settled(evidence, nominal)
        moved, fallen = _moved(evidence, structure, shape, axis, fall)
    except SingularRegressors as error:
        raise UnusableLogs(f"the breakaways do not tell friction over position: {error}") from None
    half_step = (
        0.5 * max(onset.rate for onset in evidence.onsets) * records[0].period
        if any(record.lag == 0.0 for record in records)
        else 0.0
    )

    def interval(weights: Vector) -> Interval:
        value, statistical = (
            float(weights @ solution.value),
            float(np.linalg.norm(weights * solution.half_width(confidence))),
        )
        deviation = statistical / float(ndtri(0.5 + 0.5 * confidence))
        ends = [(float(weights @ low), float(weights @ high)) for low, high in moved]
        other = [float(weights @ shift) for shift in fallen]
        down, up = (
            half_step
            + max(0.0, *(sign * shift for shift in other))
            + half_width(
                confidence,
                deviation,
                [half_step, *(max(0.0, sign * low, sign * high) for low, high in ends)],
            )
            for sign in (-1.0, 1.0)
        )
        return Interval(value, value - down, value + up)

    rested = np.array([onset.rested for onset in evidence.onsets])
    rising = (
        rising_friction(rested, evidence.places.direction, friction, confidence)
        if structure.constant
        else None
    )
    levels = _levels(structure)
    mean = interval(np.mean(levels, axis=0))
    if rising is not None:
        mean = _wider(rising.full, mean)
    law = (
        None
        if structure.constant or len(levels) < 2
        else _by_position(evidence.places, structure, solution, interval)
    )
    if law is not None:
        _refuse_loaded(law, bench)
    seen = efforts(
        evidence.onsets,
        nominal,
        evidence.resolution,
        evidence.rest(nominal, shape)[0],
        shape,
        fall.velocity,
    )[0]
    means = [
        float(np.mean(seen[side])) if side.any() else np.nan
        for side in (evidence.places.direction > 0.0, evidence.places.direction < 0.0)
    ]
    late = float(np.mean([onset.level for onset in evidence.onsets]) - np.mean(seen))
    places = evidence.places
    return Breakaway(
        mean,
        means[0],
        means[1],
        len(evidence.onsets),
        late,
        places.position,
        places.direction,
        friction,
        fall,
        law,
        rising,
    )


def _refuse_loaded(law: BreakawayOverPosition, bench: Bench) -> None:
    """Raise NothingUsable where the breakaway over position is not positive: a load starts the axis
    there, and not the effort."""
    place = np.linspace(law.low, law.high, PLACES)
    for side, powers in zip(("forward", "backward"), law.powers, strict=True):
        level = np.polynomial.polynomial.polyval(place, np.array(powers))
        least = int(np.argmin(level))
        if level[least] <= 0.0:
            length, unit = si_unit("position", bench.axis), si_unit("effort", bench.axis)
            raise UnusableLogs(
                f"the breakaway {side} is {level[least]:.3g} {unit} at {place[least]:.3g} {length}, where friction is above 0: a load "
                "such as gravity or a spring starts the axis there; remove it, or name it in load.terms of the bench and add a log of "
                "sliding motion"
            )


def _wider(found: Interval, mean: Interval) -> Interval:
    """Return `found` with the distances of `mean` from its ends, which hold what is not known of
    the axis, added as squares."""
    down, up = (
        np.hypot(found.half_width, mean.value - mean.low),
        np.hypot(found.half_width, mean.high - mean.value),
    )
    return Interval(found.value, found.value - float(down), found.value + float(up))


def _evidence(records: list[MotionRecord], bench: Bench) -> OnsetData:
    """The onsets of the directions that have enough of them."""
    found = [onset for record in records for onset in find_onsets(record, bench)]
    used = [
        onset
        for onset in found
        if sum(o.direction == onset.direction for o in found) >= FEWEST_ONSETS
    ]
    if not used:
        raise UnusableLogs(
            f"{len(found)} breakaways under an effort that rises from a low level along a line; at least {FEWEST_ONSETS} in one direction "
            "are needed"
        )
    position, direction = (
        np.array([o.position for o in used]),
        np.array([o.direction for o in used]),
    )
    places = BreakawayPositions(position, direction, float(position.min()), float(position.max()))
    known = bench.mechanics.offset
    one_way = abs(float(np.sum(direction))) == direction.size
    return OnsetData(
        used,
        places,
        records[0].resolution,
        None if one_way else 0.0 if known is None else known.value,
    )


def _settled(
    evidence: OnsetData, nominal: Mapping[str, float]
) -> tuple[PolynomialOrders, Vector | None, LeastSquaresSolution, Vector]:
    """The structure, the shape that friction in slip has with it, the fit, and the friction (n,),
    in agreement with each other."""
    shape: Vector | None = None
    for _ in range(ROUNDS):
        friction = evidence.friction(nominal, shape)
        structure = choose_structure(evidence.places, friction)
        solution = fit_polynomials(evidence.places, friction, structure)
        if structure.constant:
            break
        shape = evidence.shape(structure, solution.value)
    return structure, shape, solution, friction


def _levels(structure: PolynomialOrders) -> list[Vector]:
    """What the mean in each direction is of the coefficients: (p,) each, forward first; one where
    there is one direction."""
    if structure.common:
        unit = np.eye(structure.orders[0] + 2)
        return [unit[0], unit[0]]
    sizes = [order + 1 for order in structure.orders]
    unit = np.eye(sum(sizes))
    return [unit[first] for first, size in zip((0, sizes[0]), sizes, strict=True) if size]


def _moved(
    evidence: OnsetData,
    structure: PolynomialOrders,
    shape: Vector | None,
    axis: Mapping[str, Interval],
    fall: StribeckVelocityRange,
) -> tuple[list[tuple[Vector, Vector]], list[Vector]]:
    """Return the shifts of the coefficients (p,) at each end of the axis's parameters and rest
    position, and at each end of the fall."""
    nominal, design = (
        {name: known.value for name, known in axis.items()},
        evidence.places.design(structure),
    )
    friction = evidence.friction(nominal, shape)

    def moved(end: Vector) -> Vector:
        return np.asarray(np.linalg.lstsq(design, end - friction, rcond=None)[0], dtype=np.float64)

    def between(name: str, ends: Interval) -> tuple[Vector, Vector]:
        low, high = (
            moved(evidence.friction({**nominal, name: value}, shape))
            for value in (ends.low, ends.high)
        )
        return low, high

    ranges = [between(name, known) for name, known in axis.items()]
    low, high = (moved(evidence.friction(nominal, shape, beside)) for beside in (-UNIFORM, UNIFORM))
    return [*ranges, (low, high)], [
        moved(replace(evidence, velocity=end).friction(nominal, shape))
        for end in (fall.low, fall.high)
    ]


def _by_position(
    places: BreakawayPositions,
    structure: PolynomialOrders,
    solution: LeastSquaresSolution,
    interval: Callable[[Vector], Interval],
) -> BreakawayOverPosition:
    """`interval`: of any weighted sum (p,) of the coefficients."""
    forward, backward = (places.powers(side) for side in sides_of(structure, solution.value))
    first, second = (
        tuple(map(interval, places.power_weights(rows)))
        for rows in sides_of(structure, np.eye(solution.value.size))
    )
    levels = list(map(interval, _levels(structure)))
    return BreakawayOverPosition(
        places.low,
        places.high,
        levels[0],
        levels[1],
        (forward, backward),
        (first, second),
        structure.common,
    )
