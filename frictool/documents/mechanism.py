"""`mechanism.yaml`: blocks, links, friction, sources and sensors of a mechanism (thesis 2.1, 2.2).

Each block has one coordinate q: an angle [rad] if it has an `inertia`, a distance [m] if it has a
`mass`. A link has a name and a kind. `between` names its ends, the driving end first; `ground` is
the frame. Positions of blocks count from `start`. There, every rigid link is consistent, every
backlash is centred and no compliance is strained.

If the ends of a link can be rotary or linear, the unit of a quantity determines the end that it
belongs to: a rack's backlash of 3 rad is the pinion's, one of 0.6 mm the rack's. The links'
compatibility is checked when the mechanism is assembled (plant/mechanism/assembly.py).
"""

from __future__ import annotations

import itertools
from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber, SamplePeriod, Winding
from frictool.documents.quantity import Quantity, Series, Span, _of

# quantities of a rotary or a linear block: the unit decides
EitherPosition = Annotated[Quantity, _of("position of either axis")]
EitherWidth = Annotated[Quantity, _of("position of either axis", 0.0, exclusive=True)]
EitherStiffness = Annotated[Quantity, _of("stiffness of either axis", 0.0, exclusive=True)]
EitherDamping = Annotated[Quantity, _of("viscous of either axis", 0.0)]
EitherEffort = Annotated[Quantity, _of("effort of either axis")]
EitherSpan = Annotated[Span, _of("position of either axis")]
EitherSpeed = Annotated[Quantity, _of("velocity of either axis", 0.0, exclusive=True)]
EitherConstant = Annotated[Quantity, _of("constant of either axis", 0.0, exclusive=True)]
# quantities of one kind of axis, whatever the block is
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
]  # a single end is an error unless `ground` is allowed as the other
GROUND = "ground"


class Block(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Rigid body (2.1)-(2.2): a rotary one has an `inertia`, a linear one a `mass`."""

    inertia: RotaryInertia | None = None
    mass: LinearMass | None = None
    start: EitherPosition | None = None

    def __post_init__(self) -> None:
        if (self.inertia is None) == (self.mass is None):
            raise ValueError("give inertia, of a block that turns, or mass, of one that slides")


class Curve(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Quantity over position: monotone cubic between the points, constant beyond them."""

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
    """Factor as a function of position, interpolated as a `Curve`."""

    position: Annotated[Series, _of("position of either axis")]
    factor: tuple[Factor, ...]

    def __post_init__(self) -> None:
        _check_points(self.position.values, self.factor)


class Compliance(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Elasticity of a link: stiffness K_i and damping K at its second end (2.5).

    Those of a belt are along the belt.
    """

    stiffness: EitherStiffness
    damping: EitherDamping


class Backlash(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Free play of full `width` (2.18).

    The unit of `width` determines the end that it belongs to. If both ends have this unit, it is
    the second end, or the block `at`. Rigid flanks rebound with `restitution` times the impact
    speed. Elastic flanks (`compliance`) rebound as observed in 4.4.4.
    """

    width: EitherWidth
    at: str | None = None
    restitution: Restitution = 0.0
    compliance: Compliance | None = None

    def __post_init__(self) -> None:
        if self.compliance is not None and self.restitution:
            raise ValueError(
                "restitution belongs to rigid flanks; compliant ones rebound by their "
                "stiffness and damping"
            )


class Gear(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="gear",
):
    """Gear omega_b = -ratio omega_a (2.3); the sign is + for an internal gear.

    Efficiencies are defined in docs/theory/mechanism.md; the default of `efficiency_back` is 2 -
    1/efficiency.
    """

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
    """Belt radius_b omega_b = radius_a omega_a (2.6).

    Stiffness and damping of `compliance` are along the belt, in N/m and N s/m.
    """

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
    """Screw v_nut = radius tan(lead_angle) omega_screw (2.10)-(2.13).

    `lead`, a distance per turn, can replace the angle. `friction_coefficient`: mu of the thread.
    `friction_form`: `angle` is exact for a square thread, with the torque radius tan(alpha ± atan
    mu) f; `thesis` is (2.12) as printed. An `efficiency`, as of a gear, can replace the
    coefficient.
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
    """Rack v_rack = radius omega_pinion (2.19).

    `radius` can be that of a reducer and a pinion together, the r of (2.20).
    """

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
    """Master and slave piston x_b = area_a/area_b x_a, F_a = area_a/area_b F_b (2.16).

    Inertia and friction of the fluid are neglected.
    """

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
    """Shaft or rod between two blocks of one kind: rigid, compliant, or with backlash."""

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
    """Spring that pulls q_a - q_b (q_a against ground) towards `free`.

    The force is given by `stiffness`, or by the curve `force` over q_a - q_b. A positive force of
    the curve opposes a positive q_a. `preload`: additional opposing force at the start position.
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
                "give stiffness, a force curve or damping: without any of them the "
                "spring does nothing"
            )
        if self.force is not None and (self.free is not None or self.preload is not None):
            raise ValueError(
                "free and preload belong to stiffness; a force curve says what holds "
                "at each position"
            )


class Cam(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="cam",
):
    """Cam on the block `on`, (2.23) with the sign of (2.28).

    A spring presses a roller onto a profile of the block. It also presses the block onto its
    slideway. `force`: force of the spring, normal to the motion. `angle`: angle of the profile. The
    block is subject to force tan(angle) in its positive direction and to the Coulomb friction
    friction_coefficient * force. Its breakaway is `breakaway_ratio` times the Coulomb friction.
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
    """End stops of a block.

    Rigid stops reflect `restitution` times the speed; compliant ones push back.
    """

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
                "restitution belongs to rigid stops; compliant ones rebound by their "
                "stiffness and damping"
            )


class FrictionOf(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="friction",
):
    """Friction of the block `on` against the frame, in a bearing or a slideway.

    `law` and `parameters` have their names in friction/law_registry.py. `level`: factor of all
    efforts of the law over the position.
    """

    on: str
    law: str
    parameters: dict[str, AnyParameter]
    level: Level | None = None


Link = Gear | Belt | Screw | Rack | Hydraulic | Coupling | Spring | Cam | Stop | FrictionOf


class Source(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Drive of the block `on`: a current or voltage drive, or an effort.

    A current or voltage drive has a constant, a limit and a loop. `effort`: constant from the start
    (a weight); a scenario adds to it.
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
                "constant, effort per ampere or volt, belongs to drive current and "
                "voltage, which need it"
            )
        if self.effort is not None and self.drive != "effort":
            raise ValueError("effort, a constant one, belongs to drive: effort")
        if self.winding is not None and self.drive != "current":
            raise ValueError("winding is for drive: current; a voltage is limited by `limit`")


class Sensor(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Sensor of the block `on`.

    A position sensor is an encoder with `counts_per_revolution` or with a `step`; without both it
    is ideal.
    """

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
    """Source that the controller commands and sensor that it reads, if there are several.

    `load`: the block whose position is the load's; by default the block with the most links between
    it and the sensor.
    """

    source: str
    sensor: str
    load: str | None = None


class Mechanism(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`mechanism.yaml`. `travel` and `top_speed` are those of the controlled sensor's block."""

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
