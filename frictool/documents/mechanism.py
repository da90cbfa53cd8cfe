"""`mechanism.yaml`: blocks, the links between them, friction, sources and sensors (thesis 2.1,
2.2); read whole before it is put together.

Each block has one coordinate q: an angle [rad] where it has an `inertia`, a way [m] where it has a
`mass`. A link is named and says its kind; `between` names its ends, the driving end first; `ground`
is the frame. Positions of blocks count from `start`, where every rigid link fits, every backlash
stands in its middle and no compliance is strained.

A quantity's unit says which end it belongs to where ends may be rotary or linear: a rack's backlash
of 3 rad is the pinion's, one of 0.6 mm the rack's. What fits with what is checked when the
mechanism is put together (plant/mechanism/assembly.py).
"""

from __future__ import annotations

import itertools
from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber, SamplePeriod, Winding
from frictool.documents.quantity import Quantity, Series, Span, _of

# of either kind of axis: the unit tells which
EitherPosition = Annotated[Quantity, _of("position of either axis")]
EitherWidth = Annotated[Quantity, _of("position of either axis", 0.0, exclusive=True)]
EitherStiffness = Annotated[Quantity, _of("stiffness of either axis", 0.0, exclusive=True)]
EitherDamping = Annotated[Quantity, _of("viscous of either axis", 0.0)]
EitherEffort = Annotated[Quantity, _of("effort of either axis")]
EitherSpan = Annotated[Span, _of("position of either axis")]
EitherSpeed = Annotated[Quantity, _of("velocity of either axis", 0.0, exclusive=True)]
EitherConstant = Annotated[Quantity, _of("constant of either axis", 0.0, exclusive=True)]
# whatever the block is
RotaryInertia = Annotated[Quantity, _of("rotary inertia", 0.0)]
LinearMass = Annotated[Quantity, _of("mass", 0.0)]
Angle = Annotated[Quantity, _of("angle", 0.0, exclusive=True)]
Length = Annotated[Quantity, _of("length", 0.0, exclusive=True)]
Area = Annotated[Quantity, _of("area", 0.0, exclusive=True)]
AnyParameter = Annotated[Quantity, _of("any")]

Efficiency = Annotated[float, msgspec.Meta(gt=0, le=1)]
BackEfficiency = Annotated[float, msgspec.Meta(ge=-10, le=1)]
Restitution = Annotated[float, msgspec.Meta(ge=0, le=0.95)]
Coefficient = Annotated[float, msgspec.Meta(ge=0, le=10)]
Factor = Annotated[float, msgspec.Meta(ge=0, le=1e6)]
Ends = Annotated[
    tuple[str, ...], msgspec.Meta(min_length=1, max_length=2)
]  # one end alone is refused where ground can be told of
GROUND = "ground"


class Block(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A part that moves, or parts that move together (2.1)-(2.2): `inertia` where it turns, `mass`
    where it slides."""

    inertia: RotaryInertia | None = None
    mass: LinearMass | None = None
    start: EitherPosition | None = None

    def __post_init__(self) -> None:
        if (self.inertia is None) == (self.mass is None):
            raise ValueError("give inertia, of a block that turns, or mass, of one that slides")


class Curve(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A quantity over the position: a monotone cubic between the points, beyond them as at the
    ends."""

    position: Annotated[Series, _of("position of either axis")]
    value: Annotated[Series, _of("any mechanical")]

    def __post_init__(self) -> None:
        _check_points(self.position.values, self.value.values)


def _check_points(positions: tuple[float, ...], values: tuple[float, ...]) -> None:
    if len(positions) != len(values):
        raise ValueError(
            f"found {len(positions)} positions and {len(values)} values; allowed: as many of each"
        )
    if len(positions) < 2 or any(b <= a for a, b in itertools.pairwise(positions)):
        raise ValueError("position: allowed: at least 2 values, rising")


class Level(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A factor over the position, between and beyond the points as a `Curve`."""

    position: Annotated[Series, _of("position of either axis")]
    factor: tuple[Factor, ...]

    def __post_init__(self) -> None:
        _check_points(self.position.values, self.factor)


class Compliance(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A link that yields: stiffness and damping at its second end (2.5), K_i and K; a belt's along
    the belt."""

    stiffness: EitherStiffness
    damping: EitherDamping


class Backlash(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A free play of full `width` (2.18), at the end that its unit tells; of two with one unit at
    the second, or at the block `at`.

    The flanks are rigid, and throw back `restitution` of the speed at which they meet; or they
    yield (`compliance`): then they rebound as 4.4.4 observes.
    """

    width: EitherWidth
    at: str | None = None
    restitution: Restitution = 0.0
    compliance: Compliance | None = None

    def __post_init__(self) -> None:
        if self.compliance is not None and self.restitution:
            raise ValueError(
                "restitution belongs to rigid flanks; compliant ones rebound by their stiffness and damping"
            )


class Gear(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="gear",
):
    """omega_b = -ratio omega_a (2.3), or + for an internal one. Efficiencies:
    docs/theory/mechanism.md; back: 2 - 1/efficiency."""

    between: Ends
    ratio: float
    internal: bool = False
    efficiency: Efficiency = 1.0
    efficiency_back: BackEfficiency | None = None
    compliance: Compliance | None = None
    backlash: Backlash | None = None


class Belt(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="belt",
):
    """radius_b omega_b = radius_a omega_a (2.6); stiffness and damping of `compliance` are along
    the belt, N/m and N s/m."""

    between: Ends
    radius_a: Length
    radius_b: Length
    crossed: bool = False
    efficiency: Efficiency = 1.0
    efficiency_back: BackEfficiency | None = None
    compliance: Compliance | None = None


class Screw(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="screw",
):
    """v_nut = radius tan(lead_angle) omega_screw (2.10)-(2.13). `lead`, a way per turn, in place of
    the angle.

    friction_coefficient: mu of the thread. friction_form: `angle`, exact for a square thread,
    torque radius tan(alpha ± atan mu) f; `thesis`, (2.12) as printed. Or efficiency, as of a gear.
    """

    between: Ends
    radius: Length
    lead_angle: Angle | None = None
    lead: Length | None = None
    left_handed: bool = False
    friction_coefficient: Coefficient | None = None
    friction_form: Literal["angle", "thesis"] = "angle"
    efficiency: Efficiency | None = None
    efficiency_back: BackEfficiency | None = None
    compliance: Compliance | None = None
    backlash: Backlash | None = None

    def __post_init__(self) -> None:
        if (self.lead_angle is None) == (self.lead is None):
            raise ValueError("give lead_angle or lead, the nut's way per turn")
        if self.friction_coefficient is not None and self.efficiency is not None:
            raise ValueError("give friction_coefficient or efficiency, not both")
        if self.efficiency_back is not None and self.efficiency is None:
            raise ValueError("efficiency_back belongs to efficiency")


class Rack(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="rack",
):
    """v_rack = radius omega_pinion (2.19); the radius may be that of a reducer and a pinion
    together, the r of (2.20)."""

    between: Ends
    radius: Length
    reversed: bool = False
    efficiency: Efficiency = 1.0
    efficiency_back: BackEfficiency | None = None
    compliance: Compliance | None = None
    backlash: Backlash | None = None


class Hydraulic(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="hydraulic",
):
    """x_b = area_a/area_b x_a, F_a = area_a/area_b F_b (2.16): master and slave pistons, the
    fluid's inertia and friction left out."""

    between: Ends
    area_a: Area
    area_b: Area
    compliance: Compliance | None = None


class Coupling(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="coupling",
):
    """Two blocks of one kind move together: a shaft or a rod, rigid, compliant, or with
    backlash."""

    between: Ends
    compliance: Compliance | None = None
    backlash: Backlash | None = None


class Spring(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="spring",
):
    """Pulls its first end towards `free`, measured as q_a - q_b (q_a against ground), by
    `stiffness` or by a `force` curve over q_a - q_b.

    A positive force of the curve opposes a positive q_a. preload: force that opposes at the start,
    beside what stiffness gives.
    """

    between: Ends
    stiffness: EitherStiffness | None = None
    force: Curve | None = None
    damping: EitherDamping | None = None
    free: EitherPosition | None = None
    preload: EitherEffort | None = None

    def __post_init__(self) -> None:
        if self.stiffness is not None and self.force is not None:
            raise ValueError("give stiffness or a force curve, not both")
        if self.stiffness is None and self.force is None and self.damping is None:
            raise ValueError(
                "give stiffness, a force curve or damping: without any of them the spring does nothing"
            )
        if self.force is not None and (self.free is not None or self.preload is not None):
            raise ValueError(
                "free and preload belong to stiffness; a force curve says what holds at each position"
            )


class Cam(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="cam",
):
    """A spring presses a roller onto a profile of the block `on`, and the block onto its slideway,
    (2.23) with the sign of (2.28).

    force: of the spring, normal to the motion. angle: of the profile. The block feels force
    tan(angle) in its positive direction, and Coulomb friction friction_coefficient * force; its
    breakaway is `breakaway_ratio` times that.
    """

    on: str
    force: Curve
    angle: Curve
    friction_coefficient: Coefficient = 0.0
    breakaway_ratio: Annotated[float, msgspec.Meta(ge=1, le=10)] = 1.0


class Stop(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="stop",
):
    """End stops of a block: rigid ones throw back `restitution` of the speed; compliant ones push
    back."""

    on: str
    low: EitherPosition | None = None
    high: EitherPosition | None = None
    restitution: Restitution = 0.0
    compliance: Compliance | None = None

    def __post_init__(self) -> None:
        if self.low is None and self.high is None:
            raise ValueError("give low, high or both")
        if self.low is not None and self.high is not None and self.low.value >= self.high.value:
            raise ValueError("low lies above high; allowed: low < high")
        if self.compliance is not None and self.restitution:
            raise ValueError(
                "restitution belongs to rigid stops; compliant ones rebound by their stiffness and damping"
            )


class FrictionOf(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="friction",
):
    """Bearing or slideway of the block `on` against the frame, by any law of
    friction/law_registry.py and its parameters, by their names there.

    level: a factor of all its efforts over the position.
    """

    on: str
    law: str
    parameters: dict[str, AnyParameter]
    level: Level | None = None


Link = Gear | Belt | Screw | Rack | Hydraulic | Coupling | Spring | Cam | Stop | FrictionOf


class Source(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What drives the block `on`: a current or voltage by its constant, limit and loop, or an
    effort itself.

    effort: constant, there from the start (a weight); a scenario adds to it.
    """

    on: str
    drive: Literal["current", "voltage", "effort"]
    constant: EitherConstant | None = None
    limit: Annotated[Quantity, _of("any drive", 0.0, exclusive=True)] | None = None
    loop_time_constant_s: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.0
    winding: Winding | None = None
    effort: EitherEffort | None = None

    def __post_init__(self) -> None:
        if (self.drive == "effort") == (self.constant is not None):
            raise ValueError(
                "constant, effort per ampere or volt, belongs to drive current and voltage, which need it"
            )
        if self.effort is not None and self.drive != "effort":
            raise ValueError("effort, a constant one, belongs to drive: effort")
        if self.winding is not None and self.drive != "current":
            raise ValueError("winding is for drive: current; a voltage is limited by `limit`")


class Sensor(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What is measured of the block `on`; a position by an encoder of so many counts per revolution
    or of a step, or perfectly."""

    on: str
    measures: Literal["position", "velocity"] = "position"
    counts_per_revolution: PositiveNumber | None = None
    step: EitherWidth | None = None

    def __post_init__(self) -> None:
        if self.counts_per_revolution is not None and self.step is not None:
            raise ValueError("give counts_per_revolution or step, not both")
        if self.measures == "velocity" and (
            self.counts_per_revolution is not None or self.step is not None
        ):
            raise ValueError("counts belong to measures: position")


class Control(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Which source a controller commands and which sensor it sees, where there are several.

    load: the block whose position is the load's; otherwise the one that the most links lie between
    and the sensor.
    """

    source: str
    sensor: str
    load: str | None = None


class Mechanism(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`mechanism.yaml`. travel, top_speed: of the controlled sensor's block, as in a bench."""

    format: Literal["mechanism/1"]
    name: Name
    blocks: dict[str, Block]
    sample_period_s: SamplePeriod = 0.001
    delay_samples: Annotated[int, msgspec.Meta(ge=0, le=2)] = 1
    links: dict[str, Link] = {}
    sources: dict[str, Source] = {}
    sensors: dict[str, Sensor] = {}
    control: Control | None = None
    travel: EitherSpan | None = None
    top_speed: EitherSpeed | None = None
