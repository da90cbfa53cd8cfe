"""Assembly of a mechanism from its document: checks and arrays.

plant/mechanism/packed_mechanism.py defines the arrays. An error is an ElementError with the key of
the element; an assumption about an omitted value is a note.
"""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np

from frictool.adapters.mechanism.block_references import BlockNames, check_unit
from frictool.adapters.mechanism.element_packing import ElementArrays, pack_rows
from frictool.adapters.mechanism.magnitude_limits import check_sizes
from frictool.adapters.mechanism.sources_and_sensors import (
    check_sensor,
    controlled_names,
    pack_sources,
)
from frictool.adapters.mechanism.transmissions import Transmitting, transmission
from frictool.adapters.mechanism.travel_notes import travel_notes
from frictool.documents.mechanism import Cam, FrictionOf, Mechanism, Spring, Stop
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.element_error import ElementError
from frictool.plant.mechanism.fastest_link import LARGEST_RATE, rates_of
from frictool.plant.mechanism.link_graph import (
    RigidGroup,
    Transmission,
    groups_of,
    loose_parts,
    without_loops,
)
from frictool.plant.mechanism.packed_mechanism import (
    FRAME,
    Couplings,
    Joints,
    PackedMechanism,
    Pressings,
    Pushes,
    Stops,
)
from frictool.plant.mechanism.speed_scale import speed_scale
from frictool.typing import Vector


def assemble(document: Mechanism) -> AssembledMechanism:
    """Convert a mechanism document to arrays, with names of elements and notes on assumptions.

    Raises ElementError for the first invalid element.
    """
    check_sizes(document)
    blocks = BlockNames(document)
    start = _starts(document, blocks)
    links = [
        transmission(name, link, blocks)
        for name, link in document.links.items()
        if isinstance(link, get_args(Transmitting))
    ]
    inertia = [(block.inertia or block.mass).value for block in document.blocks.values()]  # type: ignore[union-attr]  # a block has one
    joints, notes = without_loops([link for link in links if link.rigid], blocks.names)
    groups = groups_of(joints, inertia, blocks.names)
    collected = _gathered(
        document, blocks, ElementArrays(document, blocks, start, notes), links, groups
    )
    sources = pack_sources(document, blocks, collected)
    sensor_blocks = _sensor_blocks(document, blocks)
    if document.control is not None:
        controlled_names(document)
    _refuse_loose(links, collected, blocks, {*sources.block, *sensor_blocks})
    collected.note_short_curves(groups)
    collected.notes += travel_notes(document, blocks, start, joints)
    packed = PackedMechanism(
        inertia=np.array(inertia, dtype=np.float64),
        scale=_scale(
            document,
            blocks,
            inertia,
            links,
            collected,
            sources.constant * sources.limit,
            sources.block,
        ),
        joints=_packed_joints(joints, start),
        couplings=pack_rows(Couplings, collected.couplings.values()),
        frictions=collected.packed_frictions(),
        pressings=pack_rows(Pressings, collected.pressings.values()),
        pushes=pack_rows(Pushes, [row for _, row in collected.pushes]),
        stops=pack_rows(Stops, collected.stops.values()),
        sources=sources,
        curves=collected.curves.packed(),
    )
    assembled = AssembledMechanism(
        blocks.names,
        blocks.kinds,
        start,
        tuple(link.name for link in joints),
        tuple(collected.couplings),
        tuple(collected.frictions),
        tuple(collected.pressings),
        tuple(name for name, _ in collected.pushes),
        tuple(collected.stops),
        tuple(document.sources),
        tuple(document.sensors),
        sensor_blocks,
        tuple(sensor.measures for sensor in document.sensors.values()),
        groups,
        tuple(collected.notes),
        packed,
    )
    return replace(assembled, notes=(*assembled.notes, *_stiff_notes(assembled)))


def _stiff_notes(assembled: AssembledMechanism) -> list[str]:
    rates = rates_of(assembled)
    stiffness = assembled.packed.couplings.stiffness
    return [
        f"{name}: the link's natural frequency of "
        f"{np.sqrt(stiffness[link] * rates.mobility[link]):.3g} rad/s is above "
        f"{LARGEST_RATE:g} rad/s, "
        "so that a simulation damps the link's oscillation critically"
        for link, name in enumerate(assembled.couplings)
        if rates.raised[link]
    ]


def _gathered(
    document: Mechanism,
    blocks: BlockNames,
    collected: ElementArrays,
    links: list[Transmission],
    groups: tuple[RigidGroup, ...],
) -> ElementArrays:
    for link in links:
        if not link.rigid:
            collected.coupling(link)
    for name, element in document.links.items():
        match element:
            case Spring():
                collected.spring(name, element)
            case Cam():
                collected.cam(name, element)
            case Stop():
                collected.stop(name, element)
            case FrictionOf():
                collected.friction(
                    name, element, _carried(blocks.index(f"links.{name}.on", element.on), groups)
                )
    return collected


def _sensor_blocks(document: Mechanism, blocks: BlockNames) -> tuple[int, ...]:
    for name, sensor in document.sensors.items():
        check_sensor(name, sensor, blocks)
    return tuple(
        blocks.index(f"sensors.{name}.on", sensor.on) for name, sensor in document.sensors.items()
    )


def _starts(document: Mechanism, blocks: BlockNames) -> Vector:
    for name, block in document.blocks.items():
        check_unit(
            f"blocks.{name}.start",
            block.start,
            "position",
            blocks.kind(f"blocks.{name}", name),
            "the block",
        )
    return np.array(
        [0.0 if block.start is None else block.start.value for block in document.blocks.values()]
    )


def _carried(block: int, groups: tuple[RigidGroup, ...]) -> float:
    group = next(group for group in groups if block in group.blocks)
    return group.inertia / group.ratios[group.blocks.index(block)] ** 2


def _packed_joints(joints: list[Transmission], start: Vector) -> Joints:
    rows = [
        (
            link.a,
            link.b,
            link.ratio,
            start[link.b] - link.ratio * start[link.a],
            link.gap,
            link.restitution,
            link.drive_loss,
            link.back_loss,
            link.thread,
            link.thesis_screw,
        )
        for link in joints
    ]
    return pack_rows(Joints, rows)


def _refuse_loose(
    links: list[Transmission], collected: ElementArrays, blocks: BlockNames, driven: set[int]
) -> None:
    """Raise ElementError for a group of blocks without source, sensor or element on the frame."""
    pairs = [(link.a, link.b) for link in links]
    pairs += [(row.a, row.b) for row in collected.couplings.values() if row.a != FRAME]
    for part in loose_parts(pairs, driven | collected.grounded, len(blocks.names)):
        names = ", ".join(blocks.names[block] for block in part)
        raise ElementError(
            f"blocks.{blocks.names[part[0]]}",
            f"nothing connects {names} to the rest of the mechanism or to the ground; add a link, "
            "or a spring, friction or stop on the ground, or remove this part",
        )


def _scale(
    document: Mechanism,
    blocks: BlockNames,
    inertia: list[float],
    links: list[Transmission],
    collected: ElementArrays,
    efforts: Vector,
    pushed: np.ndarray[tuple[int], np.dtype[np.int64]],
) -> Vector:
    ratios = [(link.a, link.b, link.ratio) for link in links]
    ratios += [(a, b, 1.0) for a, b in collected.springs if a != FRAME]
    known = None
    if document.top_speed is not None or document.travel is not None:
        _, sensor = controlled_names(document)
        block = document.sensors[sensor].on
        kind = blocks.kind(f"sensors.{sensor}.on", block)
        check_unit("top_speed", document.top_speed, "velocity", kind, f"the sensor's block {block}")
        check_unit("travel", document.travel, "position", kind, f"the sensor's block {block}")
        if document.top_speed is not None:
            known = (blocks.index("top_speed", block), document.top_speed.value)
    return speed_scale(
        inertia,
        blocks.kinds,
        ratios,
        list(zip(pushed.tolist(), efforts.tolist(), strict=True)),
        known,
        blocks.names,
    )
