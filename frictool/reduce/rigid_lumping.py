"""Merging of blocks that are linked rigidly, without backlash or loss (thesis 2.1.5, 2.2.4).

The step is exact. All blocks are in the coordinate of one block (coordinate_change.py), so that
every link has the ratio 1.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping

import msgspec

from frictool.documents.mechanism import GROUND, Block, Link, Mechanism
from frictool.documents.quantity import Quantity
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.connections import connections, seen_from
from frictool.reduce.step_report import StepFigure, StepReport


def lump_rigid_links(mechanism: Mechanism, root: str) -> tuple[Mechanism, StepReport]:
    """Merge rigidly linked blocks, with their elements, into the block nearest to `root`."""
    into = bodies(mechanism, root)
    masses: dict[str, list[Quantity]] = {}
    for name, block in mechanism.blocks.items():
        masses.setdefault(into[name], []).append(mass_of(block))
    blocks = {
        name: with_mass(mechanism.blocks[name], functools.reduce(added, masses[name]))
        for name in mechanism.blocks
        if name in masses
    }
    links = {
        name: moved
        for name, link in mechanism.links.items()
        if (moved := _moved(link, into)) is not None
    }
    control = mechanism.control
    if control is not None and control.load is not None:
        control = msgspec.structs.replace(control, load=into[control.load])
    reduced = msgspec.structs.replace(
        mechanism,
        control=control,
        blocks=blocks,
        links=links,
        sources={
            name: msgspec.structs.replace(one, on=into[one.on])
            for name, one in mechanism.sources.items()
        },
        sensors={
            name: msgspec.structs.replace(one, on=into[one.on])
            for name, one in mechanism.sensors.items()
        },
    )
    return reduced, StepReport(
        "rigid links", _did(mechanism, into), "nothing", figures=_figures(blocks)
    )


def bodies(mechanism: Mechanism, root: str) -> dict[str, str]:
    """Return, for each block, the name of the block into which it is merged."""
    assembled = assemble_cached(mechanism)
    names = assembled.blocks
    links = connections(assembled)
    far = {
        number: len(seen.by) for number, seen in seen_from(names.index(root), links, names).items()
    }
    body = list(range(len(names)))
    for link in links:
        if link.plain:
            one, other = sorted((body[link.a], body[link.b]), key=lambda k: (far[k], k))
            body = [one if number == other else number for number in body]
    return {name: str(names[body[k]]) for k, name in enumerate(names)}


def mass_of(block: Block) -> Quantity:
    """Return the block's inertia or mass."""
    mass = block.inertia if block.inertia is not None else block.mass
    assert mass is not None
    return mass


def with_mass(block: Block, mass: Quantity) -> Block:
    """Return a copy of the block with the inertia or mass `mass`."""
    return msgspec.structs.replace(block, **{"mass" if block.inertia is None else "inertia": mass})


def added(one: Quantity, other: Quantity) -> Quantity:
    """Return the sum of two quantities, with the sum of their intervals if one has an interval."""
    ends: list[float | None] = [None, None]
    if any(end is not None for end in (one.low, one.high, other.low, other.high)):
        ends = [a + b for a, b in zip(one.interval, other.interval, strict=True)]
    return Quantity(one.value + other.value, ends[0], ends[1], one.unit)


def _moved(link: Link, into: Mapping[str, str]) -> Link | None:
    if not hasattr(link, "between"):
        return msgspec.structs.replace(link, on=into[link.on])
    ends = tuple(end if end == GROUND else into[end] for end in link.between)
    if ends[0] == ends[1]:
        return None
    return msgspec.structs.replace(link, between=ends)


def _did(mechanism: Mechanism, into: Mapping[str, str]) -> str:
    bodies: dict[str, list[str]] = {}
    for name in mechanism.blocks:
        bodies.setdefault(into[name], []).append(name)
    joined = [f"{' + '.join(parts)} on {body}" for body, parts in bodies.items() if len(parts) > 1]
    return (
        "; ".join(joined) if joined else "no two blocks are rigidly linked without backlash or loss"
    )


def _figures(blocks: Mapping[str, Block]) -> tuple[StepFigure, ...]:
    return tuple(
        StepFigure(
            f"{'mass' if one.inertia is None else 'inertia'} of {name}",
            mass_of(one).value,
            mass_of(one).unit,
        )
        for name, one in blocks.items()
    )
