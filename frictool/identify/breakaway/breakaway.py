"""Breakaway from ramps (4.3, figure 4.6), corrected for the delay of the encoder.

The thesis takes the largest effort before each visible motion. By then the axis has been moving for
some time while the ramp continued: the maximum is too high by several steps of the ramp. Here the
ramp is a line fitted to the effort at rest, evaluated at the onset that the later motion reveals
(`onset`). This needs the inertia and the friction in slip; their uncertainty widens the interval.

Breakaway is a function of position and direction (`position_law`); a constant is the simplest one.
Friction in slip determines how fast the visible motion is, and is assumed to be proportional to the
breakaway (4.42).

- breakaway: mean over the range of positions and over both directions, so that an offset of the
  effort cancels
- fall: Stribeck velocity from another log, or the range that the encoder's changes allow
  (`stribeck_velocity`). The value assumes an immediate fall if that is allowed. The interval
  includes the breakaways of all allowed velocities.
- interval: spread between onsets (each left out in turn), and the ranges of the axis's parameters
  (`combined_interval`). For a held ramp, two errors of half a step are added that do not average
  out: the breakaway lies anywhere within a step of the ramp, and the encoder's changes are late by
  up to half a sample.

The rest position within a count also follows from the changes, within the limits of their timing. A
test that takes the ramp back after a fixed number of counts brings the axis to rest at nearly the
same position each time. Ambiguities of a single onset are therefore resolved by the mean of all
onsets (`OnsetData.rest`).

Onsets inside the backlash after a reversal are left out, since only the motor moves there.
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
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.regression.regression import LeastSquaresSolution, SingularRegressors
from frictool.identify.rows.strokes import find_strokes
from frictool.logs.quality.ramps import STRAIGHT, are_ramps, ramps_among, rests_of
from frictool.plant.weak_form import effort_weights
from frictool.typing import Vector

MOVED_COUNTS = 0.5  # counts, least distance of a motion; one count to and fro is none
# encoder changes used after an onset; later ones reveal more of the inertia than of the onset
CHANGES_USED = 4
FEWEST_ONSETS = 5
RELATIVE_NOISE = 1e-3  # least noise of the effort, relative to its level
PRIOR = 12.0  # precision of a rest position that is uniform within its count, 1/count^2
UNIFORM = float(np.sqrt(3.0))  # ratio of half a range to its standard deviation
# largest number of onsets, evenly spaced, in the comparison of Stribeck velocities; all count as
# one there
ONSETS_COMPARED = 100
ROUNDS = 3  # iterations between the friction's shape over position and the onsets
PLACES = 200  # grid points over the range at which the breakaway law must be positive
# standard deviations of the effort below the line, after which the ramp counts as taken back
LEFT_THE_RAMP = 5.0


@dataclass(frozen=True)
class BreakawayOnset:
    """One breakaway; its time 0 is when motion is seen.

    - direction: +1 or -1
    - level, rate: line of |effort|, N m | N at time 0, and its slope per s
    - time: (n,), s, of the encoder's changes
    - seen: (n,), distance at each change from the first one, rad | m
    - position: of the rest, middle of its count, rad | m
    - rested: s without a count before it
    - timing: weight of a preferred rest position, see `onset`
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
    """Breakaway as a polynomial of the position over [low, high], rad | m.

    - forward, backward: mean breakaway of each direction, N m | N
    - powers: coefficients of each direction, lowest power first, N m | N
    - unsure: interval of each coefficient
    - common: both directions have the same polynomial
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
    """Mean breakaway of ramp logs.

    - interval: mean breakaway, N m | N; with `rising`, that after a long rest
    - forward, backward: mean |effort| of each direction, N m | N, NaN without onsets
    - onsets: number of onsets
    - delay: mean correction for the encoder's delay, N m | N
    - position: (n,), of each onset, rad | m
    - direction: (n,), +-1
    - friction: (n,), |effort| without the offset
    - fall: Stribeck velocities included in the interval
    - by_position: None if the breakaway is constant
    - rising: None if it does not grow with the time at rest
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

    @property
    def parameter(self) -> Interval:
        """Return the parameter of a model: if it varies with position, the forward mean, N m | N."""
        return self.interval if self.by_position is None else self.by_position.forward


def is_ramp(record: MotionRecord, bench: Bench) -> bool:
    """Return whether a log is one of breakaway ramps, with enough of them for `breakaway`."""
    return (
        are_ramps(_rests(record), record.position, record.effort)
        and len(find_onsets(record, bench)) >= FEWEST_ONSETS
    )


def _rests(record: MotionRecord) -> list[tuple[int, int]]:
    """Return the first sample of each rest, and the first after it with a changed position."""
    return rests_of(
        (np.abs(np.diff(record.position)) > 0.5 * record.resolution) | (np.diff(record.piece) > 0)
    )


def find_onsets(record: MotionRecord, bench: Bench) -> list[BreakawayOnset]:
    """Return every breakaway under a growing effort with the load attached."""
    width = bench.mechanics.backlash
    gap = 0.0 if width is None else max(width.interval) + 2.0 * record.resolution
    strokes, rests = find_strokes(record), _rests(record)
    # a rest begins at the position at which the motion has ended
    following = [start + 1 for start, _ in rests[1:]] + [record.position.size]
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
    """Return the breakaway that ends the rest [start, end), with its motion up to `until`.

    The result is None if the effort is no ramp or the motion is too small.
    """
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
    """Return the mean square of the counts that the axis moves in one sample."""
    if time.size < 2:
        return 1.0  # any positive number: there is nothing to weigh it against
    return float(
        np.mean((np.diff(distance) / np.diff(time) * record.period / record.resolution) ** 2)
    )


def _above(record: MotionRecord) -> float:
    """Return the mean excess of the effort between two rows over their line, in ramp steps.

    A held effort acts half a sample later than its row. An effort that lags behind a held command
    curves towards the command.
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
    """Return |effort| (n,), rest position within its count (n,), and misfit (n,) of each onset.

    The rest position is between 0 and 1; the misfit of the encoder's changes is relative to
    `timing`.

    - axis: `inertia`, `viscous`, `coulomb` and `offset` in SI units
    - start: expected rest position, 0 to 1
    - shape: (n,), factors of `coulomb` at the onsets
    - velocity: Stribeck velocity; 0: friction falls at once; inf: it does not fall
    """
    out, places, squares = np.empty(len(onsets)), np.empty(len(onsets)), np.empty(len(onsets))
    for k, onset in enumerate(onsets):
        # the offset takes its share of the effort before friction does
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
    """Onsets that are used, their positions, and known data of the axis."""

    onsets: list[BreakawayOnset]
    places: BreakawayPositions
    resolution: float
    # N m | N, the bench's; None in one direction, in which the offset is a parameter of the axis
    offset: float | None
    velocity: float = 0.0  # assumed Stribeck velocity, rad/s | m/s

    def misfit(self, axis: Mapping[str, float], shape: Vector | None, velocity: float) -> float:
        """Return the mean misfit of an onset (`efforts`) for a Stribeck velocity."""
        every = slice(None, None, math.ceil(len(self.onsets) / ONSETS_COMPARED))
        factors = None if shape is None else shape[every]
        return float(
            np.mean(efforts(self.onsets[every], axis, self.resolution, 0.5, factors, velocity)[2])
        )

    def fall(
        self, axis: Mapping[str, Interval], shape: Vector | None, confidence: float
    ) -> StribeckVelocityRange:
        """Return the Stribeck velocities allowed with parameters in the intervals of `axis`."""
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
        """Return the mean rest position within a count, 0 to 1, and its standard deviation.

        The position fitted to an onset depends linearly on the expected one: fitted = a + lean
        expected. For expected = fitted = a/(1 - lean) the timing of the changes alone determines
        the position. This value is combined with a position that is uniform within the count, each
        weighted by its inverse variance.
        """
        low, high = (
            efforts(self.onsets, axis, self.resolution, expected, shape, self.velocity)[1]
            for expected in (0.0, 1.0)
        )
        told, tells = float(np.mean(low)), max(1.0 - float(np.mean(high - low)), 1e-6)
        independent = max(1.0, low.size / FOLLOWING)
        spread = max(float(np.var(0.5 * (low + high))), 1e-9) / (tells**2 * independent)
        # variance left to one onset by the timing; all onsets repeat the same errors
        repeated = max(1.0 - tells, 0.0) / (12.0 * tells)
        mean = (min(max(told / tells, 0.0), 1.0) / spread + 0.5 * PRIOR) / (1.0 / spread + PRIOR)
        return mean, float(1.0 / np.sqrt(1.0 / (spread + repeated) + PRIOR))

    def friction(
        self, axis: Mapping[str, float], shape: Vector | None, beside: float = 0.0
    ) -> Vector:
        """Return the friction (n,) at the onsets: |effort| without the offset.

        The rest position is `beside` standard deviations from its mean.
        """
        offset = axis["offset"] if self.offset is None else self.offset
        mean, deviation = self.rest(axis, shape)
        start = mean + beside * deviation
        return (
            efforts(self.onsets, axis, self.resolution, start, shape, self.velocity)[0]
            - offset * self.places.direction
        )

    def shape(self, structure: PolynomialOrders, value: Vector) -> Vector:
        """Return the factors (n,) of friction at the onsets relative to their mean.

        Friction in slip is proportional to the breakaway (4.42).
        """
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
    """Return the breakaway of ramp logs.

    - axis: intervals of `inertia`, `viscous`, `coulomb` and `offset`
    - stribeck: Stribeck velocity of another log, rad/s | m/s; if None, the onsets bound it

    With one direction only, the offset is subtracted. Raises UnusableLogs if both directions have
    fewer than five onsets, or if a load starts the axis.
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
    """Raise UnusableLogs if the breakaway over position is not positive.

    A load starts the axis there, and not the effort.
    """
    place = np.linspace(law.low, law.high, PLACES)
    for side, powers in zip(("forward", "backward"), law.powers, strict=True):
        level = np.polynomial.polynomial.polyval(place, np.array(powers))
        least = int(np.argmin(level))
        if level[least] <= 0.0:
            length, unit = si_unit("position", bench.axis), si_unit("effort", bench.axis)
            raise UnusableLogs(
                f"the breakaway {side} is {level[least]:.3g} {unit} at {place[least]:.3g} "
                f"{length}, where friction is above 0: a load "
                "such as gravity or a spring starts the axis there; remove it, or name it in "
                "load.terms of the bench and add a log of "
                "sliding motion"
            )


def _wider(found: Interval, mean: Interval) -> Interval:
    """Return `found`, widened by the half widths of `mean`, added as squares.

    The interval of `mean` includes the uncertainty of the axis.
    """
    down, up = (
        np.hypot(found.half_width, mean.value - mean.low),
        np.hypot(found.half_width, mean.high - mean.value),
    )
    return Interval(found.value, found.value - float(down), found.value + float(up))


def _evidence(records: list[MotionRecord], bench: Bench) -> OnsetData:
    """Return the onsets of the directions that have enough of them."""
    found = [onset for record in records for onset in find_onsets(record, bench)]
    used = [
        onset
        for onset in found
        if sum(o.direction == onset.direction for o in found) >= FEWEST_ONSETS
    ]
    if not used:
        raise UnusableLogs(
            f"{len(found)} breakaways under an effort that rises from a low level along a line; "
            f"at least {FEWEST_ONSETS} in one direction "
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
    """Return structure, shape of friction, fit and friction (n,), iterated to agreement."""
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
    """Return the weights (p,) of the coefficients in the mean of each direction, forward first.

    There is one element if the onsets have one direction.
    """
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
    """Return the shifts of the coefficients (p,) for each end of an uncertain parameter.

    The first list holds pairs for the axis's parameters and the rest position, the second one
    shifts for the ends of the fall.
    """
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
    """Return the law over position; `interval` maps weights (p,) to the interval of their sum."""
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
