"""Guards: distances of forces, speeds and positions from the values at which a mode ends.

A guard that is below its limit is called passed; the mode then ends.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.state import FREE, OPEN, STUCK
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

# a guard above GRAZING times its change in the step is not checked for a short passing
GRAZING = 1e-3
BROKEN = -1.0  # limit of a guard: a guard below this value is passed


@bare_kernel
def forces_hold(k: IntVector, modes: IntVector, guard: Vector) -> bool:
    """Return True if no force has passed the value at which a mode ends.

    The guards of sticking blocks, closed contacts, lossy joints and compliant flanks are checked.
    """
    n, j, c = k[ly.BLOCKS], k[ly.JOINTS], k[ly.COUPLINGS]
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


@bare_kernel
def is_forced(k: IntVector, modes: IntVector, index: int) -> bool:
    """Return True for a guard of a force, False for a guard of a speed or a position."""
    n, j, c = k[ly.BLOCKS], k[ly.JOINTS], k[ly.COUPLINGS]
    if index < n:
        return bool(modes[index] == STUCK)
    if index < n + j:
        return bool(modes[index] != OPEN)
    return bool(index < n + 2 * j + c)


@bare_kernel
def _flank_left(
    k: IntVector, p: Vector, coupling: int, y: Vector, rates: Vector, mode: int
) -> tuple[float, float]:
    n = k[ly.BLOCKS]
    row = ly.coupling_row(k, coupling)
    a, b = ly.coupling_a(k, coupling), ly.coupling_b(k, coupling)
    e = y[b] - ly.offset(p, row)
    rate = y[n + b]
    change = rates[n + b]
    if a >= 0:
        e = e - ly.ratio(p, row) * y[a]
        rate = rate - ly.ratio(p, row) * y[n + a]
        change = change - ly.ratio(p, row) * rates[n + a]
    side = -1.0 if e < 0.0 else 1.0
    if mode != OPEN:
        side = float(mode)
    beyond = side * e - ly.gap(p, row)
    pressed = ly.stiffness(p, row) * beyond + side * ly.damping(p, row) * rate
    gained = side * (ly.stiffness(p, row) * rate + ly.damping(p, row) * change)
    if mode != OPEN:
        return pressed, gained
    if pressed < ly.stiffness(p, row) * beyond:
        return -pressed, -gained
    return -ly.stiffness(p, row) * beyond, -ly.stiffness(p, row) * side * rate


@part_kernel
def distance_to_guard(
    k: IntVector, p: Vector, index: int, y: Vector, rates: Vector, modes: IntVector
) -> tuple[float, float]:
    """Return the quantity that the guard at `index` watches, and the rate of this quantity.

    The mode ends when the quantity is 0. The quantity depends on the kind of guard:

    moving root       speed in the direction of the mode
    open joint, stop  distance to the nearer flank or stop
    compliant flank   force of a pressed flank; stiffness times distance of an open flank

    rates (y,): rates of the state y.
    """
    n, j, c = k[ly.BLOCKS], k[ly.JOINTS], k[ly.COUPLINGS]
    if index < n:
        return modes[index] * y[n + index], modes[index] * rates[n + index]
    if n + 2 * j <= index < n + 2 * j + c:
        return _flank_left(k, p, index - n - 2 * j, y, rates, modes[index])
    if index < n + j:
        joint = index - n
        row = ly.joint_row(k, joint)
        a, b = ly.joint_a(k, joint), ly.joint_b(k, joint)
        e = y[b] - ly.ratio(p, row) * y[a] - ly.offset(p, row)
        rate = y[n + b] - ly.ratio(p, row) * y[n + a]
        return (ly.gap(p, row) + e, rate) if e < 0.0 else (ly.gap(p, row) - e, -rate)
    stop = index - n - 2 * j - c
    block, row = ly.stop_block(k, stop), ly.stop_row(k, stop)
    below = y[block] - ly.low(p, row)
    above = ly.high(p, row) - y[block]
    return (below, y[n + block]) if below < above else (above, -y[n + block])


@bare_kernel
def is_broken(
    k: IntVector, p: Vector, index: int, y: Vector, modes: IntVector, guard: Vector, begin: Vector
) -> bool:
    """Return True if the guard at `index` is passed, so that its mode ends.

    begin: guards at the beginning of the step. If the guard of an open flank or stop was below 0 at
    the beginning, the contact has just opened; the guard is then passed only if the gap is closing.
    """
    if guard[index] >= BROKEN:
        return False
    if index < k[ly.BLOCKS] or is_forced(k, modes, index) or begin[index] >= 0.0:
        return True
    _, rate = distance_to_guard(k, p, index, y, y, modes)
    return bool(rate < 0.0)


@bare_kernel
def is_any_broken(
    k: IntVector, p: Vector, y: Vector, modes: IntVector, guard: Vector, begin: Vector
) -> bool:
    """Return True if any guard is passed, so that a mode ends (`is_broken`)."""
    broken = False
    for index in range(k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS] + k[ly.STOPS]):
        broken = broken or is_broken(k, p, index, y, modes, guard, begin)
    return broken


@bare_kernel
def _lowest(g0: float, r0: float, g1: float, r1: float, h: float) -> tuple[float, float]:
    if not (r0 < 0.0 < r1):
        return (h, g1) if g1 < g0 else (0.0, g0)
    slope = (g1 - g0) / h
    a = (r0 + r1 - 2.0 * slope) / (h * h)
    b = (3.0 * slope - 2.0 * r0 - r1) / h
    root = b * b - 3.0 * a * r0
    if root < 0.0:
        return h, g1
    s = -r0 / (b + math.sqrt(root)) if b + math.sqrt(root) != 0.0 else h
    if not 0.0 < s < h:
        return h, g1
    return s, g0 + s * (r0 + s * (b + s * a))


@bare_kernel
def _dip(g0: float, r0: float, g1: float, r1: float, h: float, shortest: float) -> float:
    """Return the earlier of `shortest` and the time at which this guard may be passed [s].

    That time is the minimum of the guard within the step, if the minimum may be below the limit.
    The guard is not passed at the ends 0 and h of the step, where it has the values g0, g1 and the
    rates r0, r1. `shortest` is the earliest such minimum of the guards examined before.
    """
    if r0 >= 0.0 or r1 <= 0.0:
        return shortest
    at, value = _lowest(g0, r0, g1, r1, h)
    if 0.0 < at < shortest and value < GRAZING * (g0 - value + g1 - value):
        return at
    return shortest


@part_kernel
def first_dip(
    k: IntVector,
    p: Vector,
    h: float,
    y: Vector,
    begin: Vector,
    end: Vector,
    after: Vector,
    modes: IntVector,
    guard: Vector,
) -> float:
    """Return the first time [s] within a step at which a guard may be passed for a short time.

    The result is the length h of the step if there is no such time. The search covers the guards of
    speeds, open flanks and stops.
    """
    n, j, c = k[ly.BLOCKS], k[ly.JOINTS], k[ly.COUPLINGS]
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
        row = ly.joint_row(k, joint)
        a, b = ly.joint_a(k, joint), ly.joint_b(k, joint)
        ratio, gap = ly.ratio(p, row), ly.gap(p, row)
        e0 = y[b] - ratio * y[a] - ly.offset(p, row)
        e1 = end[b] - ratio * end[a] - ly.offset(p, row)
        r0, r1 = y[n + b] - ratio * y[n + a], end[n + b] - ratio * end[n + a]
        shortest = _dip(e0 + gap, r0, e1 + gap, r1, h, shortest)
        shortest = _dip(gap - e0, -r0, gap - e1, -r1, h, shortest)
    for s in range(k[ly.STOPS]):
        if modes[n + 2 * j + c + s] != OPEN:
            continue
        block, row = ly.stop_block(k, s), ly.stop_row(k, s)
        if ly.low(p, row) > -math.inf:
            shortest = _dip(
                y[block] - ly.low(p, row),
                y[n + block],
                end[block] - ly.low(p, row),
                end[n + block],
                h,
                shortest,
            )
        if ly.high(p, row) < math.inf:
            shortest = _dip(
                ly.high(p, row) - y[block],
                -y[n + block],
                ly.high(p, row) - end[block],
                -end[n + block],
                h,
                shortest,
            )
    return shortest
