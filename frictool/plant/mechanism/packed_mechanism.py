"""A mechanism as the flat arrays that kernels take. SI; one coordinate q per block, an angle or a
way.

    m_i q_i'' = sum of what links, friction, stops and sources put on block i                                     (2.1)-(2.2)

Joints are rigid, or rigid with a gap. Joint j carries block b along with block a; e = q_b - ratio
q_a - offset:

    rigid          e = 0
    with a gap     -gap <= e <= gap; it touches at e = -gap, where it can only push b forward
                   (lambda >= 0), and at e = gap (lambda <= 0)
    on block b     lambda
    on block a     -(ratio lambda + loss)     loss = sign(v_a) (drive_loss |lambda| where lambda v_b
                   > 0, back_loss |lambda| where < 0)
                                              or, thesis_screw > 0, loss = sign(v_a) |thread lambda - thesis_screw u_a|        (2.12)

ratio - back_loss sign(ratio) < 0 is a link that its load cannot drive. Joints form no loop among
themselves (an anchored block ends none).

Couplings yield: block a = second end -1 is the frame. e = q_b - ratio q_a - offset, stretch s = e
beyond +-gap (0 between):

    on block b     -(stiffness s + damping e' + curve(e))    damping acts only where stretched,
                   where gap > 0; no flank pulls
    on block a     as of a joint, with that force for lambda

Frictions act on one block against the frame: a law of friction/law_registry.py by its row, its
parameters p from `law_start` on in `law_values`, times the curve `level` (-1: none). Pressings are
Coulomb friction `coefficient` times the curve `force` of the block's position, and breakaway
`breakaway_ratio` times that (2.23). Pushes are efforts that are functions of one block's position
(a cam's), or constants. Stops are rigid and hold one block. Sources put effort on a block: drive i
follows the command with `lag`, effort = constant i.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Places = NDArray[np.int64]
FRAME = -1


class Curves(NamedTuple):
    """Piecewise cubics, constant beyond their ends.

    Curve c has the pieces k = start[c] .. start[c+1] - 1; piece k goes from breaks[k + c] to
    breaks[k + c + 1] and is sum_m cubic[k, m] (x - breaks[k + c])^m.
    """

    start: Places  # (c + 1,)
    breaks: Vector  # (pieces + c,)
    cubic: Vector  # (pieces, 4), lowest power first


class Joints(NamedTuple):
    """Rigid links (j,), and rigid flanks with a gap."""

    a: Places
    b: Places
    ratio: Vector
    offset: Vector
    gap: Vector  # half of the full width at b; 0: none
    restitution: Vector
    drive_loss: Vector  # at a, per unit of lambda
    back_loss: Vector
    thread: Vector  # the thesis's screw: mu radius
    thesis_screw: Vector  # mu tan(alpha); 0 with thread 0: not that screw


class Couplings(NamedTuple):
    """Links that yield (k,); a may be FRAME."""

    a: Places
    b: Places
    ratio: Vector
    offset: Vector
    gap: Vector
    stiffness: Vector
    damping: Vector
    curve: Places  # force over e; -1: none
    drive_loss: Vector
    back_loss: Vector


class Frictions(NamedTuple):
    """(f,)"""

    block: Places
    law: Places  # row of friction/law_registry.py
    law_start: Places  # (f + 1,) into law_values
    law_values: Vector
    level: Places  # curve, or -1


class Pressings(NamedTuple):
    """(p,)"""

    block: Places
    force: Places  # curve
    coefficient: Vector
    breakaway_ratio: Vector


class Pushes(NamedTuple):
    """(q,) effort constant + curve(q of the block) in its positive direction."""

    block: Places
    constant: Vector
    curve: Places  # or -1


class Stops(NamedTuple):
    """Rigid ones (s,); without one side: infinite."""

    block: Places
    low: Vector
    high: Vector
    restitution: Vector


class PackedDrives(NamedTuple):
    """(u,)"""

    block: Places
    constant: Vector  # effort per unit of the drive; 1 of an effort
    limit: Vector  # of the drive
    lag: Vector  # s
    resistance: Vector  # ohm; 0: no winding
    supply: Vector  # V


class PackedMechanism(NamedTuple):
    """The whole mechanism. inertia (n,): kg m2 of a block that turns, kg of one that slides. scale
    (n,): a speed of each block that counts, rad/s | m/s, which tolerances are relative to."""

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
