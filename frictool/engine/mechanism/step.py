"""One step of the integrator with all modes held, and what may have ended within it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.field import field
from frictool.engine.mechanism.image import (
    BLOCKS,
    COUPLINGS,
    GAP,
    HIGH,
    INNER,
    INNER_SIZE,
    JOINT_ENDS,
    JOINTS,
    LOW,
    OFFSET,
    RATIO,
    SPEED,
    STOP,
    STOP_BLOCKS,
    STOP_WIDTH,
    STOPS,
)
from frictool.engine.mechanism.order_eight import NODES, STAGES, WEIGHTS, stage_point, step_end, step_error
from frictool.engine.mechanism.state import FREE, OPEN, STUCK, Room
from frictool.engine.mechanism.transmission import joint_row
from frictool.kernels import bare_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

PLACE_TIME = 1e-2  # s: positions are computed to the tolerance of a speed that counts, times this
GRAZING = 1e-3  # a dip of a guard that comes nearer to its end than this part of its change is looked at again
BROKEN = -1.0  # a guard below this has been passed


@bare_kernel
def forces_hold(k: Places, modes: Places, guard: Vector) -> bool:
    """Whether all modes that forces keep go on: what sticks, closed contacts, sides of kinks, compliant flanks."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    for i in range(n):
        if guard[i] < BROKEN and modes[i] == STUCK:
            return False
    for i in range(n, n + j):
        if guard[i] < BROKEN and modes[i] != OPEN:
            return False
    for i in range(n + j, n + 2 * j + c):
        if guard[i] < BROKEN:
            return False
    return True


@bare_kernel
def is_forced(k: Places, modes: Places, index: int) -> bool:
    """Whether a guard is a force's, not a speed's or a position's."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    if index < n:
        return modes[index] == STUCK
    if index < n + j:
        return modes[index] != OPEN
    return index < n + 2 * j + c


@part_kernel
def try_step(
    k: Places,
    p: Vector,
    laws: Places,
    t: float,
    h: float,
    tolerance: float,
    y: Vector,
    modes: Places,
    room: Room,
) -> tuple[float, float]:
    """From y at t to room.end, with y' there in `after`, the guards in `trial`, what is done [J] in `spent`.

    Before: y' at t in slopes[0], the powers there in first_power.

    Returns the error in tolerances, inf where the law or the mechanism fails, and the part of the step after which a force's guard was
    first seen broken, 1 where none was.
    """
    n, seen, failed = k[BLOCKS], 1.0, 0
    inputs, slopes, end, after, w = room.inputs, room.slopes, room.end, room.after, room.w
    guard, power, first_power, spent = room.trial, room.power, room.first_power, room.spent
    for e in range(spent.shape[0]):
        spent[e] = h * WEIGHTS[0] * first_power[e]
    for stage in range(1, STAGES):
        stage_point(stage, h, y, slopes, end)
        failed += field(k, p, laws, t + NODES[stage] * h, end, modes, inputs, slopes[stage], w, guard, power)
        if WEIGHTS[stage] != 0.0:
            weight = h * WEIGHTS[stage]
            for e in range(spent.shape[0]):
                spent[e] += weight * power[e]
        if NODES[stage] < seen and not forces_hold(k, modes, guard):
            seen = NODES[stage]
    step_end(h, y, slopes, end)
    failed += field(k, p, laws, t + h, end, modes, inputs, after, w, guard, power)
    worst = 0.0
    for i in range(n):
        if modes[i] != STUCK:
            size = p[k[SPEED] + i]
            worst = max(worst, step_error(h, slopes, i) / (size * PLACE_TIME))
            worst = max(worst, step_error(h, slopes, n + i) / max(size, abs(end[n + i])))
    for i in range(k[INNER]):
        worst = max(worst, step_error(h, slopes, 2 * n + i) / p[k[INNER_SIZE] + i])
    total = 0.0
    for i in range(end.shape[0]):
        total += end[i] + after[i]
    if failed != 0 or not math.isfinite(total) or not math.isfinite(worst):
        return math.inf, 1.0
    return worst / tolerance, seen


@bare_kernel
def _lowest(g0: float, r0: float, g1: float, r1: float, h: float) -> tuple[float, float]:
    """Where in a step the cubic through both ends (values, rates) is lowest, and its value there; the end where it falls all the way."""
    if not (r0 < 0.0 < r1):
        return (h, g1) if g1 < g0 else (0.0, g0)
    slope = (g1 - g0) / h
    a, b = (r0 + r1 - 2.0 * slope) / (h * h), (3.0 * slope - 2.0 * r0 - r1) / h
    root = b * b - 3.0 * a * r0
    if root < 0.0:
        return h, g1
    s = -r0 / (b + math.sqrt(root)) if b + math.sqrt(root) != 0.0 else h
    if not 0.0 < s < h:
        return h, g1
    return s, g0 + s * (r0 + s * (b + s * a))


@bare_kernel
def _dip(g0: float, r0: float, g1: float, r1: float, h: float, shortest: float) -> float:
    """`shortest`, or an earlier instant at which a guard that is sound at both ends may not be."""
    if r0 >= 0.0 or r1 <= 0.0:
        return shortest
    at, value = _lowest(g0, r0, g1, r1, h)
    if 0.0 < at < shortest and value < GRAZING * (g0 - value + g1 - value):
        return at
    return shortest


@bare_kernel
def first_dip(k: Places, p: Vector, h: float, y: Vector, begin: Vector, end: Vector, after: Vector, modes: Places, guard: Vector) -> float:
    """The earliest instant in a step, or its length, at which a speed or a flank may have come back from beyond its end."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    shortest = h
    for i in range(n):
        if guard[i] < math.inf and modes[i] not in (STUCK, FREE):
            shortest = _dip(modes[i] * y[n + i], modes[i] * begin[n + i], modes[i] * end[n + i], modes[i] * after[n + i], h, shortest)
    for joint in range(j):
        if modes[n + joint] != OPEN:
            continue
        row = joint_row(k, joint)
        a, b, ratio, gap = k[k[JOINT_ENDS] + 2 * joint], k[k[JOINT_ENDS] + 2 * joint + 1], p[row + RATIO], p[row + GAP]
        e0 = y[b] - ratio * y[a] - p[row + OFFSET]
        e1 = end[b] - ratio * end[a] - p[row + OFFSET]
        r0, r1 = y[n + b] - ratio * y[n + a], end[n + b] - ratio * end[n + a]
        shortest = _dip(e0 + gap, r0, e1 + gap, r1, h, shortest)
        shortest = _dip(gap - e0, -r0, gap - e1, -r1, h, shortest)
    for s in range(k[STOPS]):
        if modes[n + 2 * j + c + s] != OPEN:
            continue
        block, row = k[k[STOP_BLOCKS] + s], k[STOP] + s * STOP_WIDTH
        if p[row + LOW] > -math.inf:
            shortest = _dip(y[block] - p[row + LOW], y[n + block], end[block] - p[row + LOW], end[n + block], h, shortest)
        if p[row + HIGH] < math.inf:
            shortest = _dip(p[row + HIGH] - y[block], -y[n + block], p[row + HIGH] - end[block], -end[n + block], h, shortest)
    return shortest


@bare_kernel
def is_broken(k: Places, p: Vector, index: int, y: Vector, modes: Places, guard: Vector) -> bool:
    """Whether a guard has been passed; a flank or a stop only on the way in."""
    if guard[index] >= BROKEN:
        return False
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    if n <= index < n + j and modes[index] == OPEN:
        joint = index - n
        row, a, b = joint_row(k, joint), k[k[JOINT_ENDS] + 2 * joint], k[k[JOINT_ENDS] + 2 * joint + 1]
        e, rate = y[b] - p[row + RATIO] * y[a] - p[row + OFFSET], y[n + b] - p[row + RATIO] * y[n + a]
        return e * rate > 0.0
    if index >= n + 2 * j + c:
        stop = index - n - 2 * j - c
        block, row = k[k[STOP_BLOCKS] + stop], k[STOP] + stop * STOP_WIDTH
        if y[block] < p[row + LOW]:
            return y[n + block] < 0.0
        return y[n + block] > 0.0
    return True
