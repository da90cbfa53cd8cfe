"""`bench.yaml`: the rig as it stands, what is known of it before any measurement, and how its log
columns map to channels."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import (
    Axis,
    DriveConstant,
    DriveLimit,
    Effort,
    Inertia,
    NonNegativeEffort,
    NonNegativeLength,
    PositionSpan,
    PositiveLength,
    PositiveTime,
    PositiveVelocity,
    Time,
    Viscous,
)

PositiveNumber = Annotated[float, msgspec.Meta(gt=0)]
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-6, 10.0  # s; what lies outside is a unit that was mistaken
OPEN = "?"  # marks a column or unit that has to be filled in
# least counts in one period of a position that wraps: a step has to be shorter than half of the
# period
FEWEST_COUNTS = 4
SamplePeriod = Annotated[float, msgspec.Meta(ge=SHORTEST_PERIOD, le=LONGEST_PERIOD)]
LineNumber = Annotated[int, msgspec.Meta(ge=0)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=80)]
Channel = Literal[
    "time", "position", "reference", "velocity", "current", "current_command", "voltage", "effort"
]
Signal = Literal[
    "position", "reference", "velocity", "current", "current_command", "voltage", "effort"
]


class Encoder(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Position sensor: its counts per revolution (rotary) or its step, and the period and the
    format of its counter.

    wrap: the sensor shows the position modulo this period, in any unit of the log. wrap_bits: the
    same for a counter with this number of bits. signed: whether that counter is signed, needed
    where the first count of the log leaves it open. index_reset: an index pulse sets the counter.
    """

    counts_per_revolution: PositiveNumber | None = None
    step: PositiveLength | None = None
    direction: Literal[1, -1] = 1
    wrap: PositiveLength | None = None
    wrap_bits: Annotated[int, msgspec.Meta(ge=8, le=32)] | None = None
    signed: bool | None = None
    index_reset: bool = False

    def __post_init__(self) -> None:
        if self.signed is not None and self.wrap_bits is None:
            raise ValueError("signed says how a counter of wrap_bits is meant; give wrap_bits")
        if (self.counts_per_revolution is None) == (self.step is None):
            raise ValueError("give exactly one of counts_per_revolution and step")
        if self.wrap is not None and self.wrap_bits is not None:
            raise ValueError("give wrap or wrap_bits, not both")
        if self.wrap is not None and self.wrap.value < FEWEST_COUNTS * self.resolution:
            raise ValueError(f"wrap is shorter than {FEWEST_COUNTS} counts of the encoder")

    @property
    def period(self) -> float | None:
        """Return the period of the position that the sensor shows, rad or m; None where it does not
        wrap."""
        if self.wrap is not None:
            return self.wrap.value
        return None if self.wrap_bits is None else self.resolution * 2.0**self.wrap_bits

    @property
    def resolution(self) -> float:
        """Position of one count, rad or m."""
        if self.step is not None:
            return self.step.value
        assert self.counts_per_revolution is not None
        return 2.0 * math.pi / self.counts_per_revolution


class Winding(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What limits a current beside its own limit: |resistance i + constant v| <= voltage, the
    constant being the back-EMF's too (SI)."""

    resistance_ohm: PositiveNumber
    voltage_v: PositiveNumber


class Actuator(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What drives the axis: a current or a voltage, the effort that one unit of it gives, its limit
    and its lag."""

    drive: Literal["current", "voltage"]
    constant: DriveConstant
    limit: DriveLimit
    loop_time_constant_s: Annotated[float, msgspec.Meta(ge=0, le=10)] = 0.0
    winding: Winding | None = None

    def __post_init__(self) -> None:
        if self.winding is not None and self.drive != "current":
            raise ValueError("winding is for drive: current; a voltage is limited by `limit`")


class Mechanics(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What is known a priori, each with the range that the product may show over its life (the
    controller must stand it)."""

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
    """Source of one channel: the name of a column (variable) or its number from 1, its unit, a
    factor and an offset.

    zero_first_samples: the mean of this number of first samples is subtracted from the column. A
    guessed bench has OPEN for a column or a unit that the log does not contain; the bench is
    refused until it is filled in.
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
                    f"found {key} {OPEN!r}, which the log did not tell; fill in what the comment beside it proposes"
                )


class Quadrature(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """An encoder's two channels as an oscilloscope or a logic analyser records them; the counts
    they make are a column of their own.

    threshold, hysteresis: a level is high from threshold + hysteresis / 2 on, low again at
    threshold - hysteresis / 2; both at the encoder, where the file's numbers are times `probe`.
    """

    a: str | int
    b: str | int
    threshold: float = 0.5
    hysteresis: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    probe: PositiveNumber = 1.0


class Layout(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """How a raw file is laid out, where what is found in it is not to be relied on: a text file,
    and what dates the rows of a recording.

    Lines count from 1; 0 says that there is none. period_s, start_s: of rows that no column dates.
    whole: the last line is whole though it has no line end. clock: of a recording, `log time` or
    the path of a stamp in its messages (`header.stamp`).
    """

    encoding: Literal["utf-8", "utf-16", "latin-1"] | None = None
    delimiter: Literal["comma", "semicolon", "tab", "blank"] | None = None
    decimal: Literal["point", "comma"] | None = None
    thousands: Literal["point", "comma", "blank", "apostrophe"] | None = None
    header_line: LineNumber | None = None
    unit_line: LineNumber | None = None
    first_line: Annotated[int, msgspec.Meta(ge=1)] | None = None
    period_s: PositiveNumber | None = None
    start_s: float | None = None
    whole: bool = False
    clock: Annotated[str, msgspec.Meta(min_length=1)] | None = None

    def __post_init__(self) -> None:
        if self.decimal is not None and self.decimal == self.thousands:
            raise ValueError("decimal and thousands are the same sign; they have to differ")
        if self.start_s is not None and self.period_s is None:
            raise ValueError("start_s says when the rows of period_s begin; give period_s")
        lines = [line for line in (self.header_line, self.unit_line, self.first_line) if line]
        if lines != sorted(set(lines)):
            raise ValueError("header_line, unit_line and first_line follow one another")


class ClockEstimate(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """How far an instrument's clock is ahead is found where a channel of it follows a channel of
    the log's first file best.

    channel, reference: of the instrument, and of the first file; the same quantity but for a factor
    and an offset. most: either way.
    """

    channel: Signal
    reference: Signal
    most: PositiveTime


class Instrument(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Files that another instrument has recorded: those whose name fits the pattern `files`; what
    it does not say, the bench says.

    clock_offset: how far its clock is ahead; is taken off its times. clock_estimate: the same, to
    be found.
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


class Bench(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`bench.yaml`. examples: keys whose values are examples of `frictool init`; delete a key when
    you have replaced its value."""

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

    def __post_init__(self) -> None:
        if self.axis == "linear" and self.encoder.counts_per_revolution is not None:
            raise ValueError(
                "encoder.counts_per_revolution belongs to a rotary axis; write encoder.step"
            )
        if self.axis == "linear" and self.load is not None and "gravity" in self.load.terms:
            raise ValueError(
                "load.terms: gravity turns with a rotary axis; on a linear one it is an offset"
            )
        if self.encoder.index_reset and self.mechanics.top_speed is None:
            raise ValueError(
                "encoder.index_reset needs mechanics.top_speed, which tells a reset from motion"
            )
