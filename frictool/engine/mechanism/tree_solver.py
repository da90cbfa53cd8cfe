"""Simultaneous solution of one tree of joints with all its touching contacts.

Each subtree is described by one function: Lambda(x), the effort that it needs for the acceleration
x of its root. Through a rigid joint, the child has the acceleration ratio x. Through a flank, which
can only push, the child's need counts only if it is a push, max(0, Lambda_child(ratio x));
otherwise the child separates.

Each step of the recursion keeps Lambda a rising, piecewise linear graph: m x rises, Coulomb
friction at rest is a vertical piece at x = 0, and the loss of a link that its load can drive rises
with the force. So 0 = Lambda(x) has one solution, independent of the order of contacts. It is the
motion that Gauss's principle of least constraint selects among those that the contacts allow
(Moreau 1966; the graph is the subdifferential of a convex function of the accelerations). A tree at
rest stays at rest if its interval Lambda(0) contains 0.

A breakaway above the Coulomb friction makes the graph fall at x = 0: a tree that can stay at rest
does so, and any other starts with its friction in slip.

A self-locking link also makes the graph fall, so that 0 = Lambda(x) may have several solutions, or
none (Painleve). Then `follow` and `_leaves_unloaded` choose as a stiff compliant link with damping
does.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import layout as ly
from frictool.engine.mechanism.acceleration_graph import (
    FOUND,
    MAX_PIECES,
    PASSED,
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
from frictool.engine.status import JAMMED, OK
from frictool.runtime.kernels import inset_kernel, part_kernel
from frictool.typing import IntVector, Vector


@inset_kernel
def _members(k: IntVector, modes: IntVector, place: int, found: IntVector) -> int:
    """Fill `found` with the blocks connected to the root; return their number.

    Each block is listed by its position in the order. Rigid joints and closed contacts connect; the
    root is at `place`.
    """
    n, count = k[ly.BLOCKS], 0
    at, end = place, place + ly.span_of(k, ly.block_at(k, place))
    while at < end:
        i = ly.block_at(k, at)
        joint = ly.joint_of(k, i)
        if at > place and modes[n + joint] == OPEN:
            at += ly.span_of(k, i)
            continue
        found[count] = at
        count += 1
        at += 1
    return count


@inset_kernel
def _spread_ratios(k: IntVector, p: Vector, found: IntVector, count: int, w: Vector) -> None:
    """Fill ALONG with each block's speed per unit of the root's."""
    for m in range(count):
        i = ly.block_at(k, found[m])
        if m == 0:
            w[ALONG, i] = 1.0
            continue
        ratio = p[ly.joint_row(k, ly.joint_of(k, i)) + ly.RATIO]
        w[ALONG, i] = w[ALONG, ly.parent_of(k, i)] * (ratio if ly.leads_out(k, i) else 1.0 / ratio)


@inset_kernel
def _leaves_unloaded(
    k: IntVector,
    p: Vector,
    modes: IntVector,
    found: IntVector,
    count: int,
    gross: float,
    y: Vector,
    w: Vector,
) -> tuple[bool, float, float]:
    """Return (leaves, direction, acceleration) of a tree at rest with self-locking joints.

    A self-locking joint holds its driver only by its load. The load at rest may be on another side
    than before, or a run may begin without load. Then the force passes 0, and any effort makes the
    driver slip. The driver rests if the load holds it on the side on which the joint then drives.
    Otherwise it moves on, if such a motion exists.
    """
    if stays_loaded(k, p, modes, found, count, 0.0, w):
        return False, 0.0, 0.0
    gather_rest(k, p, modes, found, count, False, 0.0, w)
    if not unload(k, p, modes, found, count, w):
        return False, 0.0, 0.0
    gather_rest(k, p, modes, found, count, True, 0.0, w)
    towards = breakaway_at_rest(k, p, ly.block_at(k, found[0]), w)
    if towards == 0.0 or stays_loaded(k, p, modes, found, count, towards, w):
        return False, 0.0, 0.0
    x = towards * PASSED * gross / total_inertia(k, p, found, count, w)
    for _ in range(MAX_PIECES):  # up to the piece in which all joints drive
        evaluate(k, p, modes, found, count, x, towards, y, w)
        length = next_piece(k, p, modes, found, count, x, towards, towards, y, w)
        if math.isinf(length):
            break
        x += towards * (length * (1.0 + PASSED) + PASSED * FOUND * abs(x))
    solved, x = follow(k, p, modes, found, count, x, towards, gross, y, w)
    return solved and x * towards > 0.0, towards, x


@inset_kernel
def _jammed(k: IntVector, modes: IntVector, found: IntVector, count: int, w: Vector) -> int:
    """Return the position in the order of the first block of the part without positive inertia.

    Contacts that would pull are open. The inertia is the effective one, including losses.
    """
    n = k[ly.BLOCKS]
    for m in range(count - 1, 0, -1):
        i = ly.block_at(k, found[m])
        if modes[n + ly.joint_of(k, i)] == OPEN and w[SLOPE, i] * w[ALONG, i] <= 0.0:
            return int(found[m])
    return int(found[0])


@inset_kernel
def _force_in_motion(
    k: IntVector, p: Vector, i: int, x: float, towards: float, y: Vector, w: Vector
) -> tuple[float, float, float]:
    """Return lambda of a moving member's joint, the kink of that joint, and the tolerance."""
    n, row, outward = k[ly.BLOCKS], ly.joint_row(k, ly.joint_of(k, i)), ly.leads_out(k, i)
    a = ly.parent_of(k, i) if outward else i
    direction = math.copysign(1.0, towards * w[ALONG, a] if towards != 0.0 else y[n + a])
    kink, force = kink_of(p, row, w[DRIVEN, a]), w[VALUE, i]
    if not outward:
        force = received(p, row, kink, direction, -force)
    slack = slack_at(k, p, w, i) + SLACK * abs(w[SLOPE, i] * x)
    return force, kink, slack if outward else slack / abs(p[row + ly.RATIO])


@inset_kernel
def _bind(
    k: IntVector,
    p: Vector,
    modes: IntVector,
    i: int,
    x: float,
    towards: float,
    rests: bool,
    y: Vector,
    w: Vector,
) -> None:
    """Set the side of its kink on which a member's joint is, and open a flank that would pull."""
    n, j, joint = k[ly.BLOCKS], k[ly.JOINTS], ly.joint_of(k, i)
    if rests:
        low, high, slack = force_at_rest(k, p, i, w)
        if is_self_locking(p, ly.joint_row(k, joint)):
            side = side_at_rest(k, p, i, w)
            modes[n + j + joint] = side if side != 0 else modes[n + j + joint]
    else:
        force, kink, slack = _force_in_motion(k, p, i, x, towards, y, w)
        low = high = force
        modes[n + j + joint] = 1 if force > kink else -1
    if (modes[n + joint] == -1 and high < -slack) or (modes[n + joint] == 1 and low > slack):
        modes[n + joint] = OPEN


@inset_kernel
def _set_motions(
    k: IntVector,
    p: Vector,
    modes: IntVector,
    found: IntVector,
    count: int,
    x: float,
    towards: float,
    rests: bool,
    y: Vector,
    w: Vector,
) -> None:
    """Open flanks that would pull; set sides of kinks, motions and accelerations of the members."""
    n, dry, left = k[ly.BLOCKS], False, 0
    for m in range(count):
        dry = dry or ly.can_stick(k, ly.block_at(k, found[m]))
    for m in range(count):
        i = ly.block_at(k, found[m])
        if found[m] < left:
            continue
        if m > 0:
            _bind(k, p, modes, i, x, towards, rests, y, w)
            if modes[n + ly.joint_of(k, i)] == OPEN:
                left = found[m] + ly.span_of(k, i)
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
    k: IntVector, p: Vector, modes: IntVector, place: int, found: IntVector, y: Vector, w: Vector
) -> int:
    """Set the modes of the tree with the root at `place` in the order, up to its open contacts.

    Returns a status of engine/status.py. If the tree jams, contacts that would pull are open, and
    the last entry of `found` is the position in the order of the first block of the jammed part.
    """
    n = k[ly.BLOCKS]
    count = _members(k, modes, place, found)
    _spread_ratios(k, p, found, count, w)
    root = ly.block_at(k, place)
    dry, gross = False, 0.0
    for m in range(count):
        i = ly.block_at(k, found[m])
        dry = dry or ly.can_stick(k, i) or w[STOPPED_LOW, i] > 0.0 or w[STOPPED_HIGH, i] > 0.0
    for m in range(count - 1, -1, -1):
        i = ly.block_at(k, found[m])
        if m > 0:
            w[GROSS, ly.parent_of(k, i)] += w[GROSS, i] * abs(
                w[ALONG, i] / w[ALONG, ly.parent_of(k, i)]
            )
        else:
            gross = w[GROSS, i]
    towards, rests, solved, x = 0.0, False, False, 0.0
    if dry and y[n + root] == 0.0:
        gather_rest(k, p, modes, found, count, False, 0.0, w)
        towards = breakaway_at_rest(k, p, root, w)
        rests = towards == 0.0
    if rests:
        solved, towards, x = _leaves_unloaded(k, p, modes, found, count, gross, y, w)
        if not solved:
            gather_rest(k, p, modes, found, count, False, 0.0, w)
            _set_motions(k, p, modes, found, count, 0.0, 0.0, True, y, w)
            return OK
    else:
        solved, x = solve(k, p, modes, found, count, towards, gross, y, w)
        if not solved:
            before = (
                w[ACCELERATION, root]
                if towards == 0.0 and math.isfinite(w[ACCELERATION, root])
                else 0.0
            )
            solved, x = follow(k, p, modes, found, count, before, towards, gross, y, w)
    _set_motions(k, p, modes, found, count, x, towards, False, y, w)
    if not solved:
        found[-1] = _jammed(k, modes, found, count, w)
        return JAMMED
    return OK
