"""Breakaway ramps in both directions over the travel (thesis, figure 4.6).

The drive signal rises from zero until the axis moves; then the signal returns to zero and rises
again. Each ramp is a segment of the sequence: a pause at zero, then the rise to 1.1 times the
largest breakaway. The test controller goes on to

- the next segment, as soon as the encoder has moved by `advance_on` since the segment began;
- the first segment of the other direction, as soon as the position passes `low` or `high`.

Without these rules (`open_loop`), the drive signal reaches the top of every ramp. The test is first
simulated on three axes: the nominal axis, the lightest axis with the least friction, and the
heaviest axis with the most friction. The simulation has no load, since the shape of the load is
unknown; the tops of the ramps are raised by `load.most`.

After a breakaway under a ramp of R [N m/s | N/s], the encoder shows a count after at most t =
(6 inertia step/R)^(1/3), with the encoder step `step`. In this time the effort grows by R t. The
rate R = (0.05 F)^(3/2)/sqrt(6 inertia step) limits the growth to 5 % of the breakaway F. `identify`
corrects the breakaway for this growth.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity, si_unit
from frictool.engine.status_codes import OK
from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import BenchLimits, limits_of
from frictool.identify.excite.excitation_sequence import (
    ExcitationSequence,
    check_samples,
    command_sequence,
)
from frictool.identify.rows.load_terms import GRAVITY, SPRING
from frictool.plant.axis import DRIVE, POSITION, VELOCITY, AxisParameters, rest
from frictool.typing import Vector

LATENESS = 0.05  # growth of the effort until the encoder shows a count, relative to the breakaway
SLOWEST_RISE = 1.0  # s, shortest duration of a ramp up to the expected breakaway
PAUSE = 0.05  # s, shortest pause at zero before each ramp
# least Coulomb friction that brings an axis to rest in a pause, relative to the bench's value
LEAST_BRAKE = 0.05
# breakaway divided by Coulomb friction (least, expected, largest) if the bench states no breakaway
# (tables 4.8 and 4.1)
RATIOS = (1.0, 1.1, 1.5)
HEADROOM = 1.1  # top of a ramp relative to the largest breakaway
SEGMENTS = 40  # number of ramps over the travel
LEAST_COUNTS = 2.0
SPARE = 1.5  # number of segments written, relative to the number that the slowest axis needs
RAMPS_FAILED = "the simulation of the ramps failed; check the bench's mechanics"
NAMES = ("lightest", "nominal", "heaviest")


class Ramp(NamedTuple):
    """Ramp of the drive signal, and the rules for playing it.

    - rate, top: slope and largest value of the drive signal, A/s | V/s and A | V
    - low, high: positions at which the direction changes, rad | m
    - advance_on: distance after which the next segment begins, rad | m
    - open_loop: True to raise the drive signal to the top of every ramp, even if the axis moves
    - pause: duration of the pause before each ramp, s
    """

    rate: float
    top: float
    low: float
    high: float
    advance_on: float
    open_loop: bool
    pause: float


class SimulatedRamps(NamedTuple):
    """Simulation of one round of ramps, forward and backward, on one axis.

    - forward, backward: number of ramps played in each direction
    - low, high: range of positions, rad | m
    - speed: top speed, rad/s | m/s
    - all_moved: True if every ramp moved the axis
    """

    forward: int
    backward: int
    low: float
    high: float
    speed: float
    all_moved: bool


def breakaway_range(bench: Bench) -> tuple[float, float, float]:
    """Return the least, expected and largest breakaway, N m | N.

    If the bench states no breakaway, the three values are computed from Coulomb friction.
    """
    known, coulomb = bench.mechanics.breakaway, bench.mechanics.coulomb
    if known is not None:
        return known.interval[0], known.value, known.interval[1]
    return (
        RATIOS[0] * coulomb.interval[0],
        RATIOS[1] * coulomb.value,
        RATIOS[2] * coulomb.interval[1],
    )


def never_at_rest(bench: Bench) -> str | None:
    """Return why ramps are impossible if a load moves the axis between the ramps, else None.

    The drive is 0 between the ramps. An offset above the largest breakaway, such as the weight on a
    vertical axis, then accelerates every axis of the bench. The same is true of a spring or gravity
    above the largest breakaway (`load.most`). If `load.most` is missing, ramps are impossible with
    a spring or gravity, because an arm might fall.
    """
    offset, most = bench.mechanics.offset, breakaway_range(bench)[2]
    unit = si_unit("effort", bench.axis)
    known = []
    if offset is not None:
        known.append(("mechanics.offset", max(offset.interval[0], -offset.interval[1])))
    moving = moving_terms(bench)
    if moving and bench.load is not None and bench.load.most is not None:
        known.append(("load.most", bench.load.most.interval[0]))
    for key, least in known:
        if least > most:
            return (
                f"{key}: at least {least:.4g} {unit}, above the breakaway (at most {most:.4g}): "
                "between ramps, at a drive of 0, this load moves the axis; balance it, or use "
                "--kind sines"
            )
    if moving and (bench.load is None or bench.load.most is None):
        return (
            f"load.terms contains {', '.join(moving)}, but load.most is missing: between ramps, at "
            "a drive of 0, this load moves the axis (an arm falls); state load.most, or use "
            "--kind sines"
        )
    return None


def moving_terms(bench: Bench) -> list[str]:
    """Return the declared loads that can move a free axis far: spring and gravity, not a ripple."""
    return [term for term in (SPRING, GRAVITY) if bench.load and term in bench.load.terms]


def may_move_freely(bench: Bench) -> bool:
    """Return True if a declared spring or gravity may exceed the least breakaway."""
    if not moving_terms(bench):
        return False
    return never_at_rest(bench) is not None or returning_ramps(bench) is not None


def refuse_moving_load(bench: Bench) -> None:
    """Raise NoSolutionError if no ramps are possible (`never_at_rest`)."""
    impossible = never_at_rest(bench)
    if impossible is not None:
        raise NoSolutionError(impossible)


def returning_ramps(bench: Bench) -> str | None:
    """Return a warning if a load may move the axis between the ramps, else None.

    The load consists of offset and `load.most`. The drive is 0 between the ramps, so that the axis
    moves if the load exceeds the breakaway: back to a stop, or to the position at which the load
    balances. The simulated top speeds do not include the load.
    """
    limits, least = limits_of(bench), breakaway_range(bench)[0]
    load = limits.offset + limits.load
    if load <= least:
        return None
    unit = si_unit("effort", bench.axis)
    return (
        f"offset + load.most is up to {load:.3g} {unit} and may exceed the breakaway (at least "
        f"{least:.3g}): at a drive of 0, the axis may move faster than simulated; balance the "
        "load, or narrow its range"
    )


def effort_rate(bench: Bench) -> float:
    """Return the default slope of the ramps, N m/s | N/s."""
    expected = breakaway_range(bench)[1]
    shown = (LATENESS * expected) ** 1.5 / math.sqrt(
        6.0 * bench.mechanics.inertia.value * bench.encoder.resolution
    )
    return float(min(shown, expected / SLOWEST_RISE))


def breakaway_ramps(
    bench: Bench,
    limits: BenchLimits,
    top: float | None,
    rate: float | None,
    repetitions: int,
    open_loop: bool,
    segments: int = SEGMENTS,
) -> ExcitationSequence:
    """Return a sequence of breakaway ramps in both directions.

    - top: largest drive signal, A | V; None for the default
    - rate: slope of the drive signal, A/s | V/s; None for the default
    - repetitions: number of rounds, each with ramps forward and backward over the travel
    - open_loop: True to raise the drive signal to the top of every ramp, even if the axis moves
    - segments: number of ramps over the travel in each direction

    Raises NoSolutionError if a limit is exceeded, or if the sequence has more than MOST_SAMPLES
    samples; the message names the limit.
    """
    refuse_moving_load(bench)
    needed = _needed_drive(bench, limits)
    top = top or _default_top(bench, limits)
    unit = "A" if limits.drive == "current" else "V"
    if not needed <= top <= limits.drive_limit:
        raise NoSolutionError(
            f"{limits.drive}: the ramps rise to {top:.4g} {unit}; allowed: from {needed:.4g} "
            f"(largest breakaway) to {limits.drive_limit:.4g} (actuator.limit)"
        )
    slope = rate or effort_rate(bench) / bench.actuator.constant.value
    # lower bound of the number of ramps, checked before long simulations; in open loop, a single
    # ramp may suffice
    fewest = 2 * repetitions * (1 if open_loop else segments)
    remedy = "raise --rate of `excite --kind breakaway`" + " or lower load.most" * (limits.load > 0)
    check_samples(fewest * top / slope, bench.sample_period_s, remedy)
    advance_on = _advance(bench, limits, segments)
    ramp = Ramp(
        slope,
        top,
        limits.low,
        limits.high,
        advance_on,
        open_loop,
        PAUSE if open_loop else coasting_pause(bench, slope, top, advance_on),
    )
    played = [_checked(bench, limits, ramp, name) for name in range(3)]
    written = [
        math.ceil(SPARE * max(getattr(one, side) for one in played))
        for side in ("forward", "backward")
    ]
    lasting = repetitions * sum(written) * (ramp.pause + ramp.top / ramp.rate)
    check_samples(lasting, bench.sample_period_s, remedy)
    command, number = _table(ramp, bench.sample_period_s, written, repetitions)
    rule = (
        "play every row"
        if open_loop
        else f"next segment as soon as the position has moved by {ramp.advance_on:.6g} "
        f"{limits.unit} since the segment began; {_turning(ramp, limits.unit)}negative segments "
        "go backward"
    )
    rules = {"advance_on": ramp.advance_on, "turn_low": ramp.low, "turn_high": ramp.high}
    figures = {
        "rate": ramp.rate,
        "step": ramp.rate * bench.sample_period_s,
        "top": ramp.top,
        **{name: value for name, value in rules.items() if math.isfinite(value) and not open_loop},
        **{f"top_speed_{name}": one.speed for name, one in zip(NAMES, played, strict=True)},
    }
    return command_sequence(bench, command, number, rule, figures)


def ramp_duration(bench: Bench, rates: Vector) -> Vector:
    """Return the duration (n,) [s] of a ramp with its pause, for each rate.

    rates: slopes (n,) of the ramps, N m/s | N/s. There are SEGMENTS ramps over the travel. The
    pause is the same for all rates: the axis has to come to rest even after the fastest ramp.
    """
    limits = limits_of(bench)
    top, slopes = _default_top(bench, limits), rates / bench.actuator.constant.value
    pause = coasting_pause(bench, float(slopes.max()), top, _advance(bench, limits, SEGMENTS))
    return np.asarray(pause + top / slopes)


def _needed_drive(bench: Bench, limits: BenchLimits) -> float:
    most = breakaway_range(bench)[2]
    return (most + limits.offset + limits.load) / bench.actuator.constant.interval[0]


def _default_top(bench: Bench, limits: BenchLimits) -> float:
    return min(HEADROOM * _needed_drive(bench, limits), limits.drive_limit)


def _advance(bench: Bench, limits: BenchLimits, segments: int) -> float:
    travel = limits.travel if math.isfinite(limits.travel) else 2.0 * math.pi
    return max(LEAST_COUNTS * bench.encoder.resolution, travel / segments)


def coasting_pause(bench: Bench, rate: float, top: float, advance_on: float) -> float:
    """Return the pause [s] in which every axis of the bench comes to rest after a ramp.

    The drive signal is `rate` [A/s | V/s] times the time, at most `top` [A | V], until the axis has
    moved by `advance_on` [rad | m]. The pause is the delay of the drive plus a momentum divided by
    the least friction, but at least PAUSE. The momentum is that of the heaviest axis with the
    strongest actuator, plus the impulse of the effort that remains due to lag and delay of the
    drive. Raises NoSolutionError if the simulation of the ramp fails.
    """
    from frictool.engine.bench_experiment import play_one_ramp  # loads the engine

    known, period = bench.mechanics, bench.sample_period_s
    brake = max(known.coulomb.interval[0], LEAST_BRAKE * known.coulomb.value)
    axis = _axis(bench, 2)._replace(
        viscous=known.viscous.interval[0],
        coulomb=brake,
        breakaway=RATIOS[2] * brake,
        constant=bench.actuator.constant.interval[1],
        backlash=0.0,
    )
    state, extremes = np.asarray(rest(0.0)), np.zeros(3)
    samples = math.ceil(top / (rate * period))
    _, status = play_one_ramp(
        axis.checked().as_array(), state, 1.0, rate, top, 0, samples, period, math.inf, advance_on,
        extremes,
    )  # fmt: skip
    if status != OK:
        raise NoSolutionError(RAMPS_FAILED)
    delay = bench.delay_samples * period
    left = abs(state[DRIVE]) * axis.constant * (axis.lag + delay)
    return max(PAUSE, delay + float(axis.inertia * abs(state[VELOCITY]) + left) / brake)


def _turning(ramp: Ramp, unit: str) -> str:
    """Return text that names the positions at which the direction changes; "" without positions."""
    if not math.isfinite(ramp.high - ramp.low):
        return ""
    return (
        f"first segment of the other direction beyond {ramp.low:.6g} and {ramp.high:.6g} {unit}; "
    )


def _table(
    ramp: Ramp, period: float, segments: list[int], repetitions: int
) -> tuple[Vector, Vector]:
    rise = np.minimum(
        ramp.rate * period * np.arange(1, math.ceil(ramp.top / (ramp.rate * period)) + 1), ramp.top
    )
    one = np.concatenate((np.zeros(round(ramp.pause / period)), rise))
    numbers = np.concatenate(
        [np.arange(1, segments[0] + 1), -np.arange(1, segments[1] + 1)] * repetitions
    ).astype(float)
    return np.concatenate([one * np.sign(number) for number in numbers]), np.repeat(
        numbers, one.size
    )


def _checked(bench: Bench, limits: BenchLimits, ramp: Ramp, which: int) -> SimulatedRamps:
    """Return one round of ramps on the lightest (0), nominal (1) or heaviest (2) axis.

    Raises NoSolutionError if the axis moves too far, too fast, or not at all.
    """
    played = _play(_axis(bench, which), ramp, bench.sample_period_s)
    unit = limits.unit
    hint = "give a lower --rate" if not ramp.open_loop else "leave out --open-loop"
    travel = bench.mechanics.travel
    name = NAMES[which]
    if not played.all_moved:
        raise NoSolutionError(
            f"{limits.drive}: ramps up to {ramp.top:.4g} do not move the {name} axis; raise "
            "--amplitude"
        )
    if travel is not None and (played.low < travel.low or played.high > travel.high):
        raise NoSolutionError(
            f"travel: the {name} axis goes from {played.low:.4g} to {played.high:.4g} {unit}; "
            f"allowed: {travel.low:.4g} to {travel.high:.4g}; {hint}"
        )
    if played.speed > limits.speed:
        raise NoSolutionError(
            f"speed: the {name} axis reaches {played.speed:.4g} {unit}/s; allowed: at most "
            f"{limits.speed:.4g}; {hint}"
        )
    return played


def _axis(bench: Bench, which: int) -> AxisParameters:
    """Return the lightest axis with the strongest actuator (0), the nominal (1) or heaviest (2)."""
    known, actuator = bench.mechanics, bench.actuator

    def at(quantity: Quantity, end: int = which) -> float:
        return (quantity.interval[0], quantity.value, quantity.interval[1])[end]

    coulomb = at(known.coulomb)
    loose = min(at(known.backlash_coulomb), coulomb) if known.backlash_coulomb else coulomb
    return AxisParameters(
        inertia=at(known.inertia),
        viscous=at(known.viscous),
        coulomb=coulomb,
        breakaway=breakaway_range(bench)[which],
        constant=at(actuator.constant, 2 - which),
        lag=actuator.loop_time_constant_s,
        drive_limit=actuator.limit.value,
        backlash=at(known.backlash) if known.backlash else 0.0,
        backlash_coulomb=loose,
        backlash_breakaway=RATIOS[1] * loose,
        encoder_step=bench.encoder.resolution,
    ).checked()


def _play(axis: AxisParameters, ramp: Ramp, period: float) -> SimulatedRamps:
    """Simulate one round of ramps, to `ramp.high` and back.

    On endless travel, a round consists of SEGMENTS ramps in each direction.
    """
    from frictool.engine.bench_experiment import play_one_ramp  # loads the engine

    p = axis.as_array()
    state = np.asarray(rest(ramp.low if math.isfinite(ramp.low) else 0.0))
    used = {1.0: 0, -1.0: 0}
    extremes = np.array([state[POSITION], state[POSITION], 0.0])
    moved = True
    rise = math.ceil(ramp.top / (ramp.rate * period))
    pause = round(ramp.pause / period)
    for side in (1.0, -1.0):
        turned = False
        while not turned and used[side] < 4 * SEGMENTS and moved:
            start = state[POSITION]
            used[side] += 1
            turned, status = play_one_ramp(
                p,
                state,
                side,
                ramp.rate,
                ramp.top,
                pause,
                pause + rise,
                period,
                ramp.high if side > 0.0 else -ramp.low,
                math.inf if ramp.open_loop else ramp.advance_on,
                extremes,
            )
            if status != OK:
                raise NoSolutionError(RAMPS_FAILED)
            moved = state[POSITION] != start
            turned = turned or (math.isinf(ramp.high) and used[side] == SEGMENTS)
    low, high, speed = extremes.tolist()
    return SimulatedRamps(used[1.0], used[-1.0], low, high, speed, moved)
