"""Mechanism as flat arrays for kernels, in SI; each block has one coordinate q (angle or distance).

    m_i q_i'' = sum of the efforts of links, friction, stops and sources on block i   (2.1)-(2.2)

*Joints* are rigid links, with or without a gap. Joint j ties block b to block a, with
e = q_b - ratio q_a - offset:

    rigid          e = 0
    with a gap     -gap <= e <= gap; contact at e = -gap can only push b forward (lambda >= 0),
                   contact at e = gap only backward (lambda <= 0)
    on block b     lambda
    on block a     -(ratio lambda + loss)
    loss           sign(v_a) drive_loss |lambda| if lambda v_b > 0
                   sign(v_a) back_loss |lambda| if lambda v_b < 0
                   sign(v_a) |thread lambda - thesis_screw u_a| if thesis_screw > 0       (2.12)

If back_loss >= |ratio|, the load cannot drive the link. Joints form no loop, and no joint ends at
the frame.

*Couplings* are compliant links; block a = -1 is the frame. With e = q_b - ratio q_a - offset, the
stretch s is the part of e beyond the range -gap .. gap (0 inside this range):

    on block b     -(stiffness s + damping e' + curve(e))    with gap > 0, damping acts only in
                   contact, and no flank pulls
    on block a     as for a joint, with the force on block b as lambda

*Frictions* act on one block against the frame. Each friction has a law (row of
friction/law_registry.py), parameters p in `law_values` from the index `law_start` on, and a factor,
the curve with the index `level` (-1: factor 1). *Pressings* are Coulomb friction: `coefficient`
times the curve `force` of the block's position; the breakaway is `breakaway_ratio` times this
friction (2.23). *Pushes* are efforts that depend on one block's position (efforts of a cam), or
constants. *Stops* are rigid and limit one block. *Sources* act on a block: the drive i follows the
command with `lag`, effort = constant i.
"""

from __future__ import annotations

from typing import NamedTuple

from frictool.typing import IntVector, Vector

FRAME = -1


class Curves(NamedTuple):
    """Piecewise cubics, constant outside their range.

    Curve c has the pieces k = start[c] .. start[c+1] - 1. Piece k extends from breaks[k + c] to
    breaks[k + c + 1] and is the sum over m of cubic[k, m] (x - breaks[k + c])^m.
    """

    start: IntVector  # (c + 1,)
    breaks: Vector  # (pieces + c,)
    cubic: Vector  # (pieces, 4), lowest power first


class Joints(NamedTuple):
    """Rigid links (j,), with or without a gap; the module docstring has their equations."""

    a: IntVector
    b: IntVector
    ratio: Vector
    offset: Vector
    gap: Vector  # half of the full width, at b; 0: no gap
    restitution: Vector
    drive_loss: Vector  # at a, per unit of lambda
    back_loss: Vector
    thread: Vector  # mu radius of the thesis's screw (2.12)
    thesis_screw: Vector  # mu tan(alpha) of that screw; thread and this are 0 for other links


class Couplings(NamedTuple):
    """Compliant links (k,); the module docstring has their equations. Block `a` may be FRAME."""

    a: IntVector
    b: IntVector
    ratio: Vector
    offset: Vector
    gap: Vector
    stiffness: Vector
    damping: Vector
    curve: IntVector  # force over e; -1: none
    drive_loss: Vector
    back_loss: Vector


class Frictions(NamedTuple):
    """Friction of bearings and slideways (f,); `block` moves against the frame."""

    block: IntVector
    law: IntVector  # row of friction/law_registry.py
    law_start: IntVector  # (f + 1,) into law_values
    law_values: Vector
    level: IntVector  # curve, or -1


class Pressings(NamedTuple):
    """Friction of p cams: `coefficient` times the curve `force` at the position of the block."""

    block: IntVector
    force: IntVector  # curve
    coefficient: Vector
    breakaway_ratio: Vector


class Pushes(NamedTuple):
    """Efforts (q,): constant + curve(position), in the positive direction of the block."""

    block: IntVector
    constant: Vector
    curve: IntVector  # or -1


class Stops(NamedTuple):
    """Rigid end stops (s,); a missing side is infinite."""

    block: IntVector
    low: Vector
    high: Vector
    restitution: Vector


class PackedDrives(NamedTuple):
    """Drives of the sources (u,); source i acts on block `block`[i]."""

    block: IntVector
    constant: Vector  # effort per unit of the drive; 1 if the drive is an effort
    limit: Vector  # largest |drive|
    lag: Vector  # s
    resistance: Vector  # ohm; 0: no winding
    supply: Vector  # V


class PackedMechanism(NamedTuple):
    """Whole mechanism as arrays.

    - inertia (n,): inertia of each of the n blocks [kg m2 | kg]
    - scale (n,): typical speed of each block [rad/s | m/s], to which tolerances are relative
    """

    inertia: Vector
    scale: Vector
    joints: Joints
    couplings: Couplings
    frictions: Frictions
    pressings: Pressings
    pushes: Pushes
    stops: Stops
    sources: PackedDrives
    curves: Curves
