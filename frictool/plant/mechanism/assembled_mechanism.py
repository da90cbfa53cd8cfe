"""Assembled mechanism: arrays for kernels, and the names of the elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from frictool.friction.parameter import Axis
from frictool.plant.mechanism.link_graph import RigidGroup
from frictool.plant.mechanism.packed_mechanism import PackedMechanism
from frictool.typing import Vector


@dataclass(frozen=True)
class AssembledMechanism:
    """Arrays of a mechanism, and the names of its elements.

    - blocks, kinds, start (n,): name of each block, kind (rotary or linear), and initial position
      [rad | m], which satisfies the equations of all rigid links
    - joints, couplings, frictions, pressings, pushes, stops, sources: names of the elements, in the
      order of the arrays in `packed`
    - sensors, sensor_blocks, measures: name, block and measured quantity of each sensor
    - groups: rigid groups of blocks, which move together
    - notes: one line for each simplification of the mechanism
    """

    blocks: tuple[str, ...]
    kinds: tuple[Axis, ...]
    start: Vector
    joints: tuple[str, ...]
    couplings: tuple[str, ...]
    frictions: tuple[str, ...]
    pressings: tuple[str, ...]
    pushes: tuple[str, ...]
    stops: tuple[str, ...]
    sources: tuple[str, ...]
    sensors: tuple[str, ...]
    sensor_blocks: tuple[int, ...]
    measures: tuple[Literal["position", "velocity"], ...]
    groups: tuple[RigidGroup, ...]
    notes: tuple[str, ...]
    packed: PackedMechanism
