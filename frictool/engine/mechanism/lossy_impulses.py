"""How a group of rigidly joined blocks yields to an impulse that its joints pass with loss.

A loss is proportional to the force that a joint passes, so it takes its part of an impulse too,
however short: the impulse grows from zero (Routh 1860), and by each bit of it the group's motion
changes as by a force, with the losses' signs by the motion that is left. Finite forces do nothing
meanwhile. Between the instants at which a motion ends the change per unit of impulse is constant,
and it is the solution of Lambda(x) = 0 (engine/mechanism/contact_resolution.py) with the impulse
for the only effort. A group at rest that its friction locks stays.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.compiled_mechanism import (
    BLOCKS,
    GROUP,
    GROUP_MASS,
    GROUP_RATIO,
    JOINT_ENDS,
    JOINTS,
    MASS,
    ORDER,
    OUTWARD,
    PARENT,
    PARENT_JOINT,
)
from frictool.engine.mechanism.joint_losses import (
    is_lossy,
    joint_row,
    received,
    slope_of,
    transmitted,
)
from frictool.engine.mechanism.workspace_rows import SLOPE, VALUE
from frictool.runtime.kernels import inset_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

MAX_PIECES = 200  # of the graph that a search may visit
FOUND = 1e-14  # of the impulse


@inset_kernel
def is_group_lossy(k: Places, p: Vector, group: int) -> bool:
    """Whether a rigid joint inside the group takes power."""
    for joint in range(k[JOINTS]):
        row = joint_row(k, joint)
        if is_lossy(p, row):
            a, b = k[k[JOINT_ENDS] + 2 * joint], k[k[JOINT_ENDS] + 2 * joint + 1]
            if k[k[GROUP] + a] == group and k[k[GROUP] + b] == group:
                return True
    return False


@part_kernel
def _need(
    k: Places,
    p: Vector,
    group: int,
    block: int,
    impulse: float,
    towards: float,
    x: float,
    w: Vector,
) -> None:
    """VALUE, SLOPE by x of the group's first block: what it takes to change by x per unit, under
    `impulse` on `block`."""
    n = k[BLOCKS]
    for i in range(n):
        if k[k[GROUP] + i] == group:
            along = p[k[GROUP_RATIO] + i] * p[k[MASS] + i]
            w[VALUE, i], w[SLOPE, i] = along * x, along
    w[VALUE, block] -= impulse
    for place in range(n - 1, -1, -1):
        i = k[k[ORDER] + place]
        if k[k[GROUP] + i] != group or i == group:
            continue
        parent, row = k[k[PARENT] + i], joint_row(k, k[k[PARENT_JOINT] + i])
        if k[k[OUTWARD] + i] == 1:
            direction = math.copysign(1.0, towards * p[k[GROUP_RATIO] + parent])
            force = w[VALUE, i]
            w[SLOPE, parent] += w[SLOPE, i] * slope_of(p, row, direction, force > 0.0)
            w[VALUE, parent] += transmitted(p, row, 0.0, direction, force)
        else:
            direction = math.copysign(1.0, towards * p[k[GROUP_RATIO] + i])
            force = received(p, row, 0.0, direction, -w[VALUE, i])
            w[SLOPE, parent] += w[SLOPE, i] / slope_of(p, row, direction, force > 0.0)
            w[VALUE, parent] -= force


@inset_kernel
def _search(
    k: Places,
    p: Vector,
    group: int,
    block: int,
    impulse: float,
    towards: float,
    start: float,
    w: Vector,
) -> float:
    """The x where what it takes is nothing; nan where the graph does not rise there."""
    low, high, x = -math.inf, math.inf, start
    for _ in range(MAX_PIECES):
        _need(k, p, group, block, impulse, towards, x, w)
        value, slope = w[VALUE, group], w[SLOPE, group]
        if abs(value) <= FOUND * abs(impulse * p[k[GROUP_RATIO] + block]):
            return x if slope > 0.0 else math.nan
        if value > 0.0:
            high = min(high, x)
        else:
            low = max(low, x)
        after = x - value / slope if slope > 0.0 else math.nan
        if not low < after < high:
            if math.isinf(low) or math.isinf(high):
                return math.nan
            after = 0.5 * (low + high)
        if after == x:
            return x if slope > 0.0 else math.nan
        x = after
    return math.nan


@inset_kernel
def _by_direction(
    k: Places,
    p: Vector,
    group: int,
    block: int,
    row: int,
    force: float,
    towards: float,
    lossy: bool,
    w: Vector,
) -> float:
    """The change of the speed of the group's first block per unit, while it moves `towards`; nan
    where it jams."""
    impulse = force
    if row >= 0:
        direction = math.copysign(1.0, towards * p[k[GROUP_RATIO] + block])
        impulse = -force * slope_of(p, row, direction, force > 0.0)
    free = impulse * p[k[GROUP_RATIO] + block] / p[k[GROUP_MASS] + group]
    if not lossy or impulse == 0.0:
        return float(free)
    x = _search(k, p, group, block, impulse, towards, free, w)
    return _search(k, p, group, block, impulse, towards, 0.0, w) if math.isnan(x) else x


@part_kernel
def yielding(
    k: Places,
    p: Vector,
    group: int,
    block: int,
    row: int,
    force: float,
    speed: float,
    lossy: bool,
    w: Vector,
) -> float:
    """The change of the speed of the group's first block per unit of impulse, now that it is
    `speed`; nan where the group jams.

    force: +-1, on `block`; where `row` is a joint's, force is on the joint's far end b, and `block`
    is its a. lossy: is_group_lossy.
    """
    if speed != 0.0:
        return _by_direction(k, p, group, block, row, force, math.copysign(1.0, speed), lossy, w)
    for side in range(2):
        towards = 2.0 * side - 1.0
        x = _by_direction(k, p, group, block, row, force, towards, lossy, w)
        if x * towards > 0.0:
            return x
    return 0.0
