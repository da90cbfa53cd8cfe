"""Connections of a mechanism's blocks, q_b = ratio q_a + offset."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from frictool.errors import NoSolutionError
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.packed_mechanism import FRAME, Couplings, Joints

SAME = 1e-9  # relative tolerance of two ratios around a loop


@dataclass(frozen=True)
class Connection:
    """Link between the blocks a and b.

    a, b: numbers of the blocks.
    ratio, offset: coefficients of q_b = ratio q_a + offset.
    gap: half the width of the backlash, in the coordinate of `b` [rad | m].
    drive_loss: (effort lost at `a`)/(effort at `b`) while `a` drives `b`; same unit as `ratio`.
    back_loss: the same quotient while `b` drives `a`.
    stiffness, damping: stiffness and damping of the link, in the coordinate of `b`; 0 for a rigid
        link.
    """

    name: str
    a: int
    b: int
    ratio: float
    offset: float
    gap: float
    drive_loss: float
    back_loss: float
    compliant: bool = False
    stiffness: float = 0.0
    damping: float = 0.0
    restitution: float = 0.0

    @property
    def lossless(self) -> bool:
        """Return True if the link has no losses."""
        return self.drive_loss == 0.0 and self.back_loss == 0.0

    @property
    def plain(self) -> bool:
        """Return True if the link has no compliance, backlash or loss."""
        return not self.compliant and self.gap == 0.0 and self.lossless


def connections(assembled: AssembledMechanism) -> tuple[Connection, ...]:
    """Return all links between two blocks: the rigid links, then the compliant links."""
    joints, couplings = assembled.packed.joints, assembled.packed.couplings
    result = [_joint(name, joints, k) for k, name in enumerate(assembled.joints)]
    result += [
        _coupling(name, couplings, k)
        for k, name in enumerate(assembled.couplings)
        if couplings.a[k] != FRAME
    ]
    return tuple(result)


def _joint(name: str, joints: Joints, k: int) -> Connection:
    drive, back = float(joints.drive_loss[k]), float(joints.back_loss[k])
    if joints.thesis_screw[k] > 0.0:
        drive, back = thesis_losses(
            float(joints.ratio[k]), float(joints.thread[k]), float(joints.thesis_screw[k])
        )
    return Connection(
        name, int(joints.a[k]), int(joints.b[k]),
        float(joints.ratio[k]), float(joints.offset[k]), float(joints.gap[k]), drive, back,
        restitution=float(joints.restitution[k]),
    )  # fmt: skip


def thesis_losses(ratio: float, thread: float, steep: float) -> tuple[float, float]:
    """Return (drive_loss, back_loss) of a screw at a steady speed (thesis (2.12)).

    f is the force, u the torque at the thread, r the radius and a the lead angle of the thread, mu
    the friction coefficient, and w = mu tan(a) < 1:

        u = r tan(a) f ± mu |r f - u tan(a)|
        drive loss = r (tan(a) + s mu)/(1 + s w) - r tan(a)
        back loss  = r tan(a) - r (tan(a) - s mu)/(1 - s w)

    s is the sign of r f - u tan(a): 1 if a < 45 deg, else -1.

    ratio: r tan(a) [m/rad].
    thread: mu r [m/rad].
    steep: w, dimensionless.
    """
    carried = abs(ratio)
    if carried * steep > thread:  # tan(a)^2 > 1
        thread, steep = -thread, -steep
    return (carried + thread) / (1.0 + steep) - carried, carried - (carried - thread) / (
        1.0 - steep
    )


def _coupling(name: str, couplings: Couplings, k: int) -> Connection:
    return Connection(
        name, int(couplings.a[k]), int(couplings.b[k]),
        float(couplings.ratio[k]), float(couplings.offset[k]), float(couplings.gap[k]),
        float(couplings.drive_loss[k]), float(couplings.back_loss[k]),
        True, float(couplings.stiffness[k]), float(couplings.damping[k]),
    )  # fmt: skip


@dataclass(frozen=True)
class BlockMotion:
    """Motion of a block relative to the motion of the root block: q_b = ratio q_root + offset.

    by: connections on the path from the root to the block.
    """

    ratio: float
    offset: float
    by: tuple[Connection, ...] = ()


def seen_from(
    root: int, links: Sequence[Connection], names: Sequence[str]
) -> dict[int, BlockMotion]:
    """Return the motion of every block that moves with the block `root`, by block number.

    In these motions each backlash is in its middle, and compliant links are unstrained. Paths of
    rigid links are preferred.

    - names: names of the blocks by number

    Raises NoSolutionError if two paths from the root to a block have different ratios: the
    mechanism then has several independent motions, or cannot move.
    """
    motions = {root: BlockMotion(1.0, 0.0)}
    for compliant in (False, True):
        changed = True
        while changed:
            changed = False
            for link in links:
                if link.compliant and not compliant:
                    continue
                for here, there, ratio, offset in _both_ways(link):
                    if here in motions and there not in motions:
                        seen = motions[here]
                        motions[there] = BlockMotion(
                            ratio * seen.ratio, ratio * seen.offset + offset, (*seen.by, link)
                        )
                        changed = True
    for link in links:
        if link.a in motions:
            _agrees(link, motions, names)
    return motions


def _both_ways(link: Connection) -> Iterator[tuple[int, int, float, float]]:
    yield link.a, link.b, link.ratio, link.offset
    yield link.b, link.a, 1.0 / link.ratio, -link.offset / link.ratio


def _agrees(link: Connection, motions: dict[int, BlockMotion], names: Sequence[str]) -> None:
    there = motions[link.b].ratio
    expected = link.ratio * motions[link.a].ratio
    if not np.isclose(there, expected, rtol=SAME, atol=0.0):
        raise NoSolutionError(
            f"links.{link.name}: paths from the source to {names[link.b]} have different "
            f"ratios: {expected:.6g} through {names[link.a]}, {there:.6g} through "
            f"{', '.join(one.name for one in motions[link.b].by) or 'no link'}; a one-inertia "
            "model needs one ratio"
        )
