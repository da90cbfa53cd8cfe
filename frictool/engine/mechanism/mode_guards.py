"""How far each mode is from its end: which guards forces keep, which a speed or a position keeps,
and what may be missed within a step."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.compiled_mechanism import (
    BLOCKS,
    COUPLING,
    COUPLING_ENDS,
    COUPLING_WIDTH,
    COUPLINGS,
    DAMPING,
    GAP,
    HIGH,
    JOINT_ENDS,
    JOINTS,
    LOW,
    OFFSET,
    RATIO,
    STIFFNESS,
    STOP,
    STOP_BLOCKS,
    STOP_WIDTH,
    STOPS,
)
from frictool.engine.mechanism.joint_losses import joint_row
from frictool.engine.mechanism.state import FREE, OPEN, STUCK
from frictool.runtime.kernels import inset_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

# a dip of a guard that comes nearer to its end than this part of its change is looked at again
GRAZING = 1e-3
BROKEN = -1.0  # a guard below this has been passed


@inset_kernel
def forces_hold(k: Places, modes: Places, guard: Vector) -> bool:
    """Whether all modes that forces keep go on: what sticks, closed contacts, sides of kinks,
    compliant flanks."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    for i in range(n):
        if guard[i] < BROKEN and modes[i] == STUCK:
            return False
    for i in range(n, n + j):
        if guard[i] < BROKEN and modes[i] != OPEN:
            return False
    broken = False
    for i in range(n + j, n + 2 * j + c):
        broken = broken or guard[i] < BROKEN
    return not broken


@inset_kernel
def is_forced(k: Places, modes: Places, index: int) -> bool:
    """Whether a guard is a force's, not a speed's or a position's."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    if index < n:
        return bool(modes[index] == STUCK)
    if index < n + j:
        return bool(modes[index] != OPEN)
    return bool(index < n + 2 * j + c)


@inset_kernel
def _flank_left(
    k: Places, p: Vector, coupling: int, y: Vector, rates: Vector, mode: int
) -> tuple[float, float]:
    """How hard a compliant flank is pressed, or how far an open one is from being so, and the rate
    of that."""
    n, row, ends = (
        k[BLOCKS],
        k[COUPLING] + coupling * COUPLING_WIDTH,
        k[COUPLING_ENDS] + 3 * coupling,
    )
    a, b = k[ends], k[ends + 1]
    e, rate, change = y[b] - p[row + OFFSET], y[n + b], rates[n + b]
    if a >= 0:
        e, rate, change = (
            e - p[row + RATIO] * y[a],
            rate - p[row + RATIO] * y[n + a],
            change - p[row + RATIO] * rates[n + a],
        )
    side = -1.0 if e < 0.0 else 1.0
    if mode != OPEN:
        side = float(mode)
    beyond = side * e - p[row + GAP]
    pressed = p[row + STIFFNESS] * beyond + side * p[row + DAMPING] * rate
    gained = side * (p[row + STIFFNESS] * rate + p[row + DAMPING] * change)
    if mode != OPEN:
        return pressed, gained
    if pressed < p[row + STIFFNESS] * beyond:
        return -pressed, -gained
    return -p[row + STIFFNESS] * beyond, -p[row + STIFFNESS] * side * rate


@part_kernel
def distance_to_guard(
    k: Places, p: Vector, index: int, y: Vector, rates: Vector, modes: Places
) -> tuple[float, float]:
    """How far a speed is from 0, a gap's nearer flank or an end stop from its contact, and the rate
    of that; rates (y,): y'."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    if index < n:
        return modes[index] * y[n + index], modes[index] * rates[n + index]
    if n + 2 * j <= index < n + 2 * j + c:
        return _flank_left(k, p, index - n - 2 * j, y, rates, modes[index])
    if index < n + j:
        joint = index - n
        row, a, b = (
            joint_row(k, joint),
            k[k[JOINT_ENDS] + 2 * joint],
            k[k[JOINT_ENDS] + 2 * joint + 1],
        )
        e, rate = (
            y[b] - p[row + RATIO] * y[a] - p[row + OFFSET],
            y[n + b] - p[row + RATIO] * y[n + a],
        )
        return (p[row + GAP] + e, rate) if e < 0.0 else (p[row + GAP] - e, -rate)
    stop = index - n - 2 * j - c
    block, row = k[k[STOP_BLOCKS] + stop], k[STOP] + stop * STOP_WIDTH
    below, above = y[block] - p[row + LOW], p[row + HIGH] - y[block]
    return (below, y[n + block]) if below < above else (above, -y[n + block])


@inset_kernel
def is_broken(
    k: Places, p: Vector, index: int, y: Vector, modes: Places, guard: Vector, begin: Vector
) -> bool:
    """Whether a guard has been passed; a flank or a stop on the way in, or back on its way out
    within a step that it began before its end.

    begin: the guards where the step begins. One that begins beyond its end has just been left.
    """
    if guard[index] >= BROKEN:
        return False
    if index < k[BLOCKS] or is_forced(k, modes, index) or begin[index] >= 0.0:
        return True
    _, rate = distance_to_guard(k, p, index, y, y, modes)
    return bool(rate < 0.0)


@inset_kernel
def is_any_broken(
    k: Places, p: Vector, y: Vector, modes: Places, guard: Vector, begin: Vector
) -> bool:
    """Whether any guard has been passed."""
    broken = False
    for index in range(k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS] + k[STOPS]):
        broken = broken or is_broken(k, p, index, y, modes, guard, begin)
    return broken


@inset_kernel
def _lowest(g0: float, r0: float, g1: float, r1: float, h: float) -> tuple[float, float]:
    """Where in a step the cubic through both ends (values, rates) is lowest, and its value there;
    the end where it falls all the way."""
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


@inset_kernel
def _dip(g0: float, r0: float, g1: float, r1: float, h: float, shortest: float) -> float:
    """`shortest`, or an earlier instant at which a guard that is sound at both ends may not be."""
    if r0 >= 0.0 or r1 <= 0.0:
        return shortest
    at, value = _lowest(g0, r0, g1, r1, h)
    if 0.0 < at < shortest and value < GRAZING * (g0 - value + g1 - value):
        return at
    return shortest


@part_kernel
def first_dip(
    k: Places,
    p: Vector,
    h: float,
    y: Vector,
    begin: Vector,
    end: Vector,
    after: Vector,
    modes: Places,
    guard: Vector,
) -> float:
    """The earliest instant in a step, or its length, at which a speed or a flank may have come back
    from beyond its end."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    shortest = h
    for i in range(n):
        if guard[i] < math.inf and modes[i] not in (STUCK, FREE):
            shortest = _dip(
                modes[i] * y[n + i],
                modes[i] * begin[n + i],
                modes[i] * end[n + i],
                modes[i] * after[n + i],
                h,
                shortest,
            )
    for joint in range(j):
        if modes[n + joint] != OPEN:
            continue
        row = joint_row(k, joint)
        a, b, ratio, gap = (
            k[k[JOINT_ENDS] + 2 * joint],
            k[k[JOINT_ENDS] + 2 * joint + 1],
            p[row + RATIO],
            p[row + GAP],
        )
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
            shortest = _dip(
                y[block] - p[row + LOW],
                y[n + block],
                end[block] - p[row + LOW],
                end[n + block],
                h,
                shortest,
            )
        if p[row + HIGH] < math.inf:
            shortest = _dip(
                p[row + HIGH] - y[block],
                -y[n + block],
                p[row + HIGH] - end[block],
                -end[n + block],
                h,
                shortest,
            )
    return shortest
