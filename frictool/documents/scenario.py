"""`scenario.yaml`: test of a closed loop, or of a mechanism's sources without a controller."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.conditions import (
    ControllerCommand,
    Disturbance,
    Drifts,
    SensorFault,
    Signal,
)
from frictool.documents.quantity import AnyQuantity, Axis, Position, PositiveLength, Temperature
from frictool.documents.spread import Spread
from frictool.runtime.object_view import ObjectView

# s, shortest hold that can show the absence of a limit cycle; some cycles need a minute to appear
# (docs/theory/simulate.md)
SHORTEST_HOLD_S = 15.0
Hold = Annotated[float, msgspec.Meta(ge=SHORTEST_HOLD_S)]
MOST_PLANTS = 100_000
STEP_KINDS = ("reference", "ramp_to", "sine", "hold_s")


class Sine(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Sine reference: centre + amplitude sin(2 pi frequency_hz t + phase_deg).

    t is the time since the start of the sine.

    - `amplitude`: Amplitude of the sine.
    - `centre`: Centre of the sine. The default is the last value of the previous step.
    """

    amplitude: PositiveLength
    frequency_hz: PositiveNumber
    phase_deg: float = 0.0
    centre: Position | None = None


class Step(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Step of a scenario: exactly one of `reference`, `ramp_to`, `sine` and `hold_s`.

    - `reference`: Constant reference.
    - `duration_s`: Duration of `reference`, `ramp_to` or `sine`.
    - `ramp_to`: Position that the reference reaches at constant speed, from the last value of the
      previous step.
    - `sine`: Sine reference.
    - `hold_s`: Duration for which the reference stays at the last value of the previous step.
    """

    reference: Position | None = None
    duration_s: PositiveNumber | None = None
    ramp_to: Position | None = None
    sine: Sine | None = None
    hold_s: Hold | None = None

    def __post_init__(self) -> None:
        present = [name for name in STEP_KINDS if getattr(self, name) is not None]
        if len(present) != 1:
            raise ValueError(
                f"found {' and '.join(present) or 'none of them'}; allowed: exactly one "
                f"of {', '.join(STEP_KINDS)}"
            )
        if (self.duration_s is None) != (self.hold_s is not None):
            raise ValueError(
                "duration_s: required with reference, ramp_to or sine; not allowed with hold_s, "
                "which is a duration"
            )

    @property
    def kind(self) -> str:
        """Return the kind of the step, one of STEP_KINDS."""
        return next(name for name in STEP_KINDS if getattr(self, name) is not None)

    @property
    def seconds(self) -> float:
        """Return the duration of the step [s]."""
        duration = self.hold_s if self.duration_s is None else self.duration_s
        assert duration is not None
        return duration


class Replay(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Logged channel as the reference; docs/theory/simulate.md describes the resampling.

    - `log`: Path of the log, relative to the scenario's folder. The model's bench describes the
      columns of a raw log.
    - `channel`: Channel to replay: `reference` or another channel in rad or m.
    - `from_s`, `to_s`: Start and end of the replayed section, as times after the log's first
      sample. By default the whole log is replayed.
    - `shift`: Number that is added to the channel, for a log whose zero position differs from the
      model's zero position.
    - `hold_s`: Duration after the section for which the reference stays at its last value.
    """

    log: Annotated[str, msgspec.Meta(min_length=1)]
    channel: Annotated[str, msgspec.Meta(min_length=1)] = "reference"
    from_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    to_s: PositiveNumber | None = None
    shift: Position | None = None
    hold_s: Hold | None = None

    def __post_init__(self) -> None:
        if self.to_s is not None and self.to_s <= self.from_s:
            raise ValueError(f"to_s: found {self.to_s:g}; allowed: after from_s, {self.from_s:g}")


class Scenario(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Test of a closed loop, or of a mechanism's sources without a controller: `scenario.yaml`.

    The reference of a closed loop is defined by `steps`, or by a `reference` from a log. A test
    without a controller has the commands of a mechanism's `sources` for `duration_s`.

    - `start`: Position at which the axis rests at the beginning. The default is the first value of
      a replayed reference.
    - `steps`: Successive steps of the reference.
    - `reference`: Logged channel as the reference.
    - `variants`: Plants that are simulated. `nominal`: the plant with the model's values.
      `vertices`: also a plant at each vertex of the parameter ranges. `random`: also random plants,
      drawn from the parameter ranges; `plants` is their number. `given`: only one plant, which has
      the parameters under `given`.
    - `given`: Parameters of the plant of `variants: given`, by name. Parameters that are not listed
      have the model's values, but a breakaway that is not listed changes in proportion to
      `coulomb`. A listed `breakaway` applies to the positive direction; the breakaway of the
      negative direction is multiplied by the same factor.
    - `plants`: Number of random plants of `variants: random`.
    - `drive`: Kind of drive; it decides the units of quantities in the scenario.
    - `drive_noise`: Standard deviation of the noise of the measured drive [A | V].
    - `seed`: Seed of the random numbers for noise and plants.
    - `disturbances`: External efforts.
    - `drifts`: Factors by which plant parameters change over time.
    - `temperature`: Temperature of the plant; `laws.temperature` of the model determines the
      friction at this temperature. The default is the reference temperature of the model.
    - `sensor_faults`: Faults of encoder and drive sensor.
    - `commands`: Commands of a supervisor to the controller of an axis; the exported code has the
      same commands.
    - `sources`: Commands of a mechanism's sources, by source name. In a test with a controller,
      only sources that the controller does not command are allowed.
    - `duration_s`: Duration of a test without controller.
    - `spread`: Variations of a campaign; `simulate` ignores them.
    """

    format: Literal["scenario/1"]
    name: Name
    axis: Axis
    start: Position | None = None
    steps: tuple[Step, ...] = ()
    reference: Replay | None = None
    variants: Literal["nominal", "vertices", "random", "given"] = "nominal"
    given: dict[str, AnyQuantity] = {}
    plants: Annotated[int, msgspec.Meta(ge=1, le=MOST_PLANTS)] | None = None
    drive: Literal["current", "voltage"] = "current"
    drive_noise: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    disturbances: tuple[Disturbance, ...] = ()
    drifts: Drifts | None = None
    temperature: Temperature | None = None
    sensor_faults: tuple[SensorFault, ...] = ()
    commands: tuple[ControllerCommand, ...] = ()
    sources: dict[str, tuple[Signal, ...]] = {}
    duration_s: PositiveNumber | None = None
    spread: Spread | None = None
    examples: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.reference is not None and self.steps:
            raise ValueError("found `steps` and `reference`; allowed: one of them")
        if self.is_open:
            if self.reference is not None or self.steps:
                raise ValueError(
                    "duration_s belongs to a test without controller; remove it, or remove `steps` "
                    "and `reference`"
                )
        elif self.reference is None and not self.steps:
            raise ValueError(
                "`steps` is empty; write at least one {reference: .., duration_s: ..}, "
                "or duration_s for a test without controller"
            )
        elif self.reference is None and self.start is None:
            raise ValueError("`start` is missing; write the position at rest before the first step")
        if (self.variants == "random") != (self.plants is not None):
            raise ValueError(
                "`plants` (their number): required with `variants: random`, not allowed with other "
                "variants"
            )
        if self.given and self.variants != "given":
            raise ValueError("`given` (the parameters of one plant) belongs to `variants: given`")
        if (
            self.spread is not None
            and self.spread.within_count
            and self.start is None
            and self.spread.start is None
        ):
            raise ValueError(
                "spread.within_count needs `start`, the position at rest at the beginning"
            )
        if self.temperature is not None and self.spread is not None and self.spread.temperature:
            raise ValueError("found `temperature` and `spread.temperature`; allowed: one of them")
        if self.spread is not None and self.is_open:
            raise ValueError(
                "`spread` belongs to a campaign, which needs a controller; remove `spread`, or "
                "write `steps` instead of duration_s"
            )

    @property
    def is_open(self) -> bool:
        """Return True if the scenario is a test without a controller.

        Such a scenario has commands of sources, but no reference.
        """
        return self.duration_s is not None

    @property
    def seconds(self) -> float:
        """Return the duration of steps or of a test without controller [s]; NaN for a replay."""
        if self.duration_s is not None:
            return self.duration_s
        return math.nan if self.reference is not None else sum(step.seconds for step in self.steps)
