"""First step of a reduction: express every block in the coordinate of the source (thesis 2.16).

The step is exact with one exception. For a thread, the step uses the friction at a steady speed;
the true friction of thesis (2.12) depends on the whole torque of the motor.

After the step, all links between two blocks are couplings, or gears of ratio 1 with losses. Only
links of rotary blocks can have losses. If the source is linear and a link has losses, the step
therefore uses the coordinate of the rotary block nearest to the source (the reference block).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import msgspec

from frictool.adapters.mechanism.sources_and_sensors import controlled_names
from frictool.documents.mechanism import (
    GROUND,
    Backlash,
    Block,
    Cam,
    Compliance,
    Control,
    Coupling,
    FrictionOf,
    Gear,
    Link,
    Mechanism,
    Screw,
    Spring,
    Stop,
)
from frictool.documents.quantity import Axis, Quantity, Span, si_unit
from frictool.errors import NoSolutionError
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.connections import BlockMotion, Connection, connections, seen_from
from frictool.reduce.coordinate_frame import CoordinateFrame, scaled
from frictool.reduce.step_report import StepFigure, StepReport

SAME = 1e-9  # relative tolerance of equal ratios


@dataclass(frozen=True)
class MechanismView:
    """Mechanism with the motion of its blocks relative to a root block.

    root: number of the root block.
    seen: motion of each block relative to the root, by the block's number.
    axis: kind of the root, rotary or linear.
    """

    document: Mechanism
    assembled: AssembledMechanism
    links: tuple[Connection, ...]
    root: int
    seen: Mapping[int, BlockMotion]
    axis: Axis

    def frame(self, block: str) -> CoordinateFrame:
        """Return the map from a block's coordinate to the root's; the ground has the ratio 0."""
        axis = self.axis
        if block == GROUND:
            return CoordinateFrame(0.0, 0.0, axis, axis)
        number = self.assembled.blocks.index(block)
        one = self.seen[number]
        return CoordinateFrame(one.ratio, one.offset, axis, self.assembled.kinds[number])


def view(mechanism: Mechanism, root: str) -> MechanismView:
    """Return the mechanism with the motion of its blocks relative to the block `root`.

    Raises NoSolutionError if a block does not move with the root.
    """
    assembled = assemble_cached(mechanism)
    links = connections(assembled)
    number = assembled.blocks.index(root)
    seen = seen_from(number, links, assembled.blocks)
    apart = [name for k, name in enumerate(assembled.blocks) if k not in seen]
    if apart:
        raise NoSolutionError(
            f"{mechanism.name}: {', '.join(apart)} {('does' if len(apart) == 1 else 'do')}"
            f" not move with {root}: a one-inertia model has one motion; reduce each part "
            "separately"
        )
    return MechanismView(mechanism, assembled, links, number, seen, assembled.kinds[number])


def from_source(mechanism: Mechanism, source: str) -> tuple[Mechanism, StepReport]:
    """Return the mechanism in the coordinate of the reference block of `source`, with a report.

    Raises NoSolutionError if a block does not move with the reference block, or if a spring
    connects two blocks with different ratios.
    """
    here = from_reference(mechanism, source)
    ratio = si_unit("position", here.axis)
    names = here.assembled.blocks
    figures = [
        StepFigure(
            f"ratio of {name}",
            here.frame(name).ratio,
            f"{si_unit('position', here.frame(name).block_axis)}/{ratio}",
        )
        for name in names
        if here.frame(name).ratio != 1.0
    ]
    did = (
        f"every block in the coordinate of {names[here.root]}: "
        "masses times ratio^2, efforts times ratio, distances divided by ratio"
    )
    # stated explicitly, because a later step may remove the effort of a source
    control = mechanism.control or Control(source, controlled_names(mechanism)[1])
    reduced = msgspec.structs.replace(expressed(here), control=control)
    threads = ", ".join(
        name
        for name, one in mechanism.links.items()
        if isinstance(one, Screw) and one.friction_form == "thesis"
    )
    neglects = (
        f"the accelerating torque (friction_form: thesis) of {threads}" if threads else "nothing"
    )
    return reduced, StepReport("coordinates", did, neglects, figures=tuple(figures))


def at_sensor(
    mechanism: Mechanism, whole: Mechanism, source: str, sensor: str
) -> tuple[Mechanism, StepReport]:
    """Return a mechanism in the coordinate of the sensor.

    The coordinate is the measured position, with the sign for which the position rises under a
    positive command.
    """
    root = mechanism.sources[source].on
    there = sensor_frame(whole, source, sensor)
    size = abs(there.ratio)
    side = 1.0 if there.ratio > 0.0 else -1.0
    here = view(mechanism, root)
    ratio = 1.0 / size
    offset = -side * there.offset / size
    seen = {number: BlockMotion(ratio, offset) for number in here.seen}
    reduced = expressed(
        MechanismView(mechanism, here.assembled, here.links, here.root, seen, there.block_axis)
    )
    notes = (
        ()
        if side > 0.0
        else (f"{sensor} counts down for a positive command: encoder.direction is -1 in the bench",)
    )
    did = f"the coordinate of {whole.sensors[sensor].on}, where {sensor} measures"
    unit = f"{si_unit('position', there.block_axis)}/{si_unit('position', there.axis)}"
    return reduced, StepReport(
        "sensor",
        did,
        "nothing",
        figures=(
            StepFigure("distance at the sensor per distance at the source", there.ratio, unit),
        ),
        notes=notes,
    )


def sensor_frame(whole: Mechanism, source: str, sensor: str) -> CoordinateFrame:
    """Return the map between the coordinates of the sensor's block and the reference block."""
    return from_reference(whole, source).frame(whole.sensors[sensor].on)


def from_reference(whole: Mechanism, source: str) -> MechanismView:
    """Return the mechanism with motions relative to the reference block of `source`."""
    return view(whole, _reference(whole, whole.sources[source].on))


def expressed(here: MechanismView) -> Mechanism:
    """Return the mechanism with all blocks in the coordinate of the root."""
    mechanism = here.document
    links: dict[str, Link] = {}
    for name, link in mechanism.links.items():
        links |= _link(here, name, link)
    return msgspec.structs.replace(
        mechanism,
        blocks={name: _block(here, name, mechanism.blocks[name]) for name in here.assembled.blocks},
        links=links,
        sources={
            name: here.frame(one.on).source(one, one.on) for name, one in mechanism.sources.items()
        },
        sensors={
            name: here.frame(one.on).sensor(one, one.on) for name, one in mechanism.sensors.items()
        },
        **_bench_keys(here),
    )


def _reference(mechanism: Mechanism, on: str) -> str:
    here = view(mechanism, on)
    if here.assembled.kinds[here.root] == "rotary" or all(link.lossless for link in here.links):
        return on
    turning = [k for k in here.seen if here.assembled.kinds[k] == "rotary"]
    return str(here.assembled.blocks[min(turning, key=lambda k: (len(here.seen[k].by), k))])


def _block(here: MechanismView, name: str, block: Block) -> Block:
    frame = here.frame(name)
    mass = block.inertia if block.inertia is not None else block.mass
    assert mass is not None
    inertia = frame.inertia(mass)
    start = (
        None
        if block.start is None and frame.offset == 0.0
        else frame.position(block.start or Quantity(0.0))
    )
    return Block(inertia, None, start) if frame.axis == "rotary" else Block(None, inertia, start)


def _link(here: MechanismView, name: str, link: Link) -> dict[str, Link]:
    if isinstance(link, Spring):
        return _spring(here, name, link)
    on: dict[type, Callable[..., Link]] = {
        Cam: CoordinateFrame.cam,
        Stop: CoordinateFrame.stop,
        FrictionOf: CoordinateFrame.friction,
    }
    if isinstance(link, Cam | Stop | FrictionOf):
        return {name: on[type(link)](here.frame(link.on), link, link.on)}
    # empty for a link that closes a rigid loop without adding a constraint
    matching = [one for one in here.links if one.name == name]
    return {one.name: _between(here, one, link) for one in matching}


def _between(here: MechanismView, one: Connection, link: Link) -> Link:
    names = here.assembled.blocks
    ends, frame = (names[one.a], names[one.b]), here.frame(names[one.b])
    compliance = _compliance(one, frame, getattr(link, "compliance", None))
    backlash = _backlash(one, frame, getattr(link, "backlash", None))
    if one.lossless:
        return Coupling(ends, compliance, backlash)
    efficiency, back = efficiencies(one)
    return Gear(
        ends,
        1.0,
        True,
        efficiency,
        back,
        None if backlash is not None and backlash.compliance is not None else compliance,
        backlash,
    )


def efficiencies(one: Connection) -> tuple[float, float]:
    """Return the link's efficiencies: while `a` drives `b`, and while `b` drives `a`."""
    carried = abs(one.ratio)
    return carried / (carried + one.drive_loss), 1.0 - one.back_loss / carried


def _compliance(
    one: Connection, frame: CoordinateFrame, stated: Compliance | None
) -> Compliance | None:
    """Return the link's stiffness and damping in the coordinate of the frame, with their intervals.

    `stated` are the values of the document. For a belt, these values refer to the motion along the
    belt. The result is None for a rigid link.
    """
    if stated is None or not one.compliant:
        return None
    return Compliance(
        frame.stiffness(scaled(stated.stiffness, one.stiffness / stated.stiffness.value, "")),
        frame.damping(
            scaled(
                stated.damping,
                one.damping / stated.damping.value if stated.damping.value else 1.0,
                "",
            )
        ),
    )


def _backlash(one: Connection, frame: CoordinateFrame, stated: Backlash | None) -> Backlash | None:
    if stated is None:
        return None
    width = frame.width(scaled(stated.width, 2.0 * one.gap / stated.width.value, ""))
    return Backlash(width, None, stated.restitution, _compliance(one, frame, stated.compliance))


def _spring(here: MechanismView, name: str, spring: Spring) -> dict[str, Link]:
    first, second = (here.frame(end) for end in spring.between)
    if GROUND in spring.between or first.ratio != second.ratio:
        moving = [end for end in spring.between if end != GROUND]
        if len(moving) == 2 and not _one_body(here, moving):
            raise NoSolutionError(
                f"links.{name}: {moving[0]} and {moving[1]} move {first.ratio:.6g} and "
                f"{second.ratio:.6g} times as far as the source; allowed: equal ratios; use a "
                "link with ratio and compliance"
            )
        stretch = CoordinateFrame(
            first.ratio - second.ratio, first.offset - second.offset, first.axis, first.block_axis
        )
        return {name: stretch.spring(spring, moving[0])}
    stretch = CoordinateFrame(
        first.ratio, first.offset - second.offset, first.axis, first.block_axis
    )
    return {
        name: msgspec.structs.replace(
            stretch.spring(spring, spring.between[0]), between=spring.between
        )
    }


def _one_body(here: MechanismView, blocks: list[str]) -> bool:
    factors = [here.seen[here.assembled.blocks.index(name)].by for name in blocks]
    apart = {link.name for link in factors[0]} ^ {link.name for link in factors[1]}
    return all(not link.compliant and link.gap == 0.0 for link in here.links if link.name in apart)


def _bench_keys(here: MechanismView) -> dict[str, Span | Quantity]:
    document = here.document
    values = dict[str, Span | Quantity]()
    sensor = controlled_names(document)[1]
    frame = here.frame(document.sensors[sensor].on)
    if document.travel is not None:
        ends = sorted(
            (end - frame.offset) / frame.ratio
            for end in (document.travel.low, document.travel.high)
        )
        values["travel"] = Span(ends[0], ends[1], si_unit("position", frame.axis))
    if document.top_speed is not None:
        values["top_speed"] = scaled(
            document.top_speed, 1.0 / abs(frame.ratio), si_unit("velocity", frame.axis)
        )
    return values
