"""Breakaway ramps both ways over the travel (figure 4.6): the drive grows from nothing until the
axis moves, falls back, grows again.

A ramp is a segment of the sequence: a pause at zero, then the rise to the most that the breakaway
may need. Whoever plays it goes on to

    the next segment                         as soon as the encoder has moved by `advance_on` since
                                             the segment began
    the first segment of the other direction as soon as the position passes a turn

Played without these rules it drives the axis at the top of every ramp, which hardly any bench
stands; `open_loop` says to try. Either way it is simulated first, on the nominal axis, on the
lightest with the least friction, and on the heaviest with the most, all without their load, of
which no shape is known: the ramps only rise by `load.most` further.

The rate. After a breakaway under a ramp of R [N m/s | N/s] the axis takes t = (6 inertia
step/R)^(1/3) at most to show a count, in which the effort grows by R t. Kept at 5 % of the
breakaway (`identify` corrects for it): R = (0.05 F)^(3/2)/sqrt(6 inertia step).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.engine.axis_motion import advance
from frictool.engine.status import OK
from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.cramer_rao import Vector
from frictool.identify.excite.excitation_sequence import ExcitationSequence, command_sequence
from frictool.plant.axis import POSITION, VELOCITY, AxisParameters, rest

LATENESS = 0.05  # of the breakaway
SLOWEST_RISE = 1.0  # s, that a ramp takes at least to the breakaway expected
PAUSE = 0.05  # s
RATIOS = (
    1.0,
    1.1,
    1.5,
)  # breakaway over Coulomb friction, least, expected, most, where the bench does not say (tables 4.8 and 4.1)
HEADROOM = 1.1  # of the top of a ramp over the most that the breakaway may need
SEGMENTS = 40  # over the travel
LEAST_COUNTS = 2.0
SPARE = 1.5  # segments written over those that the slowest axis needs
NAMES = ("lightest", "nominal", "heaviest")


class Ramp(NamedTuple):
    """A ramp and the rules that it is played by, in SI and units of the drive: rate and top of the
    drive; turns and distance to go on."""

    rate: float
    top: float
    low: float
    high: float
    advance_on: float
    open_loop: bool


class SimulatedRamps(NamedTuple):
    """What an axis made of it: segments used either way, the places and the speed that it reached,
    and whether it always broke away."""

    forward: int
    backward: int
    low: float
    high: float
    speed: float
    moved: bool


def breakaway_range(bench: Bench) -> tuple[float, float, float]:
    """Least, expected, most, N m | N: the bench's, else from its Coulomb friction."""
    known, coulomb = bench.mechanics.breakaway, bench.mechanics.coulomb
    if known is not None:
        return known.interval[0], known.value, known.interval[1]
    return (
        RATIOS[0] * coulomb.interval[0],
        RATIOS[1] * coulomb.value,
        RATIOS[2] * coulomb.interval[1],
    )


def effort_rate(bench: Bench) -> float:
    """The rate of the ramps, N m/s | N/s."""
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
) -> ExcitationSequence:
    """The sequence. top [A | V] and rate [A/s | V/s] where they are not to be found. Raises
    NoSolutionError naming what forbids it."""
    constant, most = bench.actuator.constant, breakaway_range(bench)[2]
    needed = (most + limits.offset + limits.load) / constant.interval[0]
    top = top or min(HEADROOM * needed, limits.drive_limit)
    unit = "A" if limits.drive == "current" else "V"
    if not needed <= top <= limits.drive_limit:
        raise NoSolutionError(
            f"{limits.drive}: the ramps rise to {top:.4g} {unit}; allowed: {needed:.4g} (the most that the breakaway may need) to "
            f"{limits.drive_limit:.4g} (actuator.limit)"
        )
    travel = limits.travel if math.isfinite(limits.travel) else 2.0 * math.pi
    ramp = Ramp(
        rate or effort_rate(bench) / constant.value,
        top,
        limits.low,
        limits.high,
        max(LEAST_COUNTS * bench.encoder.resolution, travel / SEGMENTS),
        open_loop,
    )
    played = [_checked(bench, limits, ramp, name) for name in range(3)]
    segments = [
        math.ceil(SPARE * max(getattr(one, side) for one in played))
        for side in ("forward", "backward")
    ]
    command, number = _table(ramp, bench.sample_period_s, segments, repetitions)
    rule = (
        "play every row"
        if open_loop
        else f"next segment as soon as the position has moved by {ramp.advance_on:.6g} {limits.unit} since the segment began; first "
        f"segment of the other direction beyond {ramp.low:.6g} and {ramp.high:.6g} {limits.unit}; negative segments go backward"
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


def _table(
    ramp: Ramp, period: float, segments: list[int], repetitions: int
) -> tuple[Vector, Vector]:
    """Command (n,) and number of the segment (n,)."""
    rise = np.minimum(
        ramp.rate * period * np.arange(1, math.ceil(ramp.top / (ramp.rate * period)) + 1), ramp.top
    )
    one = np.concatenate((np.zeros(round(PAUSE / period)), rise))
    numbers = np.concatenate(
        [np.arange(1, segments[0] + 1), -np.arange(1, segments[1] + 1)] * repetitions
    ).astype(float)
    return np.concatenate([one * np.sign(number) for number in numbers]), np.repeat(
        numbers, one.size
    )


def _checked(bench: Bench, limits: BenchLimits, ramp: Ramp, which: int) -> SimulatedRamps:
    """Plays one round on the lightest, nominal or heaviest axis. Raises NoSolutionError where it
    goes too far, too fast, or not at all."""
    played = _play(_axis(bench, which), ramp, bench.sample_period_s)
    unit, hint = (
        limits.unit,
        "give a lower --rate"
        if not ramp.open_loop
        else "play it by its rules, without --open-loop",
    )
    travel, name = bench.mechanics.travel, NAMES[which]
    if not played.moved:
        raise NoSolutionError(
            f"{limits.drive}: ramps up to {ramp.top:.4g} do not move the {name} axis; raise --amplitude"
        )
    if travel is not None and (played.low < travel.low or played.high > travel.high):
        raise NoSolutionError(
            f"travel: the {name} axis goes from {played.low:.4g} to {played.high:.4g} {unit}; allowed: {travel.low:.4g} to "
            f"{travel.high:.4g}; {hint}"
        )
    if played.speed > limits.speed:
        raise NoSolutionError(
            f"speed: the {name} axis reaches {played.speed:.4g} {unit}/s; allowed: {limits.speed:.4g}; {hint}"
        )
    return played


def _axis(bench: Bench, which: int) -> AxisParameters:
    """The axis at an end of every range, or at its value: 0 the lightest with the strongest
    actuator, 1 the nominal, 2 the heaviest."""
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
    """One round: forward up to the turn, and back. A travel without end is SEGMENTS either way."""
    p, state = axis.as_array(), np.asarray(rest(ramp.low if math.isfinite(ramp.low) else 0.0))
    used, low, high, speed, moved = {1.0: 0, -1.0: 0}, state[POSITION], state[POSITION], 0.0, True
    rise, pause = math.ceil(ramp.top / (ramp.rate * period)), round(PAUSE / period)
    for side in (1.0, -1.0):
        turned = False
        while not turned and used[side] < 4 * SEGMENTS and moved:
            start = state[POSITION]
            used[side] += 1
            for k in range(pause + rise):
                command = side * min(max(0, k - pause + 1) * ramp.rate * period, ramp.top)
                if advance(state, command, p, period) != OK:
                    raise NoSolutionError(
                        "the simulation of the ramps failed; check the bench's mechanics"
                    )
                low, high = min(low, state[POSITION]), max(high, state[POSITION])
                speed = max(speed, abs(state[VELOCITY]))
                turned = side * state[POSITION] > (ramp.high if side > 0.0 else -ramp.low)
                if not ramp.open_loop and (
                    turned or abs(state[POSITION] - start) >= ramp.advance_on
                ):
                    break
            moved = state[POSITION] != start
            turned = turned or (math.isinf(ramp.high) and used[side] == SEGMENTS)
    return SimulatedRamps(used[1.0], used[-1.0], float(low), float(high), speed, moved)
