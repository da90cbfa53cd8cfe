"""The instant within a step at which the first guard is passed, and the part of the step to it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.compiled_mechanism import (
    BLOCKS,
    COUPLINGS,
    JOINTS,
    STOPS,
    CompiledMechanism,
)
from frictool.engine.mechanism.dormand_prince8 import AFTER
from frictool.engine.mechanism.integration_step import look, trace
from frictool.engine.mechanism.mode_guards import (
    BROKEN,
    distance_to_guard,
    is_any_broken,
    is_broken,
    is_forced,
)
from frictool.engine.mechanism.state import (
    AT_HIGH,
    AT_LOW,
    END,
    GUARD,
    PATH,
    RATES_HIGH,
    RATES_LOW,
    SPENT,
    TRIAL,
    Y_HIGH,
    Y_LOW,
    MechanismState,
    Workspace,
)
from frictool.engine.mechanism.weighted_sums import on_path
from frictool.runtime.kernels import inset_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

ROUNDS = 200
NEWTON, NEAR = (
    60,
    1e-15,
)  # rounds, and the part of a step at which they end, for the zero of a cubic
# where a guard is taken to: a speed or a position to its end, a force just beyond it, so that what
# it kept ends
AT_END, BEYOND = -0.5, -2.0
FAR = -4.0
NEAREST = 4e-16  # of the time; nearer instants are one


@inset_kernel
def _is_there(
    k: Places,
    p: Vector,
    y: Vector,
    modes: Places,
    guard: Vector,
    begin: Vector,
    index: int,
    count: int,
) -> bool:
    """Whether the leading guard is where it is taken to, on its way out, and no other is passed by
    more."""
    if is_forced(k, modes, index):
        if not FAR <= guard[index] < BROKEN:
            return False
    else:
        if not BROKEN <= guard[index] <= 0.0:
            return False
        if index >= k[BLOCKS] and distance_to_guard(k, p, index, y, y, modes)[1] >= 0.0:
            return False
    for other in range(count):
        if guard[other] < (FAR if is_forced(k, modes, other) else BROKEN) and is_broken(
            k, p, other, y, modes, guard, begin
        ):
            return False
    return True


@inset_kernel
def _crossing(g0: float, r0: float, g1: float, r1: float, h: float) -> float:
    """Where the cubic through both ends of a time h (values, rates) last falls through 0, found
    from where it is above."""
    slope = (g1 - g0) / h
    a, b = (r0 + r1 - 2.0 * slope) / (h * h), (3.0 * slope - 2.0 * r0 - r1) / h
    low, high = 0.0, h
    for step in range(8):
        s = h * (8 - step) / 8.0
        if g0 + s * (r0 + s * (b + s * a)) > 0.0:
            low = s
            break
        high = s
    s = 0.5 * (low + high)
    for _ in range(NEWTON):
        value, rate = g0 + s * (r0 + s * (b + s * a)), r0 + s * (2.0 * b + s * 3.0 * a)
        low, high = (s, high) if value > 0.0 else (low, s)
        after = s - value / rate if rate != 0.0 else low
        if not low < after < high:
            after = 0.5 * (low + high)
        if abs(after - s) <= NEAR * h:
            return after
        s = after
    return s


@inset_kernel
def _has_rate(k: Places, modes: Places, index: int) -> bool:
    """Whether the rate of a guard is known: a speed's, a position's, a compliant flank's."""
    return not is_forced(k, modes, index) or index >= k[BLOCKS] + 2 * k[JOINTS]


@inset_kernel
def _smooth_crossing(
    k: Places,
    p: Vector,
    index: int,
    aim: float,
    modes: Places,
    room: Workspace,
    low: float,
    high: float,
) -> float:
    """Where a guard with a rate that is passed at `high` is where it is taken to."""
    g1, r1 = distance_to_guard(k, p, index, room.lines[Y_HIGH], room.lines[RATES_HIGH], modes)
    g0, r0 = distance_to_guard(k, p, index, room.lines[Y_LOW], room.lines[RATES_LOW], modes)
    past = aim * g1 / room.lines[AT_HIGH][index]
    return low + _crossing(g0 - past, r0, g1 - past, r1, high - low)


@inset_kernel
def _keep(
    count: int,
    y: Vector,
    rates: Vector,
    guard: Vector,
    y_kept: Vector,
    rates_kept: Vector,
    kept: Vector,
) -> None:
    for i in range(rates.shape[0]):
        y_kept[i], rates_kept[i] = y[i], rates[i]
    for index in range(count):
        kept[index] = guard[index]


@inset_kernel
def _keep_low(count: int, y: Vector, rates: Vector, guard: Vector, room: Workspace) -> None:
    _keep(count, y, rates, guard, room.lines[Y_LOW], room.lines[RATES_LOW], room.lines[AT_LOW])


@inset_kernel
def _keep_high(count: int, room: Workspace) -> None:
    kept = room.lines[Y_HIGH], room.lines[RATES_HIGH], room.lines[AT_HIGH]
    _keep(count, room.lines[END], room.slopes[AFTER], room.lines[TRIAL], kept[0], kept[1], kept[2])


@inset_kernel
def _first(
    k: Places,
    p: Vector,
    modes: Places,
    room: Workspace,
    low: float,
    high: float,
    lead: int,
    weights: tuple[float, float],
) -> tuple[float, int]:
    """The earliest instant at which a guard that is passed at `high` may be where it is taken to,
    and whose it is; weights: of `lead`."""
    at, leader, at_low, at_high = high, -1, room.lines[AT_LOW], room.lines[AT_HIGH]
    for index in range(k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS] + k[STOPS]):
        if not is_broken(k, p, index, room.lines[Y_HIGH], modes, at_high, room.lines[GUARD]):
            continue
        if _has_rate(k, modes, index):
            aim = BEYOND if is_forced(k, modes, index) else AT_END
            root = _smooth_crossing(k, p, index, aim, modes, room, low, high)
        else:
            g0, g1 = at_low[index] - BEYOND, at_high[index] - BEYOND
            if not math.isfinite(g0):
                g0 = abs(g1)
            if index == lead:
                g0, g1 = g0 * weights[0], g1 * weights[1]
            root = low + (high - low) * max(g0, 0.0) / (max(g0, 0.0) - min(g1, -1e-3))
        if root < at or leader < 0:
            at, leader = root, index
    return at, leader


@part_kernel
def locate(
    machine: CompiledMechanism, state: MechanismState, t: float, h: float
) -> tuple[float, bool]:
    """Goes back along the step to the first instant at which a guard is passed; returns its length,
    and whether the field failed there.

    GUARD: at the beginning; TRIAL: at the end of the step of length h, which has passed one. A
    bracketed search for the guard that is passed first: speeds and positions by the cubic through
    both ends, efforts by regula falsi with the weights of Illinois; halved where that is slow. Each
    instant is looked at on the step's path; after it END, AFTER, TRIAL and SPENT are those of a
    step to there.
    """
    k, p, _ = machine
    y, modes, room = state.y, state.modes, state.room
    count = k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS] + k[STOPS]
    end, after, trial = room.lines[END], room.slopes[AFTER], room.lines[TRIAL]
    low, high, lead, weights, kept = 0.0, h, -1, (1.0, 1.0), 0
    _keep_low(count, y, room.slopes[0], room.lines[GUARD], room)
    _keep_high(count, room)
    if not trace(machine, state, t, h):
        return h, True
    for attempt in range(ROUNDS):
        at, leader = _first(k, p, modes, room, low, high, lead, weights)
        if leader != lead:
            weights, kept, lead = (1.0, 1.0), 0, leader
        if lead < 0 or high - low <= NEAREST * max(t, 1e-6):
            at = high
        elif attempt % 4 == 3 or not low < at < high:
            at = 0.5 * (low + high)
            if not low < at < high:
                at = high
        if not look(machine, state, t, h, at):
            return at, True
        if at == high or _is_there(k, p, end, modes, trial, room.lines[GUARD], lead, count):
            on_path(at / h, room.powers[PATH:], room.lines[SPENT])
            return at, False
        if is_any_broken(k, p, end, modes, trial, room.lines[GUARD]):
            high, weights, kept = at, (weights[0] * 0.5 if kept == 1 else 1.0, 1.0), 1
            _keep_high(count, room)
        else:
            low, weights, kept = at, (1.0, weights[1] * 0.5 if kept == -1 else 1.0), -1
            _keep_low(count, end, after, trial, room)
    return high, True
