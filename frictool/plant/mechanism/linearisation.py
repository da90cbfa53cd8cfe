"""A mechanism linearised: state space from its sources to its sensors, and its modes.

Dry friction, impacts and stops are left out; viscous parts of friction, damping, stiffness and the
slopes of curves stay. What moves as one is one coordinate: q = R p with rigid links, and play that
is taken as closed. Virtual work of the constraints gives

    L' M R p'' + L' D R p' + L' K R p = L' u

L = R where links lose nothing. Where power is taken to flow along the links (efficiency "driving")
each passes ratio/eta of its effort back, as (2.3)-(2.5) have it; L carries these in place of the
ratios, and so do the couplings' efforts. Two pulleys and a belt are (2.6) with the transfer (2.7);
without damping it is (2.8), with a rigid belt (2.9).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from frictool.friction.law_registry import ROWS
from frictool.plant.lti import Lti, Matrix
from frictool.plant.mechanism.assembly import AssembledMechanism
from frictool.plant.mechanism.curves import curve_slope, curve_value
from frictool.plant.mechanism.packed_mechanism import FRAME, Places, Vector

Efficiency = Literal["none", "driving"]
STILL = 1e-7  # of the fastest eigenvalue: below, a mode is the motion of the whole


@dataclass(frozen=True)
class VibrationMode:
    """An oscillation: angular frequency [rad/s] without damping, damping ratio; shares of kinetic
    energy by block, of strain by link."""

    frequency: float
    damping: float
    blocks: dict[str, float]
    links: dict[str, float]


@dataclass(frozen=True)
class LinearMechanism:
    """Coordinates p (g,), of the blocks `roots`; q = moves @ p (n, g). mass, damping, stiffness (g,
    g), input (g, u): of the equation.

    sources, sensors: names of inputs [unit of the drive] and outputs [rad | m | rad/s | m/s].
    """

    blocks: tuple[str, ...]
    roots: tuple[int, ...]
    moves: Matrix
    mass: Matrix
    damping: Matrix
    stiffness: Matrix
    input: Matrix
    output: Matrix  # (y, 2 g) on [p | p']
    sources: tuple[str, ...]
    sensors: tuple[str, ...]
    couplings: tuple[str, ...]
    stretches: Matrix  # (k, g): the stretch of each coupling by p
    springs: Vector  # (k,) its stiffness there
    inertia: Vector  # (n,)

    def state_space(self) -> Lti:
        """x = [p | p'], inputs in the order of `sources`, outputs of `sensors`; continuous time."""
        count = len(self.mass)
        solved = np.linalg.solve(self.mass, np.hstack([-self.stiffness, -self.damping, self.input]))
        a = np.block([[np.zeros((count, count)), np.eye(count)], [solved[:, : 2 * count]]])
        b = np.vstack([np.zeros((count, self.input.shape[1])), solved[:, 2 * count :]])
        return Lti(a, b, self.output, np.zeros((len(self.output), self.input.shape[1])), 0.0)

    def transfer(self, source: str, sensor: str) -> Lti:
        """From one source to one sensor. Raises ValueError where a name is unknown."""
        whole = self.state_space()
        i, o = self.sources.index(source), self.sensors.index(sensor)
        return Lti(whole.a, whole.b[:, [i]], whole.c[[o]], whole.d[[o]][:, [i]], 0.0)

    def modes(self) -> tuple[VibrationMode, ...]:
        """The oscillations, slowest first: one of each pair of complex eigenvalues that is not the
        motion of the whole."""
        count = len(self.mass)
        scale = np.sqrt(np.abs(np.diag(self.mass)))  # states of like size: eigenvalues to rounding
        system = self.state_space()
        grown = np.concatenate([scale, scale])
        values, vectors = np.linalg.eig(grown[:, None] * system.a / grown)
        fastest = np.max(np.abs(values), initial=0.0)
        found = []
        for place in np.argsort(np.abs(values), kind="stable"):
            value = values[place]
            if value.imag > STILL * fastest:
                shape = np.asarray(vectors[:count, place] / scale, dtype=np.complex128)
                found.append(self._mode(complex(value), shape))
        return tuple(found)

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
    """The mechanism around `position` (n,) [rad | m] of its blocks (the start), with the play of
    the links `closed` taken up (all of them).

    Raises ValueError where `closed` names a link without play.
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
            f"found {', '.join(sorted(taken - playing))}; allowed: links with play, {', '.join(sorted(playing)) or 'none here'}"
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
    a: Places, b: Places, ratio: Vector, active: list[bool], count: int
) -> tuple[Matrix, tuple[int, ...]]:
    """(n, g): the ratio of each block to the root of its group, for the links that are active; the
    roots, the first block of each group."""
    neighbours: list[list[tuple[int, float]]] = [[] for _ in range(count)]
    for first, second, step, on in zip(a.tolist(), b.tolist(), ratio.tolist(), active, strict=True):
        if on:
            neighbours[first].append((second, step))
            neighbours[second].append((first, 1.0 / step))
    columns, roots, seen = [], [], np.zeros(count, dtype=bool)
    for root in range(count):
        if seen[root]:
            continue
        column = np.zeros(count)
        column[root], seen[root] = 1.0, True
        queue = [root]
        for here in queue:
            for there, step in neighbours[here]:
                if not seen[there]:
                    column[there], seen[there] = column[here] * step, True
                    queue.append(there)
        columns.append(column)
        roots.append(root)
    return np.array(columns).T, tuple(roots)


def _couplings(
    assembled: AssembledMechanism, at: Vector, active: list[bool], driving: float
) -> tuple[Matrix, Matrix, Vector, Vector]:
    """Stretch (k, n) by q, pull (k, n): efforts by the coupling's force, negative; stiffness and
    damping (k,), 0 where play is open."""
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
    """The viscous part of every friction that has one, at its level there."""
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
