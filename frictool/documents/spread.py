"""`spread:` of scenario.yaml: random variations of plant, faults and disturbances in a campaign.

`simulate` ignores this key. The variations are drawn in addition to the ranges of bench, model or
mechanism. Every value is drawn uniformly from its range and independently of the other values. A
breakaway is drawn from those values of its range that are not below the drawn Coulomb friction; if
only the model has an interval of the breakaway, the ratio of breakaway to Coulomb friction is drawn
instead.
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
EffortSpan = Annotated[Span, _of("effort of either axis")]  # units as in `disturbances`
AnySpan = Annotated[Span, _of("any")]


def _check_ends(
    one: FactorBand | InstantBand | LastingBand | GainBand | CountBand | FrequencyBand,
) -> None:
    if one.low > one.high:
        raise ValueError(f"low: found {one.low:g} above high {one.high:g}; allowed: low <= high")


class FactorBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Range from which a factor is drawn."""

    low: Factor
    high: Factor

    def __post_init__(self) -> None:
        _check_ends(self)


class InstantBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Range from which a time [s] is drawn."""

    low: Instant
    high: Instant

    def __post_init__(self) -> None:
        _check_ends(self)


class LastingBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Range from which a duration [s] is drawn."""

    low: PositiveNumber
    high: PositiveNumber

    def __post_init__(self) -> None:
        _check_ends(self)


class GainBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Range from which a gain error is drawn."""

    low: GainError
    high: GainError

    def __post_init__(self) -> None:
        _check_ends(self)


class CountBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Range from which an integer is drawn; all integers have the same probability."""

    low: int
    high: int

    def __post_init__(self) -> None:
        _check_ends(self)


class FrequencyBand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Range from which a frequency [Hz] is drawn."""

    low: PositiveNumber
    high: PositiveNumber

    def __post_init__(self) -> None:
        _check_ends(self)


class Warmth(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Factors at the coldest or at the hottest temperature.

    - `viscous`: Factor on the viscous friction of every speed regime.
    - `constant`: Factor on the drive's constant.
    """

    viscous: Factor = 1.0
    constant: Factor = 1.0


class Temperature(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Effect of a temperature that is drawn between cold and hot for each simulated plant.

    The factors at a temperature between the ends are interpolated linearly.

    - `cold`, `hot`: Factors for viscous friction and drive constant at the coldest and at the
      hottest temperature.
    """

    cold: Warmth
    hot: Warmth


class SpreadFault(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Sensor fault of random size and time.

    - `kind`: Kind of the fault, as in `sensor_faults`.
    - `at_s`: Range of the start. The default is the start of the scenario.
    - `lasts_s`: Range of the duration. The key is required with kind `encoder_stuck`. If the key is
      absent, `encoder_invalid` and faults of the drive's sensor last to the end.
    - `counts`: Range of the number of lost counts.
    - `offset`: Range of the sensor's offset.
    - `gain_error`: Range of the sensor's gain error.
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
            raise ValueError(
                "lasts_s: not allowed with kind lost_counts, whose error of the position is "
                "permanent; remove lasts_s"
            )
        if self.kind == "encoder_stuck" and self.lasts_s is None:
            raise ValueError("encoder_stuck needs lasts_s, the range of its duration")


class SpreadDisturbance(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Random external effort on the axis.

    - `kind`: Kind of the effort, as in `disturbances`.
    - `effort`: Range of the effort's level or amplitude.
    - `at_s`: Range of the start. The default is the start of the scenario.
    - `duration_s`: Range of the duration.
    - `frequency_hz`: Range of the frequency.
    - `on`: Block of a mechanism on which the effort acts. The default is the block that the
      controlled source drives.
    """

    kind: Literal["step", "pulse", "sine"]
    effort: EffortSpan
    at_s: InstantBand = InstantBand(0.0, 0.0)
    duration_s: LastingBand | None = None
    frequency_hz: FrequencyBand | None = None
    on: str | None = None

    def __post_init__(self) -> None:
        check_course(self.kind, self.duration_s is not None, self.frequency_hz is not None)


class Spread(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Random variations of a campaign, in addition to the ranges of bench, model or mechanism.

    Every value is drawn uniformly and independently. A range with equal ends is a fixed value. A
    range with values that no plant can have is an error.

    - `parameters`: Ranges of plant parameters by name, which replace the ranges in the bench, model
      or mechanism.
    - `start`: Range of the initial position.
    - `within_count`: True to draw the initial position within one encoder count, which the encoder
      cannot resolve.
    - `wear`: Range of the factor by which all dry friction is multiplied.
    - `temperature`: Factors at the coldest and at the hottest temperature. For each plant, a
      temperature between these ends is drawn.
    - `sensor_faults`: Sensor faults in every simulation, in addition to the scenario's faults.
    - `disturbances`: Efforts in every simulation, in addition to the scenario's disturbances.
    """

    parameters: dict[str, AnySpan] = {}
    start: PositionSpan | None = None
    within_count: bool = False
    wear: FactorBand | None = None
    temperature: Temperature | None = None
    sensor_faults: tuple[SpreadFault, ...] = ()
    disturbances: tuple[SpreadDisturbance, ...] = ()
