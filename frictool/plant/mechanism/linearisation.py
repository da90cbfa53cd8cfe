"""Linearised mechanism: state space from sources to sensors, and vibration modes.

Dry friction, impacts and stops are neglected; viscous friction, damping, stiffness and the slopes
of curves are kept. Blocks that rigid links or closed backlash connect have one common coordinate.
The positions of all blocks are q = R p with these coordinates p. The principle of virtual work
gives

    L' M R p'' + L' D R p' + L' K R p = L' u

with the matrices M, D and K of mass, damping and stiffness, the sources' efforts u, and L = R if
the links have no losses. With efficiency "driving", power is assumed to flow from the first to the
second end of each link. A link with the efficiency eta then needs ratio/eta times the effort that
it transmits (2.3)-(2.5). Therefore L and the efforts of the couplings contain ratio/eta in place of
the ratio. Two pulleys and a belt give thesis (2.6) with the transfer function (2.7). If the belt
has no damping, the result is (2.8); if the belt is rigid, (2.9).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from frictool.friction.law_registry import ROWS
from frictool.plant.lti import Lti
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.curves import curve_slope, curve_value
from frictool.plant.mechanism.packed_mechanism import FRAME
from frictool.typing import IntVector, Matrix, Vector

Efficiency = Literal["none", "driving"]
STILL = 1e-7  # limit of a rigid-body eigenvalue, relative to the largest eigenvalue


@dataclass(frozen=True)
class VibrationMode:
    """Vibration mode of a linearised mechanism.

    - frequency: undamped angular frequency [rad/s]
    - damping: damping ratio
    - blocks, links: share of each block in the kinetic energy, of each link in the strain energy
    """

    frequency: float
    damping: float
    blocks: dict[str, float]
    links: dict[str, float]


@dataclass(frozen=True)
class LinearMechanism:
    """Linearised mechanism with the coordinates p (g,) of the blocks `roots`.

    - moves (n, g): moves @ p are the coordinates q of all n blocks
    - mass, damping, stiffness (g, g), input (g, u): matrices of the equation of motion
    - output (y, 2 g): outputs per unit of [p | p']
    - sources, sensors: names of inputs [unit of the drive] and outputs [rad | m | rad/s | m/s]
    - couplings: names of the k compliant links
    - stretches (k, g), springs (k,): stretch of each coupling per unit of p, and its stiffness
    - inertia (n,): inertia of each block alone
    """

    blocks: tuple[str, ...]
    roots: tuple[int, ...]
    moves: Matrix
    mass: Matrix
    damping: Matrix
    stiffness: Matrix
    input: Matrix
    output: Matrix
    sources: tuple[str, ...]
    sensors: tuple[str, ...]
    couplings: tuple[str, ...]
    stretches: Matrix
    springs: Vector
    inertia: Vector

    def state_space(self) -> Lti:
        """Return the continuous system; its states are the coordinates p, then their rates p'.

        Its inputs and outputs are in the order of `sources` and `sensors`.
        """
        count = len(self.mass)
        solved = np.linalg.solve(self.mass, np.hstack([-self.stiffness, -self.damping, self.input]))
        a = np.block([[np.zeros((count, count)), np.eye(count)], [solved[:, : 2 * count]]])
        b = np.vstack([np.zeros((count, self.input.shape[1])), solved[:, 2 * count :]])
        return Lti(a, b, self.output, np.zeros((len(self.output), self.input.shape[1])), 0.0)

    def transfer(self, source: str, sensor: str) -> Lti:
        """Return the system from one source to one sensor; raise ValueError for an unknown name."""
        whole = self.state_space()
        i, o = self.sources.index(source), self.sensors.index(sensor)
        return Lti(whole.a, whole.b[:, [i]], whole.c[[o]], whole.d[[o]][:, [i]], 0.0)

    def modes(self) -> tuple[VibrationMode, ...]:
        """Return the vibration modes, slowest first.

        Each mode is a pair of complex eigenvalues. Rigid-body motions and overdamped motions are
        left out.
        """
        count = len(self.mass)
        scale = np.sqrt(np.abs(np.diag(self.mass)))  # balances the states for the eigenvalues
        system = self.state_space()
        grown = np.concatenate([scale, scale])
        values, vectors = np.linalg.eig(grown[:, None] * system.a / grown)
        fastest = np.max(np.abs(values), initial=0.0)
        pairs = []
        for index in np.argsort(np.abs(values), kind="stable"):
            value = values[index]
            if value.imag > STILL * fastest:
                shape = np.asarray(vectors[:count, index] / scale, dtype=np.complex128)
                pairs.append(self._mode(complex(value), shape))
        return tuple(pairs)

    def _mode(self, value: complex, shape: NDArray[np.complex128]) -> VibrationMode:
        kinetic = self.inertia * np.abs(self.moves @ shape) ** 2
        strain = np.abs(self.springs) * np.abs(self.stretches @ shape) ** 2
        whole = float(np.sum(strain)) or 1.0
        blocks = dict(zip(self.blocks, (kinetic / np.sum(kinetic)).tolist(), strict=True))
        links = dict(zip(self.couplings, (strain / whole).tolist(), strict=True))
        return VibrationMode(abs(value), -value.real / abs(value), blocks, links)


def linearise(
    assembled: AssembledMechanism,
    position: Vector | None = None,
    closed: Collection[str] | None = None,
    efficiency: Efficiency = "none",
) -> LinearMechanism:
    """Return the mechanism linearised at `position` (n,) [rad | m], by default the start position.

    closed: names of links whose backlash is assumed closed and thus has no effect; by default all
    links with backlash. Raises ValueError for a name that no link with backlash has.
    """
    packed = assembled.packed
    at = assembled.start if position is None else np.asarray(position, dtype=np.float64)
    joint_closed, coupling_closed = _closed(assembled, closed)
    driving = 1.0 if efficiency == "driving" else 0.0
    joints = packed.joints
    passed = joints.ratio + driving * np.sign(joints.ratio) * joints.drive_loss
    moves, roots = _moves(joints.a, joints.b, joints.ratio, joint_closed, len(packed.inertia))
    works, _ = _moves(joints.a, joints.b, passed, joint_closed, len(packed.inertia))
    stretch, pull, stiffness, damping = _couplings(assembled, at, coupling_closed, driving)
    field = pull.T @ (stiffness[:, None] * stretch) - np.diag(_push_slopes(assembled, at))
    drag = pull.T @ (damping[:, None] * stretch) + np.diag(_viscous(assembled, at))
    efforts = np.zeros((len(packed.inertia), len(assembled.sources)))
    efforts[packed.sources.block, np.arange(len(assembled.sources))] = packed.sources.constant
    return LinearMechanism(
        assembled.blocks,
        roots,
        moves,
        works.T @ (packed.inertia[:, None] * moves),
        works.T @ drag @ moves,
        works.T @ field @ moves,
        works.T @ efforts,
        _output(assembled, moves),
        assembled.sources,
        assembled.sensors,
        assembled.couplings,
        stretch @ moves,
        stiffness,
        packed.inertia,
    )


def _closed(
    assembled: AssembledMechanism, closed: Collection[str] | None
) -> tuple[list[bool], list[bool]]:
    joints, couplings = assembled.packed.joints, assembled.packed.couplings
    playing = {name for name, gap in zip(assembled.joints, joints.gap, strict=True) if gap > 0.0}
    playing |= {
        name
        for name, gap, a in zip(assembled.couplings, couplings.gap, couplings.a, strict=True)
        if gap > 0.0 and a != FRAME
    }
    taken = playing if closed is None else set(closed)
    if taken - playing:
        raise ValueError(
            f"closed: found {', '.join(sorted(taken - playing))}, no link with backlash; allowed: "
            f"{', '.join(sorted(playing)) or 'no name, since no link has backlash'}"
        )
    return (
        [
            gap == 0.0 or name in taken
            for name, gap in zip(assembled.joints, joints.gap, strict=True)
        ],
        [
            gap == 0.0 or name in taken
            for name, gap in zip(assembled.couplings, couplings.gap, strict=True)
        ],
    )


def _moves(
    a: IntVector, b: IntVector, ratio: Vector, active: list[bool], count: int
) -> tuple[Matrix, tuple[int, ...]]:
    """Return (moves, roots): moves (n, g) @ (speeds of the g roots) are the speeds of the n blocks.

    The active links form g groups of blocks; the root of a group is its first block.
    """
    neighbours: list[list[tuple[int, float]]] = [[] for _ in range(count)]
    for first, second, step, on in zip(a.tolist(), b.tolist(), ratio.tolist(), active, strict=True):
        if on:
            neighbours[first].append((second, step))
            neighbours[second].append((first, 1.0 / step))
    columns = []
    roots = []
    seen = np.zeros(count, dtype=bool)
    for root in range(count):
        if seen[root]:
            continue
        column = np.zeros(count)
        column[root] = 1.0
        seen[root] = True
        queue = [root]
        for here in queue:
            for there, step in neighbours[here]:
                if not seen[there]:
                    column[there] = column[here] * step
                    seen[there] = True
                    queue.append(there)
        columns.append(column)
        roots.append(root)
    return np.array(columns).T, tuple(roots)


def _couplings(
    assembled: AssembledMechanism, at: Vector, active: list[bool], driving: float
) -> tuple[Matrix, Matrix, Vector, Vector]:
    """Return stretch and pull (k, n), stiffness and damping (k,) of the couplings.

    - stretch: stretch of each coupling per unit of each block's coordinate
    - pull: a coupling with the force f acts on the blocks with the efforts -pull f

    Stiffness and damping are 0 while the backlash is open.
    """
    couplings, curves = assembled.packed.couplings, assembled.packed.curves
    count = len(couplings.a)
    stretch, pull = np.zeros((count, len(at))), np.zeros((count, len(at)))
    stiffness = np.zeros(count)
    for k in range(count):
        a, b, ratio = int(couplings.a[k]), int(couplings.b[k]), float(couplings.ratio[k])
        stretch[k, b] += 1.0
        pull[k, b] += 1.0
        if a != FRAME:
            stretch[k, a] -= ratio
            pull[k, a] -= ratio + driving * np.sign(ratio) * couplings.drive_loss[k]
        if active[k]:
            stiffness[k] = couplings.stiffness[k]
            if couplings.curve[k] >= 0:
                stiffness[k] += curve_slope(
                    curves, int(couplings.curve[k]), float(stretch[k] @ at - couplings.offset[k])
                )
    return stretch, pull, stiffness, np.where(active, couplings.damping, 0.0)


def _push_slopes(assembled: AssembledMechanism, at: Vector) -> Vector:
    pushes = assembled.packed.pushes
    slopes = np.zeros(len(at))
    for block, curve in zip(pushes.block.tolist(), pushes.curve.tolist(), strict=True):
        if curve >= 0:
            slopes[block] += curve_slope(assembled.packed.curves, curve, float(at[block]))
    return slopes


def _viscous(assembled: AssembledMechanism, at: Vector) -> Vector:
    frictions, curves = assembled.packed.frictions, assembled.packed.curves
    out = np.zeros(len(at))
    for k, (block, row) in enumerate(
        zip(frictions.block.tolist(), frictions.law.tolist(), strict=True)
    ):
        names = [parameter.name for parameter in ROWS[row].parameters]
        if "viscous" in names:
            value = float(frictions.law_values[frictions.law_start[k] + names.index("viscous")])
            level = int(frictions.level[k])
            out[block] += value * (
                1.0 if level < 0 else curve_value(curves, level, float(at[block]))
            )
    return out


def _output(assembled: AssembledMechanism, moves: Matrix) -> Matrix:
    rows = []
    still = np.zeros(moves.shape[1])
    for block, measures in zip(assembled.sensor_blocks, assembled.measures, strict=True):
        parts = (still, moves[block]) if measures == "velocity" else (moves[block], still)
        rows.append(np.concatenate(parts))
    return np.array(rows).reshape(len(rows), 2 * moves.shape[1])
