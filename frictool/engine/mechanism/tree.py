"""One tree of joints, with all contacts that touch, solved at once.

It hands to its root one function: Lambda(x), the effort that it needs to have the acceleration x at the root. Through a rigid joint the
child has the acceleration ratio x; through a flank that can only push, the child's need counts where it is a push,
max(0, Lambda_child(ratio x)), and where it is none the child is left behind. Each step keeps Lambda a rising, piecewise linear graph: m x
rises, Coulomb's friction at rest is a vertical piece at x = 0, the loss of a link that its load can drive rises with the force. So
0 = Lambda(x) has one solution, and it is the motion that Gauss's principle of least constraint picks among those that the contacts allow
(Moreau 1966; the graph is the subdifferential of a convex function of the accelerations): no order in which contacts are asked can change
it. A tree at rest whose interval Lambda(0) holds 0 stays at rest.

Breakaway above Coulomb's friction makes the graph fall back at x = 0: what can stay at rest then does, and what cannot starts with its
friction in slip. A link that its load cannot drive makes it fall too; where no x with a rising graph is left, the tree jams (Painleve).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.image import (
    BLOCKS,
    DRY,
    JOINTS,
    MASS,
    ORDER,
    OUTWARD,
    PARENT,
    PARENT_JOINT,
    RATIO,
    SPAN,
)
from frictool.engine.mechanism.margins import SLACK, slack_at
from frictool.engine.mechanism.state import FREE, OPEN, STUCK
from frictool.engine.mechanism.transmission import (
    is_lossy,
    joint_row,
    kink_of,
    range_at_driver,
    range_at_load,
    received,
    slope_of,
    transmitted,
)
from frictool.engine.mechanism.work_rows import (
    ACCELERATION,
    AHEAD,
    ALONG,
    BEHIND,
    DRIVEN,
    FORCE,
    GROSS,
    HOLD_HIGH,
    HOLD_LOW,
    NEED,
    NEED_HIGH,
    SLOPE,
    STOPPED_HIGH,
    STOPPED_LOW,
    VALUE,
)
from frictool.engine.status import JAMMED, OK
from frictool.kernels import inset_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

MAX_PIECES = 200  # of the graph that a search may visit
FOUND = 1e-13  # of the efforts


@inset_kernel
def _members(k: Places, modes: Places, place: int, found: Places) -> int:
    """Places in the order of all blocks that closed contacts and rigid joints bind to the root at `place`; their number."""
    n, count = k[BLOCKS], 0
    at, end = place, place + k[k[SPAN] + k[k[ORDER] + place]]
    while at < end:
        i = k[k[ORDER] + at]
        joint = k[k[PARENT_JOINT] + i]
        if at > place and modes[n + joint] == OPEN:
            at += k[k[SPAN] + i]
            continue
        found[count] = at
        count += 1
        at += 1
    return count


@inset_kernel
def _spread_ratios(k: Places, p: Vector, found: Places, count: int, w: Vector) -> None:
    """ALONG: each block's speed per unit of the root's."""
    for m in range(count):
        i = k[k[ORDER] + found[m]]
        if m == 0:
            w[ALONG, i] = 1.0
            continue
        ratio = p[joint_row(k, k[k[PARENT_JOINT] + i]) + RATIO]
        w[ALONG, i] = w[ALONG, k[k[PARENT] + i]] * (ratio if k[k[OUTWARD] + i] == 1 else 1.0 / ratio)


@inset_kernel
def _gather_rest(k: Places, p: Vector, modes: Places, found: Places, count: int, w: Vector) -> None:
    """NEED, NEED_HIGH: Lambda(0) of all members."""
    n = k[BLOCKS]
    for m in range(count):
        i = k[k[ORDER] + found[m]]
        w[NEED, i], w[NEED_HIGH, i] = -w[FORCE, i] + w[HOLD_LOW, i], -w[FORCE, i] + w[HOLD_HIGH, i]
        if w[STOPPED_LOW, i] > 0.0:
            w[NEED, i] = -math.inf
        if w[STOPPED_HIGH, i] > 0.0:
            w[NEED_HIGH, i] = math.inf
    for m in range(count - 1, 0, -1):
        i = k[k[ORDER] + found[m]]
        joint, parent = k[k[PARENT_JOINT] + i], k[k[PARENT] + i]
        row, contact = joint_row(k, joint), modes[n + joint]
        low, high = w[NEED, i], w[NEED_HIGH, i]
        outward = k[k[OUTWARD] + i] == 1
        if not outward:
            low, high = range_at_load(p, row, kink_of(p, row, w[DRIVEN, i]), -high, -low)
        if contact == -1:
            low, high = max(0.0, low), max(0.0, high)
        elif contact == 1:
            low, high = min(0.0, low), min(0.0, high)
        if outward:
            low, high = range_at_driver(p, row, kink_of(p, row, w[DRIVEN, parent]), low, high)
        else:
            low, high = -high, -low
        w[NEED, parent] += low
        w[NEED_HIGH, parent] += high


@part_kernel
def _evaluate(k: Places, p: Vector, modes: Places, found: Places, count: int, x: float, towards: float, y: Vector, w: Vector) -> None:
    """VALUE, SLOPE by x: Lambda(x) of all members; `towards`: the root's direction where it starts from rest, 0 where it moves."""
    n = k[BLOCKS]
    for m in range(count):
        i = k[k[ORDER] + found[m]]
        mass = p[k[MASS] + i]
        w[VALUE, i], w[SLOPE, i] = mass * w[ALONG, i] * x - w[FORCE, i], mass * w[ALONG, i]
        direction = towards * w[ALONG, i]
        if direction > 0.0:
            w[VALUE, i] += w[AHEAD, i]
            if w[STOPPED_HIGH, i] > 0.0:
                w[VALUE, i] = math.inf
        elif direction < 0.0:
            w[VALUE, i] -= w[BEHIND, i]
            if w[STOPPED_LOW, i] > 0.0:
                w[VALUE, i] = -math.inf
    for m in range(count - 1, 0, -1):
        i = k[k[ORDER] + found[m]]
        joint, parent = k[k[PARENT_JOINT] + i], k[k[PARENT] + i]
        row, contact = joint_row(k, joint), modes[n + joint]
        outward, ratio = k[k[OUTWARD] + i] == 1, p[row + RATIO]
        a = parent if outward else i
        direction = math.copysign(1.0, towards * w[ALONG, a] if towards != 0.0 else y[n + a])
        force, slope = w[VALUE, i], w[SLOPE, i]
        if is_lossy(p, row):
            kink = kink_of(p, row, w[DRIVEN, a])
            if not outward:
                force = received(p, row, kink, direction, -force)
                slope = -slope / slope_of(p, row, direction, force > kink)
            pulls = (contact == -1 and force < 0.0) or (contact == 1 and force > 0.0)
            if pulls:
                force, slope = 0.0, 0.0
            if outward:
                slope *= slope_of(p, row, direction, force > kink)
                force = transmitted(p, row, kink, direction, force)
        else:
            if not outward:
                force, slope = -force / ratio, -slope / ratio
            if (contact == -1 and force < 0.0) or (contact == 1 and force > 0.0):
                force, slope = 0.0, 0.0
            if outward:
                force, slope = ratio * force, ratio * slope
        if not outward:
            force, slope = -force, -slope
        w[VALUE, parent] += force
        w[SLOPE, parent] += slope


@inset_kernel
def _solve(
    k: Places, p: Vector, modes: Places, found: Places, count: int, towards: float, gross: float, y: Vector, w: Vector
) -> tuple[bool, float]:
    """The x with Lambda(x) = 0 (x * towards >= 0 from rest); False where the graph does not rise there."""
    root = k[k[ORDER] + found[0]]
    x, low, high = 0.0, -math.inf, math.inf
    if towards > 0.0:
        low = 0.0
    elif towards < 0.0:
        high = 0.0
    for _ in range(MAX_PIECES):
        _evaluate(k, p, modes, found, count, x, towards, y, w)
        value, slope = w[VALUE, root], w[SLOPE, root]
        if abs(value) <= FOUND * gross or value == 0.0:
            return slope > 0.0, x
        if value > 0.0:
            high = min(high, x)
        else:
            low = max(low, x)
        if low >= high:
            return slope > 0.0 and towards != 0.0 and x == 0.0, x
        after = x - value / slope if slope > 0.0 else math.nan
        if not low < after < high:
            if math.isinf(low) or math.isinf(high):
                if slope <= 0.0:
                    return False, x
                after = x - value / slope
            else:
                after = 0.5 * (low + high)
        if after == x:
            return slope > 0.0, x
        x = after
    return False, x


@inset_kernel
def _force_at_rest(k: Places, p: Vector, i: int, w: Vector) -> tuple[float, float, float]:
    """What a member at rest needs from its joint, lowest and highest, and the slack there."""
    ratio = p[joint_row(k, k[k[PARENT_JOINT] + i]) + RATIO]
    low, high, slack = w[NEED, i], w[NEED_HIGH, i], slack_at(k, p, w, i)
    if k[k[OUTWARD] + i] == 0:
        low, high, slack = -high / ratio, -low / ratio, slack / abs(ratio)
        if ratio < 0.0:
            low, high = high, low
    return low, high, slack


@inset_kernel
def _force_in_motion(k: Places, p: Vector, i: int, x: float, towards: float, y: Vector, w: Vector) -> tuple[float, float, float]:
    """lambda of a moving member's joint, the kink of that joint, and the slack there."""
    n, row, outward = k[BLOCKS], joint_row(k, k[k[PARENT_JOINT] + i]), k[k[OUTWARD] + i] == 1
    a = k[k[PARENT] + i] if outward else i
    direction = math.copysign(1.0, towards * w[ALONG, a] if towards != 0.0 else y[n + a])
    kink, force = kink_of(p, row, w[DRIVEN, a]), w[VALUE, i]
    if not outward:
        force = received(p, row, kink, direction, -force)
    slack = slack_at(k, p, w, i) + SLACK * abs(w[SLOPE, i] * x)
    return force, kink, slack if outward else slack / abs(p[row + RATIO])


@inset_kernel
def _bind(k: Places, p: Vector, modes: Places, i: int, x: float, towards: float, rests: bool, y: Vector, w: Vector) -> None:
    """Sets the side of its kink on which a member's joint is, and opens a flank that would pull."""
    n, j, joint = k[BLOCKS], k[JOINTS], k[k[PARENT_JOINT] + i]
    if rests:
        low, high, slack = _force_at_rest(k, p, i, w)
    else:
        force, kink, slack = _force_in_motion(k, p, i, x, towards, y, w)
        low = high = force
        modes[n + j + joint] = 1 if force > kink else -1
    if (modes[n + joint] == -1 and high < -slack) or (modes[n + joint] == 1 and low > slack):
        modes[n + joint] = OPEN


@inset_kernel
def _set_motions(
    k: Places, p: Vector, modes: Places, found: Places, count: int, x: float, towards: float, rests: bool, y: Vector, w: Vector
) -> None:
    """Opens the flanks that would pull, sets the sides of kinks, motions and accelerations of the members."""
    n, dry, left = k[BLOCKS], False, 0
    for m in range(count):
        dry = dry or k[k[DRY] + k[k[ORDER] + found[m]]] == 1
    for m in range(count):
        i = k[k[ORDER] + found[m]]
        if found[m] < left:
            continue
        if m > 0:
            _bind(k, p, modes, i, x, towards, rests, y, w)
            if modes[n + k[k[PARENT_JOINT] + i]] == OPEN:
                left = found[m] + k[k[SPAN] + i]
                continue
        along = w[ALONG, i]
        w[ACCELERATION, i] = along * x
        if rests:
            modes[i] = STUCK
        elif not dry:
            modes[i] = FREE
        elif towards != 0.0:
            modes[i] = 1 if towards * along > 0.0 else -1
        else:
            modes[i] = 1 if y[n + i] > 0.0 else -1


@part_kernel
def solve_tree(k: Places, p: Vector, modes: Places, place: int, found: Places, y: Vector, w: Vector) -> int:
    """Sets the modes of the tree whose root is at `place` in the order, up to its open contacts; engine/status.py."""
    n = k[BLOCKS]
    count = _members(k, modes, place, found)
    _spread_ratios(k, p, found, count, w)
    root = k[k[ORDER] + place]
    dry, gross = False, 0.0
    for m in range(count):
        i = k[k[ORDER] + found[m]]
        dry = dry or k[k[DRY] + i] == 1 or w[STOPPED_LOW, i] > 0.0 or w[STOPPED_HIGH, i] > 0.0
    for m in range(count - 1, -1, -1):
        i = k[k[ORDER] + found[m]]
        if m > 0:
            w[GROSS, k[k[PARENT] + i]] += w[GROSS, i] * abs(w[ALONG, i] / w[ALONG, k[k[PARENT] + i]])
        else:
            gross = w[GROSS, i]
    towards = 0.0
    if dry and y[n + root] == 0.0:
        _gather_rest(k, p, modes, found, count, w)
        slack = slack_at(k, p, w, root)
        low, high = w[NEED, root], w[NEED_HIGH, root]
        if low <= slack and high >= -slack:
            _set_motions(k, p, modes, found, count, 0.0, 0.0, True, y, w)
            return OK
        towards = 1.0 if high < -slack else -1.0
    solved, x = _solve(k, p, modes, found, count, towards, gross, y, w)
    if not solved:
        return JAMMED
    _set_motions(k, p, modes, found, count, x, towards, False, y, w)
    return OK
