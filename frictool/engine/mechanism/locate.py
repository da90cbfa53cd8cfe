"""The instant within a step at which the first guard is passed, and the step to it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.image import BLOCKS, COUPLINGS, JOINTS, STOPS
from frictool.engine.mechanism.state import Room
from frictool.engine.mechanism.step import BROKEN, is_broken, is_forced, try_step
from frictool.kernels import bare_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

ROUNDS = 200
# where a guard is taken to: a speed or a position to its end, a force just beyond it, so that what it kept ends
AT_END, BEYOND = -0.5, -2.0
FAR = -4.0
NEAREST = 4e-16  # of the time; nearer instants are one


@bare_kernel
def _aim(k: Places, modes: Places, index: int) -> float:
    return BEYOND if is_forced(k, modes, index) else AT_END


@bare_kernel
def _is_there(k: Places, p: Vector, y: Vector, modes: Places, guard: Vector, index: int, count: int) -> bool:
    """Whether the leading guard is where it is taken to, and no other is passed by more."""
    forced = is_forced(k, modes, index)
    if forced and not FAR <= guard[index] < BROKEN:
        return False
    if not forced and not BROKEN <= guard[index] <= 0.0:
        return False
    for other in range(count):
        if guard[other] < (FAR if is_forced(k, modes, other) else BROKEN) and is_broken(k, p, other, y, modes, guard):
            return False
    return True


@part_kernel
def locate(
    k: Places,
    p: Vector,
    laws: Places,
    t: float,
    h: float,
    tolerance: float,
    y: Vector,
    modes: Places,
    room: Room,
) -> tuple[float, bool]:
    """Takes the step again, to the first instant at which a guard is passed; returns its length, and whether the field failed there.

    room.guard: at the beginning; trial: at the end of the step of length h, which has passed one. A bracketed search for the guard that is
    passed first by regula falsi with the weights of Illinois, halved where that is slow.
    """
    count = k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS] + k[STOPS]
    low, high, lead, kept = 0.0, h, -1, 0
    at_low, at_high, trial, end = room.at_low, room.at_high, room.trial, room.end
    for index in range(count):
        at_low[index], at_high[index] = room.guard[index], trial[index]
    nearest = NEAREST * max(t, 1e-6)
    weight_low, weight_high = 1.0, 1.0
    for attempt in range(ROUNDS):
        at, leader = high, -1
        for index in range(count):
            if is_broken(k, p, index, end, modes, at_high) or (at_high[index] < BROKEN and index == lead):
                aim = _aim(k, modes, index)
                g0, g1 = at_low[index] - aim, at_high[index] - aim
                if not math.isfinite(g0):
                    g0 = -g1
                if g0 <= 0.0:
                    root = low
                else:
                    if index == lead:
                        g0, g1 = g0 * weight_low, g1 * weight_high
                    root = low + (high - low) * g0 / (g0 - g1)
                if root < at or leader < 0:
                    at, leader = root, index
        if leader != lead:
            weight_low, weight_high, kept = 1.0, 1.0, 0
        lead = leader
        if attempt % 4 == 3 or not low < at < high:
            at = 0.5 * (low + high)
        if high - low <= nearest or not low < at < high:
            at = high
        error, _ = try_step(k, p, laws, t, at, tolerance, y, modes, room)
        if not math.isfinite(error):
            return at, True
        if at == high or _is_there(k, p, end, modes, trial, lead, count):
            return at, False
        passed = False
        for index in range(count):
            passed = passed or is_broken(k, p, index, end, modes, trial)
        if passed:
            high = at
            for index in range(count):
                at_high[index] = trial[index]
            weight_high = 1.0
            weight_low = weight_low * 0.5 if kept == 1 else 1.0
            kept = 1
        else:
            low = at
            for index in range(count):
                at_low[index] = trial[index]
            weight_low = 1.0
            weight_high = weight_high * 0.5 if kept == -1 else 1.0
            kept = -1
    return high, True
