"""Simultaneous solution of one tree of joints with all its touching contacts.

The method is dynamic programming on Gauss's principle, as in Vereshchagin (1974); without contacts
it is the articulated-body recursion of articulated_body.py. Each subtree is described by one
function: Lambda(x), the effort that the subtree needs for the acceleration x of its root. If the
root's acceleration is x, the child of a rigid joint accelerates with x times the ratio. A flank can
only push: a child in contact adds max(0, Lambda_child(ratio x)), and separates if this is 0.

In each step of the recursion, Lambda is a rising, piecewise linear graph: the sum of the inertial
force m x, the Coulomb friction at rest, and the losses of back-drivable links. Coulomb friction is
a vertical piece at x = 0; the losses rise with the force. Lambda(x) = 0 therefore has one solution,
independent of the order of contacts. Among all motions that the contacts allow, this solution is
the motion of least constraint (Gauss; Moreau 1966): Lambda is the subdifferential of a convex
function of the accelerations. A tree at rest stays at rest if the interval Lambda(0) contains 0.

If the breakaway is above the Coulomb friction, the graph falls at x = 0. Then a tree that can stay
at rest stays at rest; any other tree starts to move with its friction in slip.

With a self-locking link the graph may also fall, so that Lambda(x) = 0 may have several solutions,
or none (Painleve's paradox). Then `follow` and `_leaves_unloaded` choose the solution that a stiff
link with damping would reach.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.acceleration_graph import (
    FOUND,
    MAX_PIECES,
    PASSED,
    JointTree,
    evaluate,
    follow,
    next_piece,
    solve,
    total_inertia,
)
from frictool.engine.mechanism.guard_tolerances import SLACK, slack_at
from frictool.engine.mechanism.joint_losses import is_self_locking, kink_of, received
from frictool.engine.mechanism.state import FREE, OPEN, STUCK
from frictool.engine.mechanism.static_forces import (
    breakaway_at_rest,
    force_at_rest,
    gather_rest,
    side_at_rest,
    stays_loaded,
    unload,
)
from frictool.engine.mechanism.workspace_rows import (
    ACCELERATION,
    ALONG,
    DRIVEN,
    GROSS,
    SLOPE,
    STOPPED_HIGH,
    STOPPED_LOW,
    VALUE,
)
from frictool.engine.status_codes import JAMMED, OK
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector


@bare_kernel
def _members(k: IntVector, modes: IntVector, index: int, members: IntVector) -> int:
    n = k[ly.BLOCKS]
    count = 0
    at = index
    end = index + ly.span_of(k, ly.block_at(k, index))
    while at < end:
        i = ly.block_at(k, at)
        joint = ly.joint_of(k, i)
        if at > index and modes[n + joint] == OPEN:
            at += ly.span_of(k, i)
            continue
        members[count] = at
        count += 1
        at += 1
    return count


@bare_kernel
def _spread_ratios(tree: JointTree) -> None:
    k, p, _, members, _, w = tree
    for m in range(members.size):
        i = ly.block_at(k, members[m])
        if m == 0:
            w[ALONG, i] = 1.0
            continue
        ratio = ly.ratio(p, ly.joint_row(k, ly.joint_of(k, i)))
        w[ALONG, i] = w[ALONG, ly.parent_of(k, i)] * (
            ratio if ly.outward(k, i) == 1 else 1.0 / ratio
        )


@bare_kernel
def _leaves_unloaded(tree: JointTree, gross: float) -> tuple[bool, float, float]:
    """Return (leaves, direction, acceleration) of a resting tree with unloaded self-locking joints.

    An unloaded self-locking joint cannot hold the driving end, which slips under any effort. The
    slip ends immediately if the driving end then drives the load.

    - leaves: True if the tree starts to move
    - direction, acceleration: values of the root
    """
    k, p, _, members, _, w = tree
    if stays_loaded(tree, 0.0):
        return False, 0.0, 0.0
    gather_rest(tree, False, 0.0)
    if not unload(tree):
        return False, 0.0, 0.0
    gather_rest(tree, True, 0.0)
    towards = breakaway_at_rest(k, p, ly.block_at(k, members[0]), w)
    if towards == 0.0 or stays_loaded(tree, towards):
        return False, 0.0, 0.0
    x = towards * PASSED * gross / total_inertia(tree)
    for _ in range(MAX_PIECES):  # up to the piece in which all joints drive
        evaluate(tree, x, towards)
        length = next_piece(tree, x, towards, towards)
        if math.isinf(length):
            break
        x += towards * (length * (1.0 + PASSED) + PASSED * FOUND * abs(x))
    solved, x = follow(tree, x, towards, gross)
    return solved and x * towards > 0.0, towards, x


@bare_kernel
def _jammed(tree: JointTree) -> int:
    """Return the index in section ORDER of the first jammed block (effective inertia <= 0).

    Contacts that would pull are treated as open. The effective inertia includes losses.
    """
    k, _, modes, members, _, w = tree
    n = k[ly.BLOCKS]
    for m in range(members.size - 1, 0, -1):
        i = ly.block_at(k, members[m])
        if modes[n + ly.joint_of(k, i)] == OPEN and w[SLOPE, i] * w[ALONG, i] <= 0.0:
            return int(members[m])
    return int(members[0])


@bare_kernel
def _force_in_motion(
    tree: JointTree, i: int, x: float, towards: float
) -> tuple[float, float, float]:
    k, p, _, _, y, w = tree
    n = k[ly.BLOCKS]
    row = ly.joint_row(k, ly.joint_of(k, i))
    outward = ly.outward(k, i) == 1
    a = ly.parent_of(k, i) if outward else i
    direction = math.copysign(1.0, towards * w[ALONG, a] if towards != 0.0 else y[n + a])
    kink = kink_of(p, row, w[DRIVEN, a])
    force = w[VALUE, i]
    if not outward:
        force = received(p, row, kink, direction, -force)
    slack = slack_at(k, p, w, i) + SLACK * abs(w[SLOPE, i] * x)
    return force, kink, slack if outward else slack / abs(ly.ratio(p, row))


@bare_kernel
def _bind(tree: JointTree, i: int, x: float, towards: float, rests: bool) -> None:
    k, p, modes, _, _, w = tree
    n = k[ly.BLOCKS]
    j = k[ly.JOINTS]
    joint = ly.joint_of(k, i)
    if rests:
        low, high, slack = force_at_rest(k, p, i, w)
        if is_self_locking(p, ly.joint_row(k, joint)):
            side = side_at_rest(k, p, i, w)
            modes[n + j + joint] = side if side != 0 else modes[n + j + joint]
    else:
        force, kink, slack = _force_in_motion(tree, i, x, towards)
        low = high = force
        modes[n + j + joint] = 1 if force > kink else -1
    if (modes[n + joint] == -1 and high < -slack) or (modes[n + joint] == 1 and low > slack):
        modes[n + joint] = OPEN


@bare_kernel
def _set_motions(tree: JointTree, x: float, towards: float, rests: bool) -> None:
    k, _, modes, members, y, w = tree
    n = k[ly.BLOCKS]
    dry = False
    left = 0
    for m in range(members.size):
        dry = dry or ly.can_stick(k, ly.block_at(k, members[m])) == 1
    for m in range(members.size):
        i = ly.block_at(k, members[m])
        if members[m] < left:
            continue
        if m > 0:
            _bind(tree, i, x, towards, rests)
            if modes[n + ly.joint_of(k, i)] == OPEN:
                left = members[m] + ly.span_of(k, i)
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
def solve_tree(
    k: IntVector,
    p: Vector,
    modes: IntVector,
    index: int,
    workspace: IntVector,
    y: Vector,
    w: Vector,
) -> int:
    """Set the modes of the blocks that rigid joints and closed contacts connect to a root.

    - index: index of the root in section ORDER
    - workspace: (blocks + 1,) or longer. If the tree jams, contacts that would pull are open. The
      last entry of `workspace` is then the index of the first jammed block in section ORDER

    Returns a status of engine/status_codes.py.
    """
    n = k[ly.BLOCKS]
    count = _members(k, modes, index, workspace)
    members = workspace[:count]
    root = ly.block_at(k, index)
    tree = JointTree(k, p, modes, members, y, w)
    _spread_ratios(tree)
    dry = False
    gross = 0.0
    for m in range(count):
        i = ly.block_at(k, members[m])
        dry = dry or ly.can_stick(k, i) == 1 or w[STOPPED_LOW, i] > 0.0 or w[STOPPED_HIGH, i] > 0.0
    for m in range(count - 1, -1, -1):
        i = ly.block_at(k, members[m])
        if m > 0:
            w[GROSS, ly.parent_of(k, i)] += w[GROSS, i] * abs(
                w[ALONG, i] / w[ALONG, ly.parent_of(k, i)]
            )
        else:
            gross = w[GROSS, i]
    towards = 0.0
    rests = False
    solved = False
    x = 0.0
    if dry and y[n + root] == 0.0:
        gather_rest(tree, False, 0.0)
        towards = breakaway_at_rest(k, p, root, w)
        rests = towards == 0.0
    if rests:
        solved, towards, x = _leaves_unloaded(tree, gross)
        if not solved:
            gather_rest(tree, False, 0.0)
            _set_motions(tree, 0.0, 0.0, True)
            return OK
    else:
        solved, x = solve(tree, towards, gross)
        if not solved:
            before = (
                w[ACCELERATION, root]
                if towards == 0.0 and math.isfinite(w[ACCELERATION, root])
                else 0.0
            )
            solved, x = follow(tree, before, towards, gross)
    _set_motions(tree, x, towards, False)
    if not solved:
        workspace[-1] = _jammed(tree)
        return JAMMED
    return OK
