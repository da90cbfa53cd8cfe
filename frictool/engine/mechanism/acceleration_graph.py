"""Force Lambda(x) that a tree of joints needs for an acceleration x of its root; zeros of Lambda.

Lambda includes all efforts on the blocks of the tree; the true acceleration is therefore a zero of
Lambda. Lambda is piecewise linear (engine/mechanism/tree_solver.py).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import workspace_rows as rows
from frictool.engine.mechanism.joint_losses import (
    is_lossy,
    kink_of,
    received,
    slope_of,
    transmitted,
)
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

MAX_PIECES = 200  # largest number of linear pieces that a search visits
FOUND = 1e-13  # tolerance of a zero, relative to the efforts
PASSED = 1e-9  # overshoot of a search step beyond the end of a piece, relative to the step


class JointTree(NamedTuple):
    """Tree of blocks that rigid joints and closed contacts connect, with work arrays.

    - k, p: integers and floats of the compiled mechanism (array_layout.py)
    - members: the tree's blocks, root first, as indices in section ORDER
    - modes, y: arrays of a `MechanismState` (state.py)
    - w: work array (workspace_rows.py)
    """

    k: IntVector
    p: Vector
    modes: IntVector
    members: IntVector
    y: Vector
    w: Vector


@part_kernel
def evaluate(tree: JointTree, x: float, towards: float) -> None:
    """Fill the rows VALUE and SLOPE of the work array for the acceleration x of the root.

    VALUE of a block is the force that the block's subtree needs; SLOPE is the derivative of VALUE
    with respect to x. towards: direction of the root's motion if the root starts from rest, 0 if
    the root moves already.
    """
    k, p, modes, members, y, w = tree
    n = k[ly.BLOCKS]
    for m in range(members.size):
        i = ly.block_at(k, members[m])
        mass = ly.mass_of(k, p, i)
        w[rows.VALUE, i], w[rows.SLOPE, i] = (
            mass * w[rows.ALONG, i] * x - w[rows.FORCE, i],
            mass * w[rows.ALONG, i],
        )
        direction = towards * w[rows.ALONG, i]
        if direction > 0.0:
            w[rows.VALUE, i] += w[rows.AHEAD, i]
            if w[rows.STOPPED_HIGH, i] > 0.0:
                w[rows.VALUE, i] = math.inf
        elif direction < 0.0:
            w[rows.VALUE, i] -= w[rows.BEHIND, i]
            if w[rows.STOPPED_LOW, i] > 0.0:
                w[rows.VALUE, i] = -math.inf
    for m in range(members.size - 1, 0, -1):
        i = ly.block_at(k, members[m])
        joint, parent = ly.joint_of(k, i), ly.parent_of(k, i)
        row = ly.joint_row(k, joint)
        contact = modes[n + joint]
        outward = ly.outward(k, i) == 1
        ratio = ly.ratio(p, row)
        a = parent if outward else i
        direction = math.copysign(1.0, towards * w[rows.ALONG, a] if towards != 0.0 else y[n + a])
        force, slope = w[rows.VALUE, i], w[rows.SLOPE, i]
        if is_lossy(p, row):
            kink = kink_of(p, row, w[rows.DRIVEN, a])
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
        w[rows.VALUE, parent] += force
        w[rows.SLOPE, parent] += slope


@bare_kernel
def solve(tree: JointTree, towards: float, gross: float) -> tuple[bool, float]:
    """Return (True, x) with Lambda(x) = 0, or (False, x) if no zero is found at which Lambda rises.

    Lambda(x) is the force that the tree needs for the acceleration x of its root.

    - towards: direction in which a root at rest starts, so that x * towards >= 0; 0 for a moving
      root
    - gross: sum of the magnitudes of the efforts, as scale of rounding errors
    """
    k, members, w = tree.k, tree.members, tree.w
    root = ly.block_at(k, members[0])
    x = 0.0
    low = -math.inf
    high = math.inf
    if towards > 0.0:
        low = 0.0
    elif towards < 0.0:
        high = 0.0
    for _ in range(MAX_PIECES):
        evaluate(tree, x, towards)
        value, slope = w[rows.VALUE, root], w[rows.SLOPE, root]
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


@bare_kernel
def next_piece(tree: JointTree, x: float, towards: float, going: float) -> float:
    """Return the distance from x, in the direction `going`, to the next change of Lambda's slope.

    Lambda(x) is the force that the tree needs for the root's acceleration x. Its slope changes
    where the force of a joint passes the kink of the loss (joint_losses.py), or the force of a
    flank passes 0.
    """
    k, p, _, members, y, w = tree
    n = k[ly.BLOCKS]
    nearest = math.inf
    for m in range(1, members.size):
        i = ly.block_at(k, members[m])
        value, slope = w[rows.VALUE, i], w[rows.SLOPE, i]
        if slope == 0.0 or not math.isfinite(value):
            continue
        joint = ly.joint_of(k, i)
        outward = ly.outward(k, i) == 1
        row = ly.joint_row(k, joint)
        a = ly.parent_of(k, i) if outward else i
        kink = kink_of(p, row, w[rows.DRIVEN, a]) if is_lossy(p, row) else 0.0
        direction = math.copysign(1.0, towards * w[rows.ALONG, a] if towards != 0.0 else y[n + a])
        rounding = FOUND * (w[rows.GROSS, i] + abs(slope * x))
        for end in range(2):
            force = kink if end == 0 else 0.0
            if not outward:
                force = -transmitted(p, row, kink, direction, force)
            distance = going * (force - value) / slope
            if distance > 0.0 and abs(force - value) > rounding:
                nearest = min(nearest, distance)
    return nearest


@bare_kernel
def total_inertia(tree: JointTree) -> float:
    """Return the inertia of all blocks of the tree, reflected to the root; losses are neglected."""
    k, p, _, members, _, w = tree
    inertia = 0.0
    for m in range(members.size):
        i = ly.block_at(k, members[m])
        inertia += ly.mass_of(k, p, i) * w[rows.ALONG, i] * w[rows.ALONG, i]
    return inertia


@bare_kernel
def follow(tree: JointTree, start: float, towards: float, gross: float) -> tuple[bool, float]:
    """Return (True, zero of Lambda that x reaches from `start`), or (False, x) if x diverges.

    Lambda(x) is the force that the tree needs for the root's acceleration x. x moves in the
    direction of -Lambda(x) to a zero at which Lambda rises, as it would if the links were slightly
    compliant and damped.
    """
    k, members, w = tree.k, tree.members, tree.w
    root = ly.block_at(k, members[0])
    inertia = total_inertia(tree)
    evaluate(tree, start, towards)
    # slightly beyond the end of a piece, onto the piece to which x moves
    x = start - PASSED * w[rows.VALUE, root] / inertia
    for _ in range(MAX_PIECES):
        evaluate(tree, x, towards)
        value, slope = w[rows.VALUE, root], w[rows.SLOPE, root]
        if not math.isfinite(value):
            return False, x
        if abs(value) <= FOUND * gross and slope > 0.0:
            return True, x
        going = -math.copysign(1.0, value)
        length = next_piece(tree, x, towards, going)
        if slope > 0.0 and abs(value) <= slope * length:
            after = x - value / slope
            if after == x:
                return True, x
            x = after
        elif math.isinf(length):
            return False, x
        else:
            x += going * (length * (1.0 + PASSED) + PASSED * FOUND * abs(x))
    return False, x
