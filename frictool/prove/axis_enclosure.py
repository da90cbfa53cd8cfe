"""Enclosure of the motion of one axis over a sample: stick, breakaway, slip, contact, stop.

All quantities are intervals; the direction of the motion is always known. In a slip in direction s,
with the speed w = s v >= 0, the drive i, and a constant command u, the system

    drive i' = (u - i)/lag,        w' = s (K i - offset)/J - viscous w/J - friction/J

is linear (K: drive constant, J: inertia). The Taylor series of its solution is summed with interval
coefficients, and `_tail` bounds the remainder. Neither friction nor load depends on the position,
so that the displacement since the start does not depend on the initial position. One enclosure is
therefore valid for every position within an encoder count.

The integration takes steps that provably contain no event, until at most EVENT seconds remain
before the next event. The bounds over these EVENT seconds contain every possible motion. If it is
uncertain whether a stop happens before or after the end of the sample, the result consists of two
sets of states: the states after the stop, and the states of an axis that still moves. If the
enclosure cannot decide which event follows, `Ambiguous` is raised, and nothing is proved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from frictool.plant.axis import AxisParameters
from frictool.prove.interval import WHOLE, ZERO, RoundedInterval, decay, point

EVENT = 1e-9  # s, time around an event that is enclosed as a whole
TERMS = 14  # terms of the Taylor series
STEEPEST = 0.5  # largest product of a step and a rate; a longer step is divided
SLACK = 1e-12  # relative margin of bounds that are computed without outward rounding
MOST_STEPS = 400  # largest number of steps within one sample


class Ambiguous(Exception):
    """Error: the enclosure cannot decide which event follows."""


@dataclass(frozen=True)
class PlantBox:
    """Parameters of an axis as intervals in SI units; plant/axis.py explains the names.

    gap_coulomb, gap_breakaway: Coulomb friction and breakaway of the motor inside the backlash.
    `lag` [s], `drive_limit`, `backlash` and the sample period `period` [s] are exact numbers.
    """

    inertia: RoundedInterval
    viscous: RoundedInterval
    coulomb: RoundedInterval
    breakaway: RoundedInterval
    offset: RoundedInterval
    constant: RoundedInterval
    gap_coulomb: RoundedInterval
    gap_breakaway: RoundedInterval
    lag: float
    drive_limit: float
    backlash: float
    period: float


def plant_box(axis: AxisParameters, period: float) -> PlantBox:
    """Return the parameters of one plant as intervals of zero width."""
    return PlantBox(
        point(axis.inertia),
        point(axis.viscous),
        point(axis.coulomb),
        point(axis.breakaway),
        point(axis.offset),
        point(axis.constant),
        point(axis.backlash_coulomb),
        point(axis.backlash_breakaway),
        axis.lag,
        axis.drive_limit,
        axis.backlash,
        period,
    )


@dataclass(frozen=True, slots=True)
class AxisSet:
    """Set of states of an axis: an interval for each quantity.

    - moved: displacement since the start [rad | m]
    - speed: velocity, with its sign [rad/s | m/s]
    - drive: drive of the motor [A | V]
    - gap: position of the motor inside the backlash [rad | m]
    - direction: sign of the velocity, 0 at rest
    - edge: +1 or -1 at an end of the backlash, where the motor pushes the load; 0 inside
    """

    moved: RoundedInterval
    speed: RoundedInterval
    drive: RoundedInterval
    gap: RoundedInterval
    direction: int = 0
    edge: int = 0


AT_REST = AxisSet(ZERO, ZERO, ZERO, ZERO)


def advanced(state: AxisSet, command: float, p: PlantBox, duration: float) -> tuple[AxisSet, ...]:
    """Return the sets of states after `duration` [s] under a constant command [A | V].

    The state of each plant in the box `p` is in at least one of the sets. There are several sets
    only if a stop may happen before or after the end of `duration`. Raises Ambiguous if the next
    event is not certain.
    """
    command = min(max(command, -p.drive_limit), p.drive_limit)
    if p.lag == 0.0:
        state = replace(state, drive=point(command))
    waiting, ends = [(state, duration)], []
    for _ in range(MOST_STEPS):
        state, left = waiting.pop()
        follow = _rested if state.direction == 0 else _slipped
        for later, spent in follow(state, command, p, left):
            if spent >= left:
                ends.append(later)
            else:
                waiting.append((later, left - spent))
        if not waiting:
            return tuple(ends)
    raise Ambiguous("too many events within one sample")


def thresholds(state: AxisSet, p: PlantBox) -> tuple[RoundedInterval, RoundedInterval]:
    """Return the breakaway [N m | N] in the positive and in the negative direction.

    Without backlash, both values are the breakaway of the axis. With backlash, a direction in which
    the motor pushes the load has this breakaway; any other direction has the breakaway of the motor
    alone.
    """
    return (
        p.breakaway if _carries(state, p, 1) else p.gap_breakaway,
        p.breakaway if _carries(state, p, -1) else p.gap_breakaway,
    )


def _carries(state: AxisSet, p: PlantBox, direction: int) -> bool:
    return p.backlash == 0.0 or state.edge == direction


def _effort(drive: RoundedInterval, p: PlantBox) -> RoundedInterval:
    return p.constant * drive - p.offset


def _held_drive(
    drive: RoundedInterval, command: float, p: PlantBox, time: float
) -> RoundedInterval:
    if p.lag == 0.0:
        return point(command)
    target = point(command)
    return target + (drive - target) * _decay(time, p.lag)


@lru_cache(maxsize=64)
def _decay(time: float, lag: float) -> RoundedInterval:
    return decay(point(time) / point(lag))


_Ends = list[tuple[AxisSet, float]]  # sets of states and elapsed times [s]


def _rested(state: AxisSet, command: float, p: PlantBox, left: float) -> _Ends:
    """Return the sets of states at the end of a rest, with the duration of the rest [s].

    The rest ends with a breakaway, or after the time `left` [s].
    """
    forward, backward = thresholds(state, p)
    drive = _held_drive(state.drive, command, p, left)
    efforts = _effort(state.drive, p), _effort(drive, p)
    if all(-backward.low < one.low and one.high < forward.low for one in efforts):
        return [(replace(state, drive=drive), left)]
    now = efforts[0]
    if now.low > forward.high:
        return [(replace(state, direction=1), 0.0)]
    if now.high < -backward.high:
        return [(replace(state, direction=-1), 0.0)]
    for sign, threshold in ((1, forward), (-1, backward)):
        later = efforts[1] if sign > 0 else -efforts[1]
        if later.low > threshold.high and p.lag > 0.0:
            return [_broken_away(state, command, p, left, sign)]
    raise Ambiguous("the effort may equal the breakaway")


def _broken_away(
    state: AxisSet, command: float, p: PlantBox, left: float, sign: int
) -> tuple[AxisSet, float]:
    """Return the set of states just after a breakaway, and the latest time [s] of the breakaway.

    The drive approaches the command monotonically. After the breakaway, the effort therefore stays
    above the threshold, and bisection finds the latest and the earliest time of the breakaway.
    """
    forward, backward = thresholds(state, p)
    threshold = forward if sign > 0 else backward

    def effort_at(time: float) -> RoundedInterval:
        effort = _effort(_held_drive(state.drive, command, p, time), p)
        return effort if sign > 0 else -effort

    sure_rest, sure_slip = 0.0, left
    for _ in range(60):
        if sure_slip - sure_rest <= EVENT:
            break
        middle = 0.5 * (sure_rest + sure_slip)
        effort = effort_at(middle)
        if effort.high < threshold.low:
            sure_rest = middle
        elif effort.low > threshold.high:
            sure_slip = middle
        else:  # the parameters are intervals: narrow the latest instant only
            if effort_at(0.5 * (middle + sure_slip)).low > threshold.high:
                sure_slip = 0.5 * (middle + sure_slip)
            else:
                break
    spread = math.nextafter(sure_slip - sure_rest, math.inf)
    friction = p.coulomb if _carries(state, p, sign) else p.gap_coulomb
    pushed = effort_at(sure_slip)
    most = max(0.0, ((pushed - friction) / p.inertia).high)
    speed = RoundedInterval(0.0, math.nextafter(most * spread, math.inf))
    moved = RoundedInterval(0.0, math.nextafter(speed.high * spread, math.inf))
    drive = _held_drive(state.drive, command, p, sure_slip)
    started = replace(state, drive=drive, direction=sign)
    if not _carries(state, p, sign) and moved.high >= _distance_to_contact(started, p):
        raise Ambiguous("the axis may break away where the backlash closes")
    return _shifted(started, moved, speed, p), sure_slip


def _shifted(
    state: AxisSet, distance: RoundedInterval, speed: RoundedInterval, p: PlantBox
) -> AxisSet:
    """Return the set of states after a motion by `distance` >= 0 in the set's direction.

    The motion ends with `speed` >= 0.
    """
    signed = distance if state.direction >= 0 else -distance
    velocity = speed if state.direction >= 0 else -speed
    if _carries(state, p, state.direction):
        return replace(state, moved=state.moved + signed, speed=velocity)
    half = 0.5 * p.backlash
    return replace(
        state,
        moved=state.moved + signed,
        speed=velocity,
        gap=(state.gap + signed).clipped(-half, half),
        edge=0,
    )


def _slipped(state: AxisSet, command: float, p: PlantBox, left: float) -> _Ends:
    """Return the sets of states after one step of a slip, each with the elapsed time [s].

    The step ends at the latest where the backlash closes, at a stop, or after the time `left` [s].
    """
    carries = _carries(state, p, state.direction)
    phase = _phase(state, command, p, carries)
    contact_distance = math.inf if carries else _distance_to_contact(state, p)
    rate = max(phase.alpha.high, phase.rate)
    step = min(left, STEEPEST / rate if rate > 0.0 else left)
    while True:
        bounds = _bounds(phase, step)
        if bounds.moves and bounds.farthest < contact_distance:
            speed, distance = _mapped(phase, step) if step == p.period else _series(phase, step)
            speed = RoundedInterval(max(speed.low, 0.0), speed.high)
            drive = _held_drive(state.drive, command, p, step)
            return [(replace(_shifted(state, _positive(distance), speed, p), drive=drive), step)]
        if step <= EVENT:
            break
        guess = 0.5 * step
        if not bounds.moves and bounds.slowest < 0.0:
            guess = min(guess, 0.9 * phase.speed.low / -bounds.slowest)
        elif bounds.moves:
            guess = min(
                guess, _fitting_step(phase.speed.high, bounds.fastest, 0.9 * contact_distance)
            )
        step = max(guess, EVENT)
    if bounds.moves:
        return [_met(state, command, p, left)]
    if bounds.fastest < 0.0:
        return _stopped(state, command, p, left, bounds.fastest)
    raise Ambiguous("the sign of the acceleration at a possible stop is not certain")


def _fitting_step(speed: float, fastest: float, length: float) -> float:
    """Return the duration t of a step [s] for which (speed + fastest t) t = `length`.

    `fastest`: largest acceleration; a negative acceleration counts as 0.
    """
    rise = max(0.0, fastest)
    return 2.0 * length / (speed + math.sqrt(speed * speed + 4.0 * rise * length) + 1e-300)


@dataclass(frozen=True, slots=True)
class _Phase:
    """Coefficients of a slip with the speed w >= 0: w' = settled + excess e^(-rate t) - alpha w.

    - speed: w at t = 0
    - losing: interval that contains the exact rate; `rate` is rounded
    """

    speed: RoundedInterval
    settled: RoundedInterval
    excess: RoundedInterval
    alpha: RoundedInterval
    losing: RoundedInterval
    rate: float


@dataclass(frozen=True, slots=True)
class _Bounds:
    """Bounds of the motion during a step of the integration.

    - moves: True if the speed stays above 0, or starts at 0 and does not fall
    - farthest: upper bound of the distance [rad | m]
    - slowest, fastest: lower and upper bound of the acceleration [rad/s^2 | m/s^2]
    """

    moves: bool
    farthest: float
    slowest: float
    fastest: float


def _phase(state: AxisSet, command: float, p: PlantBox, carries: bool) -> _Phase:
    sign = state.direction
    held = point(command if sign > 0 else -command)
    drive = state.drive if sign > 0 else -state.drive
    opposing = (p.offset if sign > 0 else -p.offset) + (p.coulomb if carries else p.gap_coulomb)
    kappa = p.constant / p.inertia
    return _Phase(
        state.speed if sign > 0 else -state.speed,
        kappa * held - opposing / p.inertia,
        kappa * (drive - held) if p.lag > 0.0 else ZERO,
        p.viscous / p.inertia if carries else ZERO,
        point(1.0) / point(p.lag) if p.lag > 0.0 else ZERO,
        1.0 / p.lag if p.lag > 0.0 else 0.0,
    )


def _bounds(phase: _Phase, step: float) -> _Bounds:
    """Return bounds of speed, distance and acceleration during a step with a speed >= 0.

    During the step, the exponential e^(-rate t) of `_Phase` is between 1 - rate*step and 1. SLACK
    exceeds the rounding errors.
    """
    kept = RoundedInterval((1.0 - phase.rate * step) * (1.0 - SLACK), 1.0)
    push = phase.settled + phase.excess * kept
    top = (max(phase.speed.high, 0.0) + max(0.0, push.high) * step) * (1.0 + SLACK)
    slowest = push.low - phase.alpha.high * top
    slowest -= SLACK * (abs(push.low) + phase.alpha.high * top)
    least = phase.speed.low + min(0.0, slowest * step) * (1.0 + SLACK)
    fastest = push.high + SLACK * abs(push.high)
    moves = least > SLACK * phase.speed.high or (slowest >= 0.0 and phase.speed.low >= 0.0)
    return _Bounds(moves, top * step * (1.0 + SLACK), slowest, fastest)


def _least(speed: RoundedInterval) -> float:
    return 0.0 if speed.low <= 0.0 <= speed.high else min(abs(speed.low), abs(speed.high))


def _positive(one: RoundedInterval) -> RoundedInterval:
    return RoundedInterval(max(0.0, one.low), max(0.0, one.high))


def _distance_to_contact(state: AxisSet, p: PlantBox) -> float:
    """Return the least distance to the end of the backlash in the direction of motion [rad | m]."""
    half = 0.5 * p.backlash
    ahead = half - state.gap.high if state.direction > 0 else half + state.gap.low
    return max(0.0, math.nextafter(ahead, -math.inf))


def _mapped(phase: _Phase, step: float) -> tuple[RoundedInterval, RoundedInterval]:
    """Return the result of `_series` as a weighted sum of three cached series.

    The motion is linear in `speed`, `settled` and `excess`. In each cached series, one of the three
    quantities is 1 and the other two are 0.
    """
    w0, w1, w2, y0, y1, y2 = _unit_sums(phase.alpha, phase.losing, phase.rate, step)
    return (
        phase.speed * w0 + phase.settled * w1 + phase.excess * w2,
        phase.speed * y0 + phase.settled * y1 + phase.excess * y2,
    )


@lru_cache(maxsize=64)
def _unit_sums(
    alpha: RoundedInterval, losing: RoundedInterval, rate: float, step: float
) -> tuple[
    RoundedInterval,
    RoundedInterval,
    RoundedInterval,
    RoundedInterval,
    RoundedInterval,
    RoundedInterval,
]:
    one = point(1.0)
    (w0, y0), (w1, y1), (w2, y2) = (
        _series(_Phase(speed, settled, excess, alpha, losing, rate), step)
        for speed, settled, excess in ((one, ZERO, ZERO), (ZERO, one, ZERO), (ZERO, ZERO, one))
    )
    return w0, w1, w2, y0, y1, y2


def _series(phase: _Phase, step: float) -> tuple[RoundedInterval, RoundedInterval]:
    d = point(step)
    b, c = phase.excess, phase.speed
    total, path = c, c * d
    for k in range(1, TERMS + 1):
        inner = b - phase.alpha * c
        if k == 1:
            inner = inner + phase.settled
        c = inner * d / WHOLE[k]
        b = -(b * phase.losing) * d / WHOLE[k]
        total = total + c
        path = path + c * d / WHOLE[k + 1]
    size = (
        phase.settled.magnitude
        + 2.0 * TERMS * phase.excess.magnitude
        + phase.alpha.high * phase.speed.magnitude
    )
    tail = _tail(size, max(phase.alpha.high, phase.rate), step)
    return total + RoundedInterval(-tail, tail), path + RoundedInterval(-tail * step, tail * step)


def _tail(size: float, beta: float, step: float) -> float:
    """Return a bound of the sum of all terms of `_series` after the first TERMS.

    Term k is at most size step (beta step)^(k-1)/k! with a bound `size` of the acceleration and the
    largest rate `beta` [1/s]; beta step <= STEEPEST. The sum is below twice its first term.
    """
    x = beta * step * (1.0 + SLACK)
    first = size * step * x**TERMS / math.factorial(TERMS + 1)
    return 2.0 * first * (1.0 + SLACK) + 1e-300


def _stopped(state: AxisSet, command: float, p: PlantBox, left: float, fastest: float) -> _Ends:
    """Return the sets of states after a stop, each with the elapsed time [s].

    The stop happens within the time (highest speed)/|`fastest`|; |`fastest`| is the smallest
    deceleration. If this time exceeds `left` [s], the axis may still move after `left`; a second
    set contains these states.
    """
    sign = state.direction
    high = state.speed.magnitude
    wait = max(EVENT, 1.01 * high / -fastest)
    carries = _carries(state, p, sign)
    late = wait > left
    sure = _bounds(_phase(state, command, p, carries), min(wait, left)).fastest
    if sure >= 0.0 or not (late or high + sure * wait * (1.0 - SLACK) < 0.0):
        raise Ambiguous("the sign of the acceleration at a possible stop is not certain")
    wait = min(wait, left)
    drive = _held_drive(state.drive, command, p, wait)
    efforts = _effort(state.drive, p), _effort(drive, p)
    moved = RoundedInterval(0.0, high * wait * (1.0 + SLACK))
    if not carries and moved.high >= _distance_to_contact(state, p):
        raise Ambiguous("the axis may stop where the backlash closes")
    at = _shifted(state, moved, ZERO, p)
    slower = RoundedInterval(0.0, high)
    moving = [(replace(_shifted(state, moved, slower, p), drive=drive), wait)] if late else []
    forward, backward = thresholds(at, p)
    if all(-backward.low < one.low and one.high < forward.low for one in efforts):
        return [(replace(at, drive=drive, direction=0), wait), *moving]
    against = backward if sign > 0 else forward
    pushing = [-one if sign > 0 else one for one in efforts]
    if all(one.low > against.high for one in pushing):
        friction = p.coulomb if _carries(at, p, -sign) else p.gap_coulomb
        most = max(((one - friction) / p.inertia).high for one in pushing)
        speed = RoundedInterval(0.0, most * wait * (1.0 + SLACK))
        back = RoundedInterval(0.0, speed.high * wait * (1.0 + SLACK))
        turned = replace(at, drive=drive, direction=-sign)
        return [(_shifted(turned, back, speed, p), wait), *moving]
    raise Ambiguous("after a stop, the effort may equal the breakaway: the axis may stick or move")


def _met(state: AxisSet, command: float, p: PlantBox, left: float) -> tuple[AxisSet, float]:
    """Return the set of states after the backlash closes, and the latest time of this contact [s].

    The motion lies between two motions: one without contact, one with the friction of the axis from
    the beginning. If the time `left` [s] ends before the contact is certain, `gap` of the set
    includes the end of the backlash and `edge` is 0; the next sample then begins between the same
    two motions.
    """
    sign = state.direction
    half = 0.5 * p.backlash
    far = (half - state.gap.low if sign > 0 else half + state.gap.high) * (1.0 + SLACK) + SLACK
    slow = _least(state.speed)
    if slow == 0.0:
        raise Ambiguous("the speed may be zero where the backlash closes")
    wait = max(EVENT, 2.0 * far / slow)
    early = wait > left
    wait = min(wait, left)
    free, carried = (_phase(state, command, p, carries) for carries in (False, True))
    if not (_bounds(free, wait).moves and _bounds(carried, wait).moves):
        raise Ambiguous("the axis may stop where the backlash closes")
    ends = _series(free, wait), _series(carried, wait)
    speed, distance = ends[0][0].hull(ends[1][0]), ends[0][1].hull(ends[1][1])
    drive = _held_drive(state.drive, command, p, wait)
    if distance.low <= far:
        if early:
            return replace(_shifted(state, _positive(distance), speed, p), drive=drive), wait
        raise Ambiguous("the bounds do not enclose the end of the backlash")
    signed = distance if sign > 0 else -distance
    velocity = speed if sign > 0 else -speed
    return AxisSet(state.moved + signed, velocity, drive, point(sign * half), sign, sign), wait
