"""Rig of a mechanism for a controller, and the chain of links that starts at the sensor's block.

If backlash and compliance of the links are neglected, the position of a block in the chain follows
from the sensor's position:

    q_block - start_block = ratio (q_sensor - start_sensor)

ratio is the product of the ratios of the links between the two blocks. The load is the block that
`control.load` names. Without this key, the load is the block that is the most links away from the
sensor's block; of several such blocks, the load is the last in the file. The load's position is
converted to the sensor's coordinate for the comparison with the reference.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from frictool.adapters.mechanism.sources_and_sensors import controlled_indices
from frictool.documents.mechanism import Mechanism, Sensor, Source, Spring
from frictool.documents.quantity import si_unit
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.element_error import ElementError
from frictool.plant.mechanism.packed_mechanism import FRAME
from frictool.simulate.rig import Rig
from frictool.typing import Vector

FULL_TURN = 2.0 * np.pi
SAME_PLACE = 1e-12  # relative tolerance of a stop's position


class ControlledAxis(NamedTuple):
    """Indices of the controlled source, and of three blocks (rigid bodies) of a mechanism.

    The three blocks are the block that the source drives, the block whose position the sensor
    measures, and the load. load_ratio: speed of the load divided by the speed of the sensor's
    block.
    """

    source: int
    source_block: int
    sensor_block: int
    load: int
    load_ratio: float


def resolution_of(sensor: Sensor) -> float:
    """Return the step of a position sensor [rad | m], 0 for a perfect encoder."""
    if sensor.step is not None:
        return sensor.step.value
    return (
        FULL_TURN / sensor.counts_per_revolution
        if sensor.counts_per_revolution is not None
        else 0.0
    )


def rig_of_mechanism(
    document: Mechanism, assembled: AssembledMechanism
) -> tuple[Rig, ControlledAxis]:
    """Return the rig that a controller sees, and the indices of the controlled axis.

    Raises ElementError if the sensor does not measure a position. It is also raised if the
    mechanism has several sources or sensors, and `control` does not select one of each.
    """
    source, sensor = controlled_indices(document, assembled)
    drives, senses = (
        document.sources[assembled.sources[source]],
        document.sensors[assembled.sensors[sensor]],
    )
    if senses.measures != "position":
        name = assembled.sensors[sensor]
        raise ElementError(
            f"sensors.{name}.measures",
            f"found {senses.measures}; allowed for the sensor of a controller: position",
        )
    driven = int(assembled.packed.sources.block[source])
    sensed = assembled.sensor_blocks[sensor]
    rig = Rig(
        owner="{}",
        axis=assembled.kinds[sensed],
        drive=drives.drive,
        constant=1.0 if drives.constant is None else drives.constant.value,
        travel=document.travel,
        effort_axis=assembled.kinds[driven],
        facts=_facts(document, drives, senses),
    )
    load, ratio = _load(document, assembled, sensed)
    return rig, ControlledAxis(source, driven, sensed, load, ratio)


def _facts(document: Mechanism, source: Source, sensor: Sensor) -> dict[str, float]:
    """Return the data of verify/rig_facts.py, without springs, which are part of the mechanism."""
    winding = source.winding
    return {
        "sample_period_s": document.sample_period_s,
        "delay_samples": float(document.delay_samples),
        "loop_time_constant_s": source.loop_time_constant_s,
        "drive_limit": math.inf if source.limit is None else source.limit.value,
        "encoder_step": resolution_of(sensor),
        "resistance_ohm": 0.0 if winding is None else winding.resistance_ohm,
        "supply_v": math.inf if winding is None else winding.voltage_v,
    }


class ChainPosition(NamedTuple):
    """Speed of a block divided by the speed of the root block, and number of links to the root."""

    ratio: float
    links: int


def chain_from(
    document: Mechanism, assembled: AssembledMechanism, root: int
) -> dict[int, ChainPosition]:
    """Return the chain positions of `root` and of all blocks linked to it, by block index.

    The blocks are in order of their distance (number of links) from `root`. A spring is not a link.
    """
    joints, couplings = assembled.packed.joints, assembled.packed.couplings
    ties = list(zip(joints.a.tolist(), joints.b.tolist(), joints.ratio.tolist(), strict=True))
    for name, a, b, ratio in zip(
        assembled.couplings,
        couplings.a.tolist(),
        couplings.b.tolist(),
        couplings.ratio.tolist(),
        strict=True,
    ):
        if a != FRAME and not isinstance(document.links.get(name), Spring):
            ties.append((a, b, ratio))
    neighbours: dict[int, list[tuple[int, float]]] = {
        block: [] for block in range(len(assembled.blocks))
    }
    for a, b, ratio in ties:
        neighbours[a].append((b, ratio))
        neighbours[b].append((a, 1.0 / ratio))
    positions = {root: ChainPosition(1.0, 0)}
    waiting = deque([root])
    while waiting:
        here = waiting.popleft()
        for there, ratio in neighbours[here]:
            if there not in positions:
                positions[there] = ChainPosition(
                    ratio * positions[here].ratio, positions[here].links + 1
                )
                waiting.append(there)
    return positions


def block_positions(
    document: Mechanism, assembled: AssembledMechanism, root: int, position: float
) -> Vector:
    """Return the positions (n,) [rad | m] of all blocks if the block `root` is at `position`.

    Blocks that links connect to `root` move with `root`; all other blocks keep their start
    positions. Raises ValueError if a block would be beyond its end stop.
    """
    placed = assembled.start.copy()
    for block, tied in chain_from(document, assembled, root).items():
        placed[block] += tied.ratio * (position - assembled.start[root])
    stops = assembled.packed.stops
    for name, block, low, high in zip(
        assembled.stops, stops.block.tolist(), stops.low.tolist(), stops.high.tolist(), strict=True
    ):
        slack = SAME_PLACE * max(abs(one) for one in (low, high, 0.0) if np.isfinite(one))
        if not low - slack <= placed[block] <= high + slack:
            unit = si_unit("position", assembled.kinds[block])
            problem = f"puts {assembled.blocks[block]} at {placed[block]:.9g} {unit}"
            raise ValueError(
                f"{problem}; allowed: {low:.9g} to {high:.9g} {unit}, the stops of {name}"
            )
    return placed


def _load(document: Mechanism, assembled: AssembledMechanism, root: int) -> tuple[int, float]:
    chain = chain_from(document, assembled, root)
    name = None if document.control is None else document.control.load
    if name is None:
        load = max(chain, key=lambda block: (chain[block].links, block))
        return load, chain[load].ratio
    if name not in assembled.blocks:
        raise ElementError(
            "control.load", f"found {name!r}; allowed: {', '.join(assembled.blocks)}"
        )
    load = assembled.blocks.index(name)
    if load not in chain:
        tied = ", ".join(assembled.blocks[block] for block in sorted(chain))
        raise ElementError(
            "control.load",
            f"found {name}, which is not linked to the block of the sensor; allowed: {tied}",
        )
    return load, chain[load].ratio
