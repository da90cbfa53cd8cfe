"""`mechanism.yaml`: blocks, links, friction, sources and sensors of a mechanism (thesis 2.1, 2.2).

Each block has one coordinate q: an angle [rad] if it has an `inertia`, a distance [m] if it has a
`mass`. A link has a name and a kind. `between` names the blocks at its ends, the driving end first;
`ground` is the frame. At the beginning, every block is at its position `start`, every backlash is
centred, and no compliance is strained.

If a link has a rotary and a linear end, the unit of a quantity determines the end to which it
belongs: for a rack and pinion, a backlash of 3 rad is at the pinion, and a backlash of 0.6 mm is at
the rack. The links' compatibility is checked when the mechanism is assembled
(adapters/mechanism/assembly.py).
"""

from __future__ import annotations

import itertools
from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber, SamplePeriod, Winding
from frictool.documents.quantity import Quantity, Series, Span, _of
from frictool.runtime.object_view import ObjectView

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
]  # a single end is an error unless `ground` is allowed as the other end
GROUND = "ground"


class Block(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Rigid body, either rotary (with `inertia`) or linear (with `mass`).

    - `inertia`: Inertia of a block that turns.
    - `mass`: Mass of a block that slides.
    - `start`: Position at the beginning. The default is 0.
    """

    # (2.1)-(2.2)
    inertia: RotaryInertia | None = None
    mass: LinearMass | None = None
    start: EitherPosition | None = None

    def __post_init__(self) -> None:
        if (self.inertia is None) == (self.mass is None):
            raise ValueError("give `inertia` for a rotary block, or `mass` for a linear block")


class Curve(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Quantity as a function of position.

    The function is a monotone cubic interpolation of the points, and constant beyond them.

    - `position`: Positions of the points, rising.
    - `value`: Values at the points.
    """

    position: Annotated[Series, _of("position of either axis")]
    value: Annotated[Series, _of("any mechanical")]

    def __post_init__(self) -> None:
        _check_points(self.position.values, self.value.values)


def _check_points(positions: tuple[float, ...], values: tuple[float, ...]) -> None:
    if len(positions) != len(values):
        raise ValueError(
            f"found {len(positions)} positions and {len(values)} values; allowed: equal numbers"
        )
    if len(positions) < 2 or any(b <= a for a, b in itertools.pairwise(positions)):
        raise ValueError("position: allowed: at least 2 values, rising")


class Level(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Factor as a function of position.

    The function is a monotone cubic interpolation of the points, and constant beyond them.

    - `position`: Positions of the points, rising.
    - `factor`: Factors at the points.
    """

    position: Annotated[Series, _of("position of either axis")]
    factor: tuple[Factor, ...]

    def __post_init__(self) -> None:
        _check_points(self.position.values, self.factor)


class Compliance(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Elasticity of a link, measured at the second end of the link.

    The elasticity of a belt is measured along the belt.

    - `stiffness`: Stiffness of the elastic element.
    - `damping`: Viscous damping of the elastic element.
    """

    # (2.5)
    stiffness: EitherStiffness
    damping: EitherDamping


class Backlash(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Free play of a link.

    - `width`: Full width, measured at the end of the link that fits the unit. If the unit fits both
      ends, the width is measured at the block `at`, by default at the second end.
    - `at`: Block at whose end the backlash is measured.
    - `restitution`: Relative speed after an impact of rigid flanks, divided by the relative speed
      before the impact.
    - `compliance`: Stiffness and damping of elastic flanks. By default the flanks are rigid.
    """

    # (2.18); elastic flanks rebound as observed in 4.4.4
    width: EitherWidth
    at: str | None = None
    restitution: Restitution = 0.0
    compliance: Compliance | None = None

    def __post_init__(self) -> None:
        if self.compliance is not None and self.restitution:
            raise ValueError(
                "restitution belongs to rigid flanks; compliant flanks rebound by their "
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
    """Gear with the ends a and b: omega_b = -ratio omega_a, or +ratio omega_a for an internal gear.

    - `ratio`: Speed of the second end divided by the speed of the first end; above 0.
    - `internal`: True for an internal gear.
    """

    # (2.3)
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
    """Belt with the ends a and b: radius_b omega_b = radius_a omega_a.

    - `radius_a`, `radius_b`: Radius of the pulley at the first and at the second end.
    - `crossed`: True for a crossed belt, which reverses the direction.
    """

    # (2.6)
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
    """Screw from a rotary to a linear block: v_nut = radius tan(lead_angle) omega_screw.

    - `radius`: Mean radius of the thread.
    - `lead_angle`: Lead angle of the thread. Write this key or `lead`.
    - `lead`: Distance of the nut per turn of the screw.
    - `left_handed`: True for a left-handed thread.
    - `friction_coefficient`: Friction coefficient mu of the thread. Write this key or `efficiency`.
    - `friction_form`: `angle` is exact for a square thread: the torque is radius tan(lead_angle ±
      atan mu) force. `thesis` is the approximation of the thesis.
    """

    # (2.10)-(2.13); thesis is (2.12) as printed
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
            raise ValueError("give lead_angle or `lead`, the distance of the nut per turn")
        if self.friction_coefficient is not None and self.efficiency is not None:
            raise ValueError("give friction_coefficient or `efficiency`, not both")
        if self.efficiency_back is not None and self.efficiency is None:
            raise ValueError("efficiency_back needs efficiency")


class Rack(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="rack",
):
    """Rack and pinion: v_rack = radius omega_pinion.

    - `radius`: Radius of the pinion; the radius can include a reducer in front of the pinion.
    - `reversed`: True if the rack moves in its negative direction while the pinion turns in its
      positive direction.
    """

    # (2.19), the r of (2.20)
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
    """Hydraulic link of pistons a and b: x_b = (area_a/area_b) x_a, F_a = (area_a/area_b) F_b.

    Inertia and friction of the fluid are neglected.

    - `area_a`, `area_b`: Area of the piston at the first and at the second end.
    """

    # (2.16)
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
    """Shaft or rod between two rotary or two linear blocks: rigid, elastic, or with backlash."""

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
    """Spring between two blocks with coordinates q_a and q_b; for the end `ground`, q_b is 0.

    - `stiffness`: Stiffness of the spring. Write this key or `force`, or only `damping` for a
      damper.
    - `force`: Effort as a function of q_a - q_b; a positive effort pulls q_a to lower values.
    - `damping`: Viscous damping. The default is 0.
    - `free`: q_a - q_b at which the spring is relaxed. The default is q_a - q_b at the start.
    - `preload`: Effort of the spring at q_a - q_b = `free`; a positive effort pulls q_a to lower
      values. The default is 0.
    """

    between: Ends
    stiffness: EitherStiffness | None = None
    force: Curve | None = None
    damping: EitherDamping | None = None
    free: EitherPosition | None = None
    preload: EitherEffort | None = None

    def __post_init__(self) -> None:
        if self.stiffness is not None and self.force is not None:
            raise ValueError("give `stiffness` or a `force` curve, not both")
        if self.stiffness is None and self.force is None and self.damping is None:
            raise ValueError(
                "give stiffness, a force curve or damping: without any of them the "
                "spring does nothing"
            )
        if self.force is not None and (self.free is not None or self.preload is not None):
            raise ValueError(
                "`free` and `preload` are allowed with `stiffness` only; leave them out, because "
                "the `force` curve contains both"
            )


class Cam(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    tag_field="kind",
    tag="cam",
):
    """Cam profile on a block. A spring presses a roller onto the profile.

    The cam exerts the effort `force` tan(`angle`) on the block, in the positive direction of the
    block. It also exerts Coulomb friction on the block.

    - `on`: Block of the profile.
    - `force`: Force of the spring, normal to the motion, as a function of position.
    - `angle`: Slope angle of the profile as a function of position.
    - `friction_coefficient`: Coulomb friction divided by `force`.
    - `breakaway_ratio`: Breakaway divided by the Coulomb friction.
    """

    # (2.23) with the sign of (2.28)
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
    """End stops of a block. A block rebounds from rigid stops; compliant stops act as springs.

    - `on`: Block that the stops limit.
    - `low`, `high`: Position of the lower and of the upper stop. Write one or both.
    - `restitution`: Speed after an impact on a rigid stop, divided by the speed before the impact.
    - `compliance`: Stiffness and damping of elastic stops. By default the stops are rigid.
    """

    on: str
    low: EitherPosition | None = None
    high: EitherPosition | None = None
    restitution: Restitution = 0.0
    compliance: Compliance | None = None

    def __post_init__(self) -> None:
        if self.low is None and self.high is None:
            raise ValueError("give `low`, `high` or both")
        if self.low is not None and self.high is not None and self.low.value >= self.high.value:
            raise ValueError("`low` is not below `high`; allowed: low < high")
        if self.compliance is not None and self.restitution:
            raise ValueError(
                "restitution belongs to rigid stops; compliant stops rebound by their "
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
    """Friction between a block and the frame, in a bearing or a slideway.

    - `on`: Block on which the friction acts.
    - `law`: Name of the friction law, as in `frictool compare`.
    - `parameters`: Parameters of the law by name; a number without dimension has the unit `'1'`.
    - `level`: Factor by which all efforts of the law are multiplied, as a function of position. By
      default 1.
    """

    # laws and their parameters: friction/law_registry.py
    on: str
    law: str
    parameters: dict[str, AnyParameter]
    level: Level | None = None


Link = Gear | Belt | Screw | Rack | Hydraulic | Coupling | Spring | Cam | Stop | FrictionOf


class Source(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Actuator of a block: a current drive, a voltage drive, or a direct effort.

    - `on`: Block that the source drives.
    - `drive`: Signal of the source. `current` and `voltage` need a `constant`; `effort` acts on the
      block directly.
    - `constant`: Effort per ampere or volt.
    - `limit`: Largest magnitude of the drive. By default, the drive is unlimited.
    - `loop_time_constant_s`: Time constant of the current or voltage loop; 0 for a drive without
      lag.
    - `winding`: Winding of a current drive; the supply voltage limits the current at high speed.
    - `effort`: Constant effort of a source with `drive: effort`, such as a weight. Commands of a
      scenario are added to it.
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
                "`constant` (effort per ampere or volt): required with `drive: current` or "
                "`drive: voltage`, not allowed with `drive: effort`"
            )
        if self.effort is not None and self.drive != "effort":
            raise ValueError(
                "the key `effort` is allowed with `drive: effort` only; "
                f"found `drive: {self.drive}`"
            )
        if self.winding is not None and self.drive != "current":
            raise ValueError("`winding` is for `drive: current`; a voltage is limited by `limit`")


class Sensor(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Sensor of a block; a position sensor without a resolution is ideal.

    - `on`: Block that the sensor measures.
    - `measures`: Measured quantity.
    - `counts_per_revolution`: Resolution of an encoder on a block that turns.
    - `step`: Resolution of an encoder: distance or angle of one count. Write this key or
      `counts_per_revolution`.
    """

    on: str
    measures: Literal["position", "velocity"] = "position"
    counts_per_revolution: PositiveNumber | None = None
    step: EitherWidth | None = None

    def __post_init__(self) -> None:
        if self.counts_per_revolution is not None and self.step is not None:
            raise ValueError("give counts_per_revolution or `step`, not both")
        if self.measures == "velocity" and (
            self.counts_per_revolution is not None or self.step is not None
        ):
            raise ValueError("counts_per_revolution and `step` belong to `measures: position`")


class Control(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Source that the controller commands, and sensor that the controller reads.

    - `source`: Name of the source.
    - `sensor`: Name of the sensor.
    - `load`: Block of the load. The default is the block farthest from the sensor, counted in
      links.
    """

    source: str
    sensor: str
    load: str | None = None


class Mechanism(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Blocks, links, friction, sources and sensors of a mechanism: `mechanism.yaml`.

    - `blocks`: Blocks by name. A name begins with a letter, followed by letters, digits and `_`.
    - `links`: Links by name; the key `kind` selects the type.
    - `sources`: Actuators by name.
    - `sensors`: Sensors by name.
    - `control`: Source and sensor of the controller, if the mechanism has several sources or
      sensors.
    - `travel`: Positions that the block of the controller's sensor can reach.
    - `top_speed`: Largest speed of the block of the controller's sensor.
    """

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
