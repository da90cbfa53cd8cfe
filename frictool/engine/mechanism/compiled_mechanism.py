"""Conversion of a `PackedMechanism` to the sections that kernels read (array_layout.py).

`compile_mechanism` chooses as root of each tree a block from which all self-locking links of the
tree are traversed from their driving side.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.law_kernels import (
    HYBRID,
    addresses_of,
    kind_of,
    rest_of,
    sizes_of,
    straight_of,
)
from frictool.friction.law_registry import ROWS
from frictool.plant.mechanism.fastest_link import LinkRates, link_rates
from frictool.plant.mechanism.packed_mechanism import PackedMechanism
from frictool.typing import IntVector, Vector


class JointForest(NamedTuple):
    """Trees of the joints, as four lists of n elements for n blocks.

    - order: the blocks in preorder
    - parent: parent of each block, -1 for a root
    - joint: joint to the parent, -1 for a root
    - outward: 1 if end a of this joint is at the parent, else 0
    """

    order: list[int]
    parent: list[int]
    joint: list[int]
    outward: list[int]


class _SectionWriter:
    def __init__(self) -> None:
        self.header = np.zeros(ly.HEADER, dtype=np.int64)
        self.whole: list[IntVector] = [self.header]
        self.numbers: list[Vector] = [np.zeros(1)]
        self.integers = ly.HEADER  # number of integers so far
        self.floats = 1  # number of floats so far

    def put_whole(self, section: int, *columns: Any) -> None:
        table = np.column_stack([np.asarray(column, dtype=np.int64) for column in columns]).ravel()
        self.header[section] = self.integers
        self.whole.append(table)
        self.integers += table.size

    def put(self, section: int, *columns: Any) -> None:
        table = np.column_stack(
            [np.asarray(column, dtype=np.float64) for column in columns]
        ).ravel()
        self.header[section] = self.floats
        self.numbers.append(table)
        self.floats += table.size


def _self_locking(packed: PackedMechanism) -> NDArray[np.bool_]:
    joints = packed.joints
    return (np.abs(joints.ratio) <= joints.back_loss) | (np.abs(joints.ratio) <= joints.thread)


def _from_root(
    root: int, near: list[list[tuple[int, int]]], joints: Any, forest: JointForest
) -> None:
    stack = [(root, -1, -1)]
    while stack:
        block, parent, joint = stack.pop()
        forest.order.append(block)
        forest.parent[block], forest.joint[block] = parent, joint
        forest.outward[block] = int(joint >= 0 and joints.a[joint] == parent)
        stack += [(other, block, link) for link, other in reversed(near[block]) if link != joint]


def forest_of(packed: PackedMechanism) -> JointForest:
    """Return the trees of a mechanism's joints.

    Raises ValueError if joints form a loop, or if the load ends of two self-locking links are
    rigidly connected.
    """
    n = packed.inertia.size
    joints = packed.joints
    near: list[list[tuple[int, int]]] = [[] for _ in range(n)]
    for link, (a, b) in enumerate(zip(joints.a.tolist(), joints.b.tolist(), strict=True)):
        near[a].append((link, b))
        near[b].append((link, a))
    forest = JointForest([], [-1] * n, [-1] * n, [0] * n)
    stiff = _self_locking(packed)
    seen = np.zeros(n, dtype=bool)
    for first in range(n):
        if seen[first]:
            continue
        for root in _roots(first, near, joints, stiff):
            begin = len(forest.order)
            _from_root(root, near, joints, forest)
            members = forest.order[begin:]
            if not any(
                stiff[forest.joint[i]] and not forest.outward[i]
                for i in members
                if forest.joint[i] >= 0
            ):
                break
            del forest.order[begin:]
        else:
            raise ValueError(
                "the load ends of two self-locking links are rigidly connected: nothing can move"
            )
        seen[members] = True
    return forest


def _roots(
    first: int, near: list[list[tuple[int, int]]], joints: Any, stiff: NDArray[np.bool_]
) -> list[int]:
    reached = {first}
    stack = [(first, -1)]
    walked = []
    while stack:
        block, through = stack.pop()
        for link, other in near[block]:
            if link == through:
                continue
            if other in reached:
                raise ValueError("joints form a loop: the forces in the loop cannot be determined")
            reached.add(other)
            walked.append(link)
            stack.append((other, link))
    drivers = [int(joints.a[link]) for link in walked if stiff[link]]
    return [first, *drivers]


def _dry(packed: PackedMechanism, kinds: list[int]) -> IntVector:
    dry = np.zeros(packed.inertia.size, dtype=np.int64)
    for block, kind in zip(packed.frictions.block, kinds, strict=True):
        dry[block] |= kind == 0
    dry[packed.pressings.block[packed.pressings.coefficient > 0.0]] = 1
    joints, couplings = packed.joints, packed.couplings
    lossy = (joints.drive_loss != 0.0) | (joints.back_loss != 0.0) | (joints.thread != 0.0)
    dry[joints.a[lossy]] = 1
    lossy = ((couplings.drive_loss != 0.0) | (couplings.back_loss != 0.0)) & (couplings.a >= 0)
    dry[couplings.a[lossy]] = 1
    return dry


def _groups(packed: PackedMechanism, forest: JointForest) -> tuple[IntVector, Vector, Vector]:
    """Return three arrays (n,): rigid group, speed ratio and group mass of each block.

    The number of a group is the index of its first block; speed ratio and mass refer to this block.
    """
    n = packed.inertia.size
    joints = packed.joints
    group, ratio, mass = np.arange(n), np.ones(n), np.zeros(n)
    for block in forest.order:
        joint = forest.joint[block]
        if joint >= 0 and joints.gap[joint] == 0.0:
            group[block] = group[forest.parent[block]]
            along = joints.ratio[joint] if forest.outward[block] else 1.0 / joints.ratio[joint]
            ratio[block] = ratio[forest.parent[block]] * along
        mass[group[block]] += ratio[block] ** 2 * packed.inertia[block]
    return group, ratio, mass


def _rates(packed: PackedMechanism, group: IntVector, ratio: Vector, mass: Vector) -> LinkRates:
    with np.errstate(divide="ignore"):
        return link_rates(packed.couplings, ratio**2 / mass[group])


def _spans(forest: JointForest) -> IntVector:
    span = np.ones(len(forest.order), dtype=np.int64)
    for block in reversed(forest.order):
        if forest.parent[block] >= 0:
            span[forest.parent[block]] += span[block]
    return span


def _inner_sizes(rows: list[int], values: list[Vector]) -> Vector:
    scales = [sizes_of(ROWS[row], p) for row, p in zip(rows, values, strict=True)]
    return np.concatenate(scales) if scales else np.zeros(0)


def compile_mechanism(packed: PackedMechanism) -> CompiledMechanism:
    """Return a mechanism as two arrays of sections and the addresses of its friction laws.

    The damping of fast links is raised to critical damping (plant/mechanism/fastest_link.py).

    Raises ValueError as `forest_of` does, or if a friction law is not in the registry.
    """
    f, c, j = packed.frictions, packed.couplings, packed.joints
    values = [f.law_values[f.law_start[i] : f.law_start[i + 1]] for i in range(f.block.size)]
    kinds = [kind_of(ROWS[row], p) for row, p in zip(f.law.tolist(), values, strict=True)]
    inner = [rest_of(ROWS[row], p).size for row, p in zip(f.law.tolist(), values, strict=True)]
    ends = np.concatenate([[0], np.cumsum(inner)]).astype(np.int64)
    forest = forest_of(packed)
    out = _SectionWriter()
    group, ratio, mass = _groups(packed, forest)
    rates = _rates(packed, group, ratio, mass)
    sizes = (
        packed.inertia,
        j.a,
        c.a,
        f.block,
        packed.pressings.block,
        packed.pushes.block,
        packed.stops.block,
        packed.sources.block,
    )
    out.header[: len(sizes)] = [array.size for array in sizes]
    out.header[ly.INNER] = ends[-1]
    out.header[ly.TIMED] = sum(kind >= HYBRID for kind in kinds)
    out.header[ly.STIFF] = np.count_nonzero(rates.stiff)
    out.put_whole(ly.JOINT_ENDS, j.a, j.b)
    out.put_whole(ly.COUPLING_ENDS, c.a, c.b, c.curve)
    straight = [straight_of(ROWS[row], p) for row, p in zip(f.law.tolist(), values, strict=True)]
    out.put_whole(
        ly.FRICTION_INDICES,
        f.block,
        f.law,
        kinds,
        f.law_start[:-1],
        f.law_start[1:],
        f.level,
        ends[:-1],
        ends[1:],
        straight,
    )
    out.put_whole(ly.PRESSING_INDICES, packed.pressings.block, packed.pressings.force)
    out.put_whole(ly.PUSH_INDICES, packed.pushes.block, packed.pushes.curve)
    out.put_whole(ly.STOP_BLOCKS, packed.stops.block)
    out.put_whole(ly.SOURCE_BLOCKS, packed.sources.block)
    out.put_whole(ly.CURVE_START, packed.curves.start)
    for section, column in (
        (ly.ORDER, forest.order),
        (ly.PARENT, forest.parent),
        (ly.PARENT_JOINT, forest.joint),
        (ly.OUTWARD, forest.outward),
    ):
        out.put_whole(section, column)
    for section, places in (
        (ly.GROUP, group),
        (ly.DRY, _dry(packed, kinds)),
        (ly.SPAN, _spans(forest)),
    ):
        out.put_whole(section, places)
    out.put(ly.MASS, packed.inertia)
    out.put(ly.SPEED, packed.scale)
    out.put(
        ly.JOINT,
        j.ratio,
        j.offset,
        j.gap,
        j.restitution,
        j.drive_loss,
        j.back_loss,
        j.thread,
        j.thesis_screw,
    )
    out.put(
        ly.COUPLING,
        c.ratio,
        c.offset,
        c.gap,
        np.zeros(c.a.size),
        c.drive_loss,
        c.back_loss,
        c.stiffness,
        rates.damping,
    )
    out.put(ly.LAW_VALUES, f.law_values)
    out.put(ly.PRESSING, packed.pressings.coefficient, packed.pressings.breakaway_ratio)
    out.put(ly.PUSH, packed.pushes.constant)
    out.put(ly.STOP, packed.stops.low, packed.stops.high, packed.stops.restitution)
    s = packed.sources
    out.put(ly.SOURCE, s.constant, s.limit, s.lag, s.resistance, s.supply)
    out.put(ly.BREAKS, packed.curves.breaks)
    out.put(ly.CUBIC, packed.curves.cubic.ravel())
    out.put(ly.GROUP_RATIO, ratio)
    out.put(ly.GROUP_MASS, mass)
    out.put(ly.INNER_SIZE, _inner_sizes(f.law.tolist(), values))
    return CompiledMechanism(
        np.concatenate(out.whole),
        np.concatenate(out.numbers),
        addresses_of([ROWS[row] for row in f.law.tolist()], kinds),
    )
