"""`bench.yaml`: description of the rig before any measurement, and assignment of log columns."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import (
    ArmLength,
    Axis,
    BackEmf,
    DriveConstant,
    DriveLimit,
    Effort,
    Inertia,
    NonNegativeEffort,
    NonNegativeLength,
    NonNegativeMass,
    NonNegativeTime,
    Position,
    PositionSpan,
    PositiveLength,
    PositiveTime,
    PositiveVelocity,
    Time,
    Viscous,
)
from frictool.runtime.object_view import ObjectView

PositiveNumber = Annotated[float, msgspec.Meta(gt=0)]
# plausible range of a sample period [s]; a period outside it probably has a wrong unit
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-6, 10.0
# default standard deviation of the measured drive, relative to the drive's limit
DRIVE_NOISE_SHARE = 0.002
COUNT = "count"  # unit of a position in counts of the encoder
OPEN = "?"  # marks a column or unit that the user must fill in
# counts, shortest period of a wrapping position: one count must be less than half of the period
FEWEST_COUNTS = 4
SamplePeriod = Annotated[float, msgspec.Meta(ge=SHORTEST_PERIOD, le=LONGEST_PERIOD)]
Budget = Annotated[int, msgspec.Meta(ge=1)]
LineNumber = Annotated[int, msgspec.Meta(ge=0)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=80)]
Signal = Literal[
    "position",
    "reference",
    "velocity",
    "current",
    "current_command",
    "voltage",
    "effort",
    "temperature",
    "gain",
    "supply",
    "torque_enabled",
    "pendulum_mass",
    "pendulum_length",
]
Channel = Literal["time", Signal]


class Encoder(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Position sensor: its resolution, and the period and format of its counter.

    - `counts_per_revolution`: Number of counts per turn of a rotary axis. Write this key or `step`.
    - `step`: Distance or angle of one count, for either kind of axis.
    - `direction`: Sign with which the count changes during forward motion. In a log, this key
      applies only to positions with the unit `count`. In exported C, it is the sign of
      `NAME_POSITION_PER_COUNT`.
    - `wrap`: Period of a sensor that reports the position modulo this period, such as 360 deg or
      4096 counts. The position must move by less than half a period per sample.
    - `wrap_bits`: Number of bits of a counter that overflows. Write this key or `wrap`.
    - `signed`: True if the counter of `wrap_bits` is signed. This key is needed if the first count
      of the log does not show whether the counter is signed.
    - `index_reset`: True if an index pulse resets the counter. The jumps of the position at the
      index are then removed. The key `mechanics.top_speed` is then required.
    - `time_constant_s`: Time constant of a first-order lag between the true and the reported
      position, such as the filter of a potentiometer or of a 4-20 mA transmitter. The default is 0.
      If the key is absent, `identify` searches the logs for a lag.
    """

    counts_per_revolution: PositiveNumber | None = None
    step: PositiveLength | None = None
    direction: Literal[1, -1] = 1
    wrap: PositiveLength | None = None
    wrap_bits: Annotated[int, msgspec.Meta(ge=8, le=32)] | None = None
    signed: bool | None = None
    index_reset: bool = False
    time_constant_s: Annotated[float, msgspec.Meta(ge=0, le=10)] | None = None

    def __post_init__(self) -> None:
        if self.signed is not None and self.wrap_bits is None:
            raise ValueError("`signed` needs wrap_bits, the number of bits of the counter")
        if (self.counts_per_revolution is None) == (self.step is None):
            raise ValueError("give exactly one of counts_per_revolution and `step`")
        if self.wrap is not None and self.wrap_bits is not None:
            raise ValueError("give `wrap` or wrap_bits, not both")
        if self.wrap is not None and self.wrap.value < FEWEST_COUNTS * self.resolution:
            raise ValueError(f"`wrap` is shorter than {FEWEST_COUNTS} counts of the encoder")

    @property
    def period(self) -> float | None:
        """Return the period [rad | m] after which the position wraps; None if it never wraps."""
        if self.wrap is not None:
            return self.wrap.value
        return None if self.wrap_bits is None else self.resolution * 2.0**self.wrap_bits

    @property
    def resolution(self) -> float:
        """Return the change of the position per count [rad | m]."""
        if self.step is not None:
            return self.step.value
        assert self.counts_per_revolution is not None
        return 2.0 * math.pi / self.counts_per_revolution

    @property
    def lag_s(self) -> float:
        """Return the time constant [s] of the sensor's first-order lag; 0 if it is not stated."""
        return self.time_constant_s or 0.0

    @property
    def position_per_count(self) -> float:
        """Return the position per count [rad | m], negative if `direction` is -1."""
        return self.direction * self.resolution


class Winding(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Voltage limit of a current drive: |resistance i + constant v| <= voltage.

    i is the current and v is the speed. In SI units, the actuator's `constant` is also the back-EMF
    constant.

    - `resistance_ohm`: Resistance of the winding.
    - `voltage_v`: Supply voltage.
    """

    resistance_ohm: PositiveNumber
    voltage_v: PositiveNumber


class Servo(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Firmware of a smart servo, which computes the motor's voltage from a goal position.

    duty = duty_per_error * gain * (goal - position), limited to +-duty_limit; the voltage is duty
    times the supply voltage. `identify` estimates each quantity for which `low` and `high` are
    written.

    - `duty_per_error`: Duty cycle per rad of position error and per unit of the gain.
    - `gain`: Proportional gain in the firmware's unit. Write this key if the log has no channel
      `gain`.
    - `duty_limit`: Largest duty cycle.
    - `goal_speed`: Speed limit of the firmware's profile from one goal to the next.
    - `delay`: Time between a change of the logged goal and the response of the logged position,
      such as the delay of the bus.
    - `back_emf`: Back-EMF per speed, such as the supply voltage divided by the no-load speed.
    - `zero`: Angle of the pendulum's arm from the downward direction at position 0. By default,
      `identify` estimates this angle between -0.5 rad and 0.5 rad.
    - `loop_period_s`: Sample period of the firmware.
    """

    duty_per_error: PositiveNumber
    goal_speed: PositiveVelocity
    delay: NonNegativeTime
    back_emf: BackEmf
    gain: PositiveNumber | None = None
    duty_limit: Annotated[float, msgspec.Meta(gt=0, le=1)] = 1.0
    zero: Position | None = None
    loop_period_s: Annotated[float, msgspec.Meta(ge=1e-4, le=0.1)] = 0.001


class Pendulum(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Known pendulum on a rotary axis; its arm points downward at position 0.

    - `mass`: Point mass at the end of the arm.
    - `length`: Length of the arm.
    - `arm_mass`: Mass of the uniform arm. The default is 0.
    """

    mass: NonNegativeMass
    length: ArmLength
    arm_mass: NonNegativeMass | None = None


class Actuator(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Actuator of the axis: type of drive, effort per ampere or volt, limit and lag of the drive.

    - `drive`: Signal that drives the actuator, either its current or its voltage.
    - `constant`: Force or torque per ampere or volt.
    - `limit`: Largest magnitude of the drive.
    - `loop_time_constant_s`: Time constant of the current or voltage loop; 0 for a drive without
      lag. A logged voltage is assumed to be the command before this lag. For a motor that is driven
      by its voltage, the time constant includes L/R of the winding.
    - `winding`: Winding of a current drive; the supply voltage limits the current at high speed.
    - `servo`: Firmware of a smart servo; `limit` is then the nominal supply voltage.
    - `rms_limit`: Largest rms value that the drive may have over a test, such as the continuous
      current on the nameplate. The default is `limit`.
    """

    drive: Literal["current", "voltage"]
    constant: DriveConstant
    limit: DriveLimit
    loop_time_constant_s: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.0
    winding: Winding | None = None
    rms_limit: DriveLimit | None = None
    servo: Servo | None = None

    def __post_init__(self) -> None:
        if self.rms_limit is not None and self.rms_limit.value > self.limit.value:
            raise ValueError("rms_limit is above `limit`; allowed: at most `limit`")
        if self.winding is not None and self.drive != "current":
            raise ValueError("`winding` is for `drive: current`; a voltage is limited by `limit`")
        if self.servo is not None and self.drive != "voltage":
            raise ValueError("`servo` is for `drive: voltage`; found `drive: current`")

    @property
    def winding_delays(self) -> bool:
        """Return True if a winding's inductance delays the effort behind the logged voltage."""
        return self.drive == "voltage" and self.servo is None

    @property
    def logged_lag_s(self) -> float:
        """Return the time constant [s] with which the logged drive changes between two rows.

        The result is 0 if the signal is constant between two rows. A commanded voltage is constant
        between two rows: the drive's lag and the winding's inductance delay only its effect.
        """
        return self.loop_time_constant_s if self.drive == "current" else 0.0


class Mechanics(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Values of the mechanics that are known in advance.

    Each value has a range over the life of the product. The controller must be robust over these
    ranges.

    - `inertia`: Total inertia that the actuator moves.
    - `breakaway`: Effort at which the axis starts to move. In simulations, it is never below the
      Coulomb friction of the same plant. If neither this key nor a log states the breakaway, it is
      assumed to be 1 to 1.5 times `coulomb`.
    - `offset`: Constant effort that opposes a positive drive, such as a weight. The default is 0.
    - `backlash`: Full width of the free play between motor and load. By default, there is no
      backlash.
    - `backlash_coulomb`: Coulomb friction of the motor alone, inside the backlash.
    - `travel`: Positions that the axis can reach.
    - `top_speed`: Largest speed of the axis.
    """

    inertia: Inertia
    viscous: Viscous
    coulomb: NonNegativeEffort
    breakaway: NonNegativeEffort | None = None
    offset: Effort | None = None
    backlash: NonNegativeLength | None = None
    backlash_coulomb: NonNegativeEffort | None = None
    travel: PositionSpan | None = None
    top_speed: PositiveVelocity | None = None


class Column(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Column of a log file that contains one channel, with its unit, scale and offset.

    `frictool init` writes `?` for a column or unit that the log does not contain; commands refuse
    such a bench until the value is filled in.

    - `column`: Name of the column, or its number from 1. In a recording, the name consists of topic
      and field, such as `/joint_states.position[arm]`.
    - `unit`: Unit of the value scale * (number in the file) + offset. Write `count` for encoder
      counts.
    - `scale`: Factor by which the number in the file is multiplied.
    - `offset`: Number that is added after the multiplication.
    - `zero_first_samples`: Number of samples at the start of the log whose mean is subtracted from
      the column, before scale and offset are applied.
    """

    column: str | int
    unit: str
    scale: float = 1.0
    offset: float = 0.0
    zero_first_samples: Annotated[int, msgspec.Meta(ge=1, le=1_000_000)] | None = None

    def __post_init__(self) -> None:
        for key, value in (("column", self.column), ("unit", self.unit)):
            if value == OPEN:
                raise ValueError(
                    f"found {key} {OPEN!r}, which `frictool init` could not determine from the "
                    "log; fill it in, as the comment proposes"
                )


class Quadrature(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Channels A and B of an encoder, as recorded by an oscilloscope or a logic analyser.

    The decoded counts form a new column. A signal becomes high at `threshold` + `hysteresis` / 2
    and low at `threshold` - `hysteresis` / 2; these are voltages at the encoder.

    - `a`, `b`: Columns of channels A and B, by name or number.
    - `threshold`: Voltage between low and high [V].
    - `hysteresis`: Difference of the two switching voltages [V].
    - `probe`: Attenuation of the probe: the voltage at the encoder is `probe` times the number in
      the file.
    """

    a: str | int
    b: str | int
    threshold: float = 0.5
    hysteresis: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    probe: PositiveNumber = 1.0


class Layout(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Format properties of a raw file that its content does not show reliably.

    Lines are numbered from 1; the number 0 means that the file has no such line. If a key is
    absent, the property is detected from the file.

    - `encoding`: Encoding of the text.
    - `delimiter`: Character between two columns.
    - `decimal`: Decimal sign.
    - `thousands`: Character between groups of digits.
    - `header_line`: Line with the names of the columns.
    - `unit_line`: Line with the units.
    - `first_line`: First line with numbers.
    - `dates`: Order of a date's parts if the year comes last: `day-first` (31/01/2026) or
      `month-first` (01/31/2026).
    - `period_s`: Time between two rows. Write this key if no column contains the time.
    - `start_s`: Time of the first row. This key needs `period_s`.
    - `hold`: True if a historian wrote a row or a cell only when a value changed. An empty cell
      then repeats the last value of its column, and a channel keeps its value from row to row. The
      log is sampled at `sample_period_s`.
    - `whole`: True if the last line is complete although it has no line end.
    - `dbc`: File that defines the signals of a CAN log, in the folder of the log. The default is
      the `.dbc` file with the name of the log.
    - `clock`: Source of the times of a recording: `log time`, or the path of a time stamp in its
      messages, such as `header.stamp`.
    """

    encoding: Literal["utf-8", "utf-16", "latin-1"] | None = None
    delimiter: Literal["comma", "semicolon", "tab", "blank"] | None = None
    decimal: Literal["point", "comma"] | None = None
    thousands: Literal["point", "comma", "blank", "apostrophe"] | None = None
    header_line: LineNumber | None = None
    unit_line: LineNumber | None = None
    first_line: Annotated[int, msgspec.Meta(ge=1)] | None = None
    dates: Literal["day-first", "month-first"] | None = None
    period_s: PositiveNumber | None = None
    start_s: float | None = None
    hold: bool = False
    whole: bool = False
    dbc: Annotated[str, msgspec.Meta(min_length=1)] | None = None
    clock: Annotated[str, msgspec.Meta(min_length=1)] | None = None

    def __post_init__(self) -> None:
        if self.decimal is not None and self.decimal == self.thousands:
            raise ValueError("`decimal` and `thousands` are equal; allowed: different characters")
        if self.start_s is not None and self.period_s is None:
            raise ValueError("start_s needs period_s, the time between two rows")
        lines = [line for line in (self.header_line, self.unit_line, self.first_line) if line]
        if lines != sorted(set(lines)):
            raise ValueError("header_line, unit_line, first_line: allowed: rising line numbers")


class ClockEstimate(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Settings for estimating an instrument's clock offset from two matching channels.

    Both channels must measure the same quantity, but their scales and offsets may differ.

    - `channel`: Channel of the instrument.
    - `reference`: Channel of the first file of the log.
    - `most`: Largest magnitude of the clock offset that is considered.
    """

    channel: Signal
    reference: Signal
    most: PositiveTime


class Instrument(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Additional instrument at the rig, whose log files are recognised by their names.

    If `layout` or `sample_period_s` is absent, the value of this key at the top level of bench.yaml
    applies. The top-level `quadrature` does not apply to these files.

    - `files`: Pattern of the file names, such as `"*MR*.csv"`.
    - `columns`: Column of each channel.
    - `layout`: Layout of these files.
    - `quadrature`: Pairs of encoder channels to decode. Each key is the name of the new column with
      the counts.
    - `clock_offset`: Time by which the instrument's clock is ahead of the clock of the log's first
      file. This time is subtracted from the instrument's times.
    - `clock_estimate`: Settings with which the clock offset is estimated from the data.
    """

    files: Annotated[str, msgspec.Meta(min_length=1)]
    columns: dict[Channel, Column]
    layout: Layout | None = None
    quadrature: dict[str, Quadrature] | None = None
    sample_period_s: SamplePeriod | None = None
    clock_offset: Time | None = None
    clock_estimate: ClockEstimate | None = None

    def __post_init__(self) -> None:
        if self.clock_offset is not None and self.clock_estimate is not None:
            raise ValueError("give clock_offset or clock_estimate, not both")


class Target(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Processor that runs the controller, and the budget of its exported C code.

    `export --lang c` compiles the code for `core` and reports an error if the code exceeds the
    budget.

    - `core`: Core of the processor. `cortex-m4f` has a floating-point unit; `cortex-m4` has no
      floating-point unit.
    - `instructions`: Largest number of instructions per sample.
    - `code_bytes`: Largest number of bytes of code and constants, without library functions.
    - `state_bytes`: Largest number of bytes of the state of one axis.
    """

    core: Literal["cortex-m4f", "cortex-m4"] = "cortex-m4f"
    instructions: Budget | None = None
    code_bytes: Budget | None = None
    state_bytes: Budget | None = None


class Bench(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Description of the rig before any measurement, and assignment of log columns: `bench.yaml`.

    - `encoder`: Position sensor.
    - `actuator`: Actuator and its drive.
    - `mechanics`: Values of the mechanics that are known in advance.
    - `columns`: For each channel, the column of the log file that contains it. A log must have all
      these columns except `reference`, which a test of drive ramps lacks.
    - `layout`: Layout of the log files, if it cannot be detected.
    - `quadrature`: Pairs of encoder channels to decode. Each key is the name of the new column with
      the counts.
    - `instruments`: Additional instruments with separate log files, by name.
    - `load`: Load terms that `identify` estimates. By default, only an offset is estimated; method
      `auto` also tests the other terms.
    - `target`: Processor of the controller, and the budget of its code.
    - `pendulum`: Known pendulum on the axis; `mechanics.inertia` includes it.
    """

    format: Literal["bench/1"]
    name: Name
    axis: Axis
    sample_period_s: SamplePeriod
    encoder: Encoder
    actuator: Actuator
    mechanics: Mechanics
    columns: dict[Channel, Column]
    layout: Layout | None = None
    quadrature: dict[str, Quadrature] | None = None
    instruments: dict[str, Instrument] | None = None
    delay_samples: Annotated[int, msgspec.Meta(ge=0, le=2)] = 1
    examples: tuple[str, ...] = ()
    load: LoadTerms | None = None
    target: Target | None = None
    pendulum: Pendulum | None = None

    def __post_init__(self) -> None:
        if self.axis == "linear" and (self.pendulum is not None or self.actuator.servo is not None):
            raise ValueError("pendulum and actuator.servo belong to a rotary axis")
        if self.actuator.servo is not None and self.encoder.lag_s > 0.0:
            raise ValueError(
                "encoder.time_constant_s is not for a smart servo; write actuator.servo.delay"
            )
        if self.axis == "linear" and self.encoder.counts_per_revolution is not None:
            raise ValueError(
                "encoder.counts_per_revolution belongs to a rotary axis; write encoder.step"
            )
        if self.axis == "linear" and self.load is not None and "gravity" in self.load.terms:
            raise ValueError(
                "load.terms: gravity belongs to a rotary axis; for a linear axis write offset"
            )
        if self.axis == "linear" and self.load is not None and "eccentricity" in self.load.terms:
            raise ValueError(
                "load.terms: eccentricity belongs to the encoder of a rotary axis; on a linear "
                "axis declare a ripple whose period is the travel per turn of the encoder"
            )
        if self.encoder.index_reset and self.mechanics.top_speed is None:
            raise ValueError(
                "encoder.index_reset needs mechanics.top_speed, to distinguish a reset from "
                "a motion"
            )
