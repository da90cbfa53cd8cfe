"""Ranges of the forces in a tree of joints at rest, and load directions of self-locking joints.

The functions are used by tree_solver.py.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import workspace_rows as rows
from frictool.engine.mechanism.acceleration_graph import JointTree
from frictool.engine.mechanism.guard_tolerances import slack_at
from frictool.engine.mechanism.joint_losses import (
    is_self_locking,
    kink_of,
    range_at_driver,
    range_at_load,
)
from frictool.runtime.kernels import bare_kernel
from frictool.typing import IntVector, Vector


@bare_kernel
def gather_rest(tree: JointTree, sided: bool, towards: float) -> bool:
    """Fill NEED and NEED_HIGH with the range of the force that keeps each block at rest.

    Return False if the range of a self-locking joint is not on the side that `sided` requires.

    sided: True to restrict the load of each self-locking joint to one side of its kink (force at
    which the slope of the loss changes). The branch of the joint (state.py) selects the side. For
    branch 0, the load must be at the kink if `towards` is 0. If `towards` is 1 or -1, the root
    moves in this direction. The load must then be on the side on which the driving end of the joint
    drives the load.
    """
    k, p, modes, members, _, w = tree
    n = k[ly.BLOCKS]
    branches = k[ly.BLOCKS] + k[ly.JOINTS]
    exists = True
    for m in range(members.size):
        i = ly.block_at(k, members[m])
        w[rows.NEED, i], w[rows.NEED_HIGH, i] = (
            -w[rows.FORCE, i] + w[rows.HOLD_LOW, i],
            -w[rows.FORCE, i] + w[rows.HOLD_HIGH, i],
        )
        if w[rows.STOPPED_LOW, i] > 0.0:
            w[rows.NEED, i] = -math.inf
        if w[rows.STOPPED_HIGH, i] > 0.0:
            w[rows.NEED_HIGH, i] = math.inf
    for m in range(members.size - 1, 0, -1):
        i = ly.block_at(k, members[m])
        joint, parent = ly.joint_of(k, i), ly.parent_of(k, i)
        row = ly.joint_row(k, joint)
        contact = modes[n + joint]
        low, high = w[rows.NEED, i], w[rows.NEED_HIGH, i]
        outward = ly.outward(k, i) == 1
        if not outward:
            low, high = range_at_load(p, row, kink_of(p, row, w[rows.DRIVEN, i]), -high, -low)
        if contact == -1:
            low, high = max(0.0, low), max(0.0, high)
        elif contact == 1:
            low, high = min(0.0, low), min(0.0, high)
        if outward:
            kink = kink_of(p, row, w[rows.DRIVEN, parent])
            if sided and is_self_locking(p, row):
                side = modes[branches + joint]
                if side == 0 and towards != 0.0:
                    side = 1 if ly.ratio(p, row) * w[rows.ALONG, parent] * towards > 0.0 else -1
                slack = slack_at(k, p, w, i)
                exists = (
                    exists
                    and not (side > 0 and high < kink - slack)
                    and not (side < 0 and low > kink + slack)
                )
                if side >= 0:
                    low, high = max(low, kink), max(high, kink)
                if side <= 0:
                    low, high = min(low, kink), min(high, kink)
            low, high = range_at_driver(p, row, kink, low, high)
        else:
            low, high = -high, -low
        w[rows.NEED, parent] += low
        w[rows.NEED_HIGH, parent] += high
    return exists


@bare_kernel
def force_at_rest(k: IntVector, p: Vector, i: int, w: Vector) -> tuple[float, float, float]:
    """Return (low, high, tolerance) of the force that a block at rest needs from its joint.

    The force is the force at the load end of the joint; the loss of the joint is neglected.
    """
    ratio = ly.ratio(p, ly.joint_row(k, ly.joint_of(k, i)))
    low = w[rows.NEED, i]
    high = w[rows.NEED_HIGH, i]
    slack = slack_at(k, p, w, i)
    if ly.outward(k, i) == 0:
        low, high, slack = -high / ratio, -low / ratio, slack / abs(ratio)
        if ratio < 0.0:
            low, high = high, low
    return low, high, slack


@bare_kernel
def side_at_rest(k: IntVector, p: Vector, i: int, w: Vector) -> int:
    """Return the side on which the joint of a block at rest is loaded.

    The result is 1 for forces above the kink of the joint's loss, and -1 for forces below. If
    friction beyond the joint can carry the load, both sides are possible and the result is 0.
    """
    low, high, slack = force_at_rest(k, p, i, w)
    row = ly.joint_row(k, ly.joint_of(k, i))
    kink = kink_of(p, row, w[rows.DRIVEN, ly.parent_of(k, i) if ly.outward(k, i) == 1 else i])
    return 1 if low > kink + slack else -1 if high < kink - slack else 0


@bare_kernel
def breakaway_at_rest(k: IntVector, p: Vector, root: int, w: Vector) -> float:
    """Return the direction in which a tree at rest breaks away, 0 if it stays at rest.

    The rows NEED and NEED_HIGH must be filled.
    """
    slack = slack_at(k, p, w, root)
    if w[rows.NEED_HIGH, root] < -slack:
        return 1.0
    return -1.0 if w[rows.NEED, root] > slack else 0.0


@bare_kernel
def unload(tree: JointTree) -> bool:
    """Clear the branch of each self-locking joint whose load is not on that side of the kink.

    The tree must be at rest. Returns True if the tree has self-locking joints.
    """
    k, p, modes, members, _, w = tree
    n = k[ly.BLOCKS]
    j = k[ly.JOINTS]
    any_locks = False
    for m in range(1, members.size):
        i = ly.block_at(k, members[m])
        joint = ly.joint_of(k, i)
        if is_self_locking(p, ly.joint_row(k, joint)):
            any_locks = True
            if side_at_rest(k, p, i, w) != modes[n + j + joint]:
                modes[n + j + joint] = 0
    return any_locks


@bare_kernel
def stays_loaded(tree: JointTree, towards: float) -> bool:
    """Return True if a tree can rest with the present load directions of its self-locking joints.

    towards: as in `gather_rest`.
    """
    k, p, _, members, _, w = tree
    exists = gather_rest(tree, True, towards)
    return exists and breakaway_at_rest(k, p, ly.block_at(k, members[0]), w) == 0.0
