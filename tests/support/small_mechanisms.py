"""Small mechanisms for the tests of `reduce`, in SI."""

from __future__ import annotations

import msgspec

from frictool.documents.mechanism import (
    Backlash,
    Belt,
    Block,
    Compliance,
    Coupling,
    FrictionOf,
    Gear,
    Link,
    Mechanism,
    Rack,
    Screw,
    Sensor,
    Source,
    Spring,
)
from frictool.documents.quantity import Quantity, Span

Q = Quantity


def rotor(inertia: float, low: float | None = None, high: float | None = None) -> Block:
    return Block(inertia=Q(inertia, low, high, "kg m^2"))


def slide(mass: float) -> Block:
    return Block(mass=Q(mass, unit="kg"))


def motor(on: str, constant: float = 0.05, limit: float = 20.0) -> Source:
    return Source(on, "current", Q(constant, unit="N m/A"), Q(limit, unit="A"))


def coulomb(on: str, level: float, unit: str = "N m") -> FrictionOf:
    return FrictionOf(on, "coulomb", {"coulomb": Q(level, unit=unit)})


def mechanism(
    blocks: dict[str, Block],
    links: dict[str, Link],
    source: str,
    sensor: str,
    travel: tuple[float, float] | None = None,
) -> Mechanism:
    """One motor on `source`, an encoder on `sensor`; travel of the sensor's block."""
    unit = "rad" if blocks[sensor].inertia is not None else "m"
    step = Q(1e-3 if unit == "rad" else 1e-5, unit=unit)
    return Mechanism(
        format="mechanism/1",
        name="built",
        blocks=blocks,
        links=links,
        sources={"motor": motor(source)},
        sensors={"encoder": Sensor(sensor, step=step)},
        travel=None if travel is None else Span(*travel, unit),
    )


def screw(
    coefficient: float,
    lead: float = 4e-3,
    radius: float = 6e-3,
    stiffness: float = 2e4,
    form: str = "angle",
) -> Mechanism:
    """Figure 2.6: motor and screw, nut, spring; the spring is pressed from 0 on."""
    links: dict[str, Link] = {
        "thread": Screw(
            ("screw", "nut"),
            Q(radius, unit="m"),
            lead=Q(lead, unit="m"),
            friction_coefficient=coefficient,
            friction_form=form,
        ),
        "spring": Spring(("nut", "ground"), stiffness=Q(stiffness, unit="N/m")),
    }
    return mechanism(
        {"screw": rotor(2e-5), "nut": slide(1.0)}, links, "screw", "screw", travel=(0.0, 12.0)
    )


def belt(stiffness: float = 2e5, damping: float = 20.0) -> Mechanism:
    """Figure 2.5 with two radii: a motor's pulley, a belt that yields, the load's pulley with the
    encoder and friction on both."""
    compliance = Compliance(
        Q(stiffness, 0.9 * stiffness, 1.1 * stiffness, "N/m"), Q(damping, unit="N s/m")
    )
    links: dict[str, Link] = {
        "belt": Belt(("a", "b"), Q(0.02, unit="m"), Q(0.04, unit="m"), compliance=compliance),
        "bearing_a": coulomb("a", 0.01),
        "bearing_b": coulomb("b", 0.04),
    }
    return mechanism({"a": rotor(2e-4), "b": rotor(6e-4)}, links, "a", "b", travel=(-20.0, 20.0))


def two_plays(first: float = 0.02, second: float = 1e-4) -> Mechanism:
    """Motor, external gear of ratio 1/5 with play at its second wheel, shaft, rack of 10 mm with
    play at the rack; friction everywhere."""
    links: dict[str, Link] = {
        "gear": Gear(("motor", "shaft"), 0.2, backlash=Backlash(Q(first, unit="rad"))),
        "rack": Rack(("shaft", "table"), Q(0.01, unit="m"), backlash=Backlash(Q(second, unit="m"))),
        "brushes": coulomb("motor", 0.02),
        "bearing": coulomb("shaft", 0.05),
        "slideway": coulomb("table", 8.0, "N"),
    }
    blocks = {"motor": rotor(2e-5), "shaft": rotor(1e-4), "table": slide(0.5)}
    return mechanism(blocks, links, "motor", "motor", travel=(-60.0, 60.0))


def lossy_train(efficiency: float = 0.9) -> Mechanism:
    """Motor, external gear of ratio 1/4 that loses, table on a rack with friction; the encoder on
    the wheel, which turns the other way."""
    links: dict[str, Link] = {
        "gear": Gear(("motor", "wheel"), 0.25, efficiency=efficiency),
        "rack": Rack(("wheel", "table"), Q(0.02, unit="m")),
        "brushes": coulomb("motor", 0.01),
        "slideway": coulomb("table", 6.0, "N"),
    }
    return mechanism(
        {"motor": rotor(3e-5), "wheel": rotor(2e-4), "table": slide(0.4)},
        links,
        "motor",
        "wheel",
        travel=(-10.0, 10.0),
    )


def shaft(first: str, second: str) -> Coupling:
    return Coupling((first, second))


def lift(weight: float = 20.0, friction: float = 8.0) -> Mechanism:
    """Motor, rack of 10 mm, table that hangs: its weight is a constant effort that pulls it
    down."""
    links: dict[str, Link] = {
        "rack": Rack(("motor", "table"), Q(0.01, unit="m")),
        "slideway": coulomb("table", friction, "N"),
    }
    found = mechanism(
        {"motor": rotor(2e-5), "table": slide(2.0)}, links, "motor", "motor", travel=(-30.0, 30.0)
    )
    pull = Source("table", "effort", effort=Q(-weight, unit="N"))
    return msgspec.structs.replace(found, sources={**found.sources, "weight": pull})
