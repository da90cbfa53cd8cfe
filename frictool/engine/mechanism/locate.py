"""The instant within a step at which the first guard is passed, and the step to it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.ends import BROKEN, is_broken, is_forced, way_left
from frictool.engine.mechanism.field import field
from frictool.engine.mechanism.image import BLOCKS, COUPLINGS, INNER, JOINTS, STOPS
from frictool.engine.mechanism.state import (
    AFTER,
    AT_HIGH,
    AT_LOW,
    END,
    GUARD,
    INPUTS,
    POWER,
    RATES_HIGH,
    RATES_LOW,
    SPENT,
    TRIAL,
    Y_HIGH,
    Y_LOW,
    Room,
)
from frictool.engine.mechanism.step import try_step
from frictool.friction.status import OK
from frictool.kernels import inset_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

ROUNDS = 200
# where a guard is taken to: a speed or a position to its end, a force just beyond it, so that what it kept ends
AT_END, BEYOND = -0.5, -2.0
FAR = -4.0
LITTLE = 1e-5  # of a step
NEAREST = 4e-16  # of the time; nearer instants are one


@inset_kernel
def _is_there(k: Places, p: Vector, y: Vector, modes: Places, guard: Vector, index: int, count: int) -> bool:
    """Whether the leading guard is where it is taken to, on its way out, and no other is passed by more."""
    if is_forced(k, modes, index):
        if not FAR <= guard[index] < BROKEN:
            return False
    else:
        if not BROKEN <= guard[index] <= 0.0:
            return False
        if index >= k[BLOCKS] and way_left(k, p, index, y, y, modes)[1] >= 0.0:
            return False
    for other in range(count):
        if guard[other] < (FAR if is_forced(k, modes, other) else BROKEN) and is_broken(k, p, other, y, modes, guard):
            return False
    return True


@inset_kernel
def _crossing(g0: float, r0: float, g1: float, r1: float, h: float) -> float:
    """Where the cubic through both ends of a time h (values, rates) last falls through 0, found from where it is above."""
    slope = (g1 - g0) / h
    a, b = (r0 + r1 - 2.0 * slope) / (h * h), (3.0 * slope - 2.0 * r0 - r1) / h
    low, high = 0.0, h
    for step in range(8):
        s = h * (8 - step) / 8.0
        if g0 + s * (r0 + s * (b + s * a)) > 0.0:
            low = s
            break
        high = s
    for _ in range(60):
        s = 0.5 * (low + high)
        if g0 + s * (r0 + s * (b + s * a)) > 0.0:
            low = s
        else:
            high = s
    return 0.5 * (low + high)


@inset_kernel
def _has_rate(k: Places, modes: Places, index: int) -> bool:
    """Whether the rate of a guard is known: a speed's, a position's, a compliant flank's."""
    return not is_forced(k, modes, index) or index >= k[BLOCKS] + 2 * k[JOINTS]


@inset_kernel
def _smooth_crossing(k: Places, p: Vector, index: int, aim: float, modes: Places, room: Room, low: float, high: float) -> float:
    """Where a guard with a rate that is passed at `high` is where it is taken to."""
    g1, r1 = way_left(k, p, index, room.lines[Y_HIGH], room.lines[RATES_HIGH], modes)
    g0, r0 = way_left(k, p, index, room.lines[Y_LOW], room.lines[RATES_LOW], modes)
    past = aim * g1 / room.lines[AT_HIGH][index]
    return low + _crossing(g0 - past, r0, g1 - past, r1, high - low)


@part_kernel
def _shift(
    k: Places, p: Vector, laws: Places, t: float, at: float, longest: float, modes: Places, index: int, room: Room
) -> tuple[float, int]:
    """Moves the end of a step by the little that a guard is off, by its rates: the error is of third order in that. Returns its length."""
    n, end, after = k[BLOCKS], room.lines[END], room.lines[AFTER]
    g, r = way_left(k, p, index, end, after, modes)
    if g == 0.0 or r == 0.0 or not math.isfinite(room.lines[TRIAL][index]):
        return at, 0
    aim = BEYOND if is_forced(k, modes, index) else AT_END
    more = (aim * abs(g / room.lines[TRIAL][index]) - g) / r
    if not abs(more) <= LITTLE * at or at + more > longest:
        return at, 0
    for i in range(n):
        end[i] += more * (end[n + i] + 0.5 * more * after[n + i])
        end[n + i] += more * after[n + i]
    for i in range(2 * n, 2 * n + k[INNER]):
        end[i] += more * after[i]
    for e in range(room.lines.shape[1]):
        room.lines[SPENT][e] += more * room.lines[POWER][e]
    status = field(k, p, laws, t + at + more, end, modes, room.lines[INPUTS], after, room.w, room.lines[TRIAL], room.lines[POWER])
    return at + more, status


@inset_kernel
def _keep(count: int, y: Vector, rates: Vector, guard: Vector, y_kept: Vector, rates_kept: Vector, kept: Vector) -> None:
    for i in range(y.shape[0]):
        y_kept[i], rates_kept[i] = y[i], rates[i]
    for index in range(count):
        kept[index] = guard[index]


@part_kernel
def locate(
    k: Places, p: Vector, laws: Places, t: float, h: float, tolerance: float, y: Vector, modes: Places, room: Room
) -> tuple[float, bool]:
    """Takes the step again, to the first instant at which a guard is passed; returns its length, and whether the field failed there.

    GUARD: at the beginning; TRIAL: at the end of the step of length h, which has passed one. A bracketed search for the guard that is
    passed first: speeds and positions by the cubic through both ends, efforts by regula falsi with the weights of Illinois; halved where
    that is slow.
    """
    count = k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS] + k[STOPS]
    low, high, lead, kept = 0.0, h, -1, 0
    at_low, at_high, trial, end = room.lines[AT_LOW], room.lines[AT_HIGH], room.lines[TRIAL], room.lines[END]
    _keep(count, y, room.slopes[0], room.lines[GUARD], room.lines[Y_LOW], room.lines[RATES_LOW], at_low)
    _keep(count, end, room.lines[AFTER], trial, room.lines[Y_HIGH], room.lines[RATES_HIGH], at_high)
    nearest = NEAREST * max(t, 1e-6)
    weight_low, weight_high = 1.0, 1.0
    for attempt in range(ROUNDS):
        at, leader = high, -1
        for index in range(count):
            if not is_broken(k, p, index, room.lines[Y_HIGH], modes, at_high):
                continue
            if _has_rate(k, modes, index):
                aim = BEYOND if is_forced(k, modes, index) else AT_END
                root = _smooth_crossing(k, p, index, aim, modes, room, low, high)
            else:
                g0, g1 = at_low[index] - BEYOND, at_high[index] - BEYOND
                if not math.isfinite(g0):
                    g0 = abs(g1)
                if index == lead:
                    g0, g1 = g0 * weight_low, g1 * weight_high
                root = low + (high - low) * max(g0, 0.0) / (max(g0, 0.0) - min(g1, -1e-3))
            if root < at or leader < 0:
                at, leader = root, index
        if leader != lead:
            weight_low, weight_high, kept = 1.0, 1.0, 0
        lead = leader
        if lead < 0 or high - low <= nearest:
            at = high
        elif attempt % 4 == 3 or not low < at < high:
            at = 0.5 * (low + high)
            if not low < at < high:
                at = high
        error, _ = try_step(k, p, laws, t, at, tolerance, y, modes, room)
        if not math.isfinite(error):
            return at, True
        if at == high or _is_there(k, p, end, modes, trial, lead, count):
            return at, False
        if _has_rate(k, modes, lead):
            at, status = _shift(k, p, laws, t, at, h, modes, lead, room)
            if status != OK:
                return at, True
            if _is_there(k, p, end, modes, trial, lead, count):
                return at, False
        passed = False
        for index in range(count):
            passed = passed or is_broken(k, p, index, end, modes, trial)
        if passed:
            high = at
            _keep(count, end, room.lines[AFTER], trial, room.lines[Y_HIGH], room.lines[RATES_HIGH], at_high)
            weight_high = 1.0
            weight_low = weight_low * 0.5 if kept == 1 else 1.0
            kept = 1
        else:
            low = at
            _keep(count, end, room.lines[AFTER], trial, room.lines[Y_LOW], room.lines[RATES_LOW], at_low)
            weight_low = 1.0
            weight_high = weight_high * 0.5 if kept == -1 else 1.0
            kept = -1
    return high, True
