"""`spread:` of scenario.yaml: what a campaign varies beside the ranges that the plant has itself;
`simulate` plays the scenario without it.

Every range is uniform and independent of the others, but for a breakaway, which is drawn from what
of its range is not below the Coulomb friction; a range whose ends are equal is a fixed value. A
range that reaches where no plant can be is refused.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import PositiveNumber
from frictool.documents.conditions import (
    Factor,
    GainError,
    Instant,
    Kind,
    check_course,
    check_fault,
)
from frictool.documents.quantity import PositionSpan, Span, _of

DriveSpan = Annotated[Span, _of("drive")]
EffortSpan = Annotated[Span, _of("effort of either axis")]  # as of a disturbance
AnySpan = Annotated[Span, _of("any")]


def _check_ends(
    one: FactorBand | InstantBand | LastingBand | GainBand | CountBand | FrequencyBand,
) -> None:
    if one.low > one.high:
        raise ValueError(f"low: found {one.low:g} above high {one.high:g}; allowed: low <= high")


class FactorBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A factor between two others."""

    low: Factor
    high: Factor

    def __post_init__(self) -> None:
        _check_ends(self)


class InstantBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A time [s] between two others."""

    low: Instant
    high: Instant

    def __post_init__(self) -> None:
        _check_ends(self)


class LastingBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How long [s], between two others."""

    low: PositiveNumber
    high: PositiveNumber

    def __post_init__(self) -> None:
        _check_ends(self)


class GainBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A gain error between two others."""

    low: GainError
    high: GainError

    def __post_init__(self) -> None:
        _check_ends(self)


class CountBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Every whole number from one to another is as likely."""

    low: int
    high: int

    def __post_init__(self) -> None:
        _check_ends(self)


class FrequencyBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A frequency [Hz] between two others."""

    low: PositiveNumber
    high: PositiveNumber

    def __post_init__(self) -> None:
        _check_ends(self)


class Warmth(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Factors at one end of the range of temperature: on the viscous friction of every regime, and
    on the drive's constant."""

    viscous: Factor = 1.0
    constant: Factor = 1.0


class Temperature(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One temperature a trial, between cold and hot; both factors lie as far between their ends as
    it does."""

    cold: Warmth
    hot: Warmth


class SpreadFault(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A sensor fault whose size and instant are drawn: kinds and meanings as in `sensor_faults`.
    at_s: from the start where not given.

    lasts_s: of encoder_stuck, which needs it, of encoder_invalid and of the drive's; else to the
    end.
    """

    kind: Kind
    at_s: InstantBand = InstantBand(0.0, 0.0)
    lasts_s: LastingBand | None = None
    counts: CountBand | None = None
    offset: DriveSpan | None = None
    gain_error: GainBand | None = None

    def __post_init__(self) -> None:
        check_fault(self.kind, self.counts, self.offset, self.gain_error)
        if self.kind == "lost_counts" and self.lasts_s is not None:
            raise ValueError("lasts_s: what an encoder has lost it does not find again")
        if self.kind == "encoder_stuck" and self.lasts_s is None:
            raise ValueError("encoder_stuck needs lasts_s")


class SpreadDisturbance(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """An effort on the axis that is drawn: kinds and meanings as in `disturbances`. at_s: from the
    start where not given."""

    kind: Literal["step", "pulse", "sine"]
    effort: EffortSpan
    at_s: InstantBand = InstantBand(0.0, 0.0)
    duration_s: LastingBand | None = None
    frequency_hz: FrequencyBand | None = None
    on: str | None = None

    def __post_init__(self) -> None:
        check_course(self.kind, self.duration_s is not None, self.frequency_hz is not None)


class Spread(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What a campaign varies beside the plant's own ranges.

    parameters: ranges of the plant's parameters, by name, in place of those that bench, model or
    mechanism give; low = high: that value. start: the position at rest. within_count: where within
    the encoder's count the axis starts, which is never known. wear: factor on all dry friction.
    temperature: cold to hot. sensor_faults, disturbances: in each trial all of them, beside those
    of the scenario.
    """

    parameters: dict[str, AnySpan] = {}
    start: PositionSpan | None = None
    within_count: bool = False
    wear: FactorBand | None = None
    temperature: Temperature | None = None
    sensor_faults: tuple[SpreadFault, ...] = ()
    disturbances: tuple[SpreadDisturbance, ...] = ()
