"""Disturbances, drifts, sensor faults and source commands of a scenario."""

from __future__ import annotations

import itertools
from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import PositiveNumber
from frictool.documents.quantity import Quantity, _of

Instant = Annotated[float, msgspec.Meta(ge=0)]
Factor = Annotated[float, msgspec.Meta(gt=0, le=100)]
GainError = Annotated[float, msgspec.Meta(gt=-1, le=10)]
DriveOffset = Annotated[Quantity, _of("drive")]
AnyEffort = Annotated[
    Quantity, _of("effort of either axis")
]  # unit of the mechanism's block, or of the axis, which `simulate` checks
AnyDrive = Annotated[Quantity, _of("any drive")]
Kind = Literal["lost_counts", "encoder_stuck", "encoder_invalid", "drive_offset", "drive_gain"]


class Disturbance(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """External effort on the axis; a positive effort pushes forward.

    - `kind`: Course of the effort. `step`: the effort has the level `effort` until the end.
      `pulse`: the effort has this level for `duration_s`. `sine`: the effort is `effort` sin(2 pi
      frequency_hz (t - at_s) + phase_deg), for `duration_s` or until the end.
    - `effort`: Level of the effort, or amplitude of the sine.
    - `on`: Block of a mechanism on which the effort acts. The default is the block that the
      controlled source drives.
    """

    kind: Literal["step", "pulse", "sine"]
    effort: AnyEffort
    at_s: Instant
    duration_s: PositiveNumber | None = None
    frequency_hz: PositiveNumber | None = None
    phase_deg: float = 0.0
    on: str | None = None

    def __post_init__(self) -> None:
        _check_course(self)


class Signal(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Command of a mechanism's source: a current [A], a voltage [V] or an effort.

    If a source has several signals, their values are added.

    - `kind`: Course of the signal. `step`: the signal is `level` until the end. `pulse`: the signal
      is `level` for `duration_s`. `ramp`: the signal rises from 0 to `level` in `duration_s`, then
      stays constant. `sine`: the signal is `level` sin(2 pi frequency_hz (t - at_s) + phase_deg),
      for `duration_s` or until the end.
    - `level`: Level of the signal, or amplitude of the sine.
    """

    kind: Literal["step", "pulse", "ramp", "sine"]
    level: AnyDrive
    at_s: Instant = 0.0
    duration_s: PositiveNumber | None = None
    frequency_hz: PositiveNumber | None = None
    phase_deg: float = 0.0

    def __post_init__(self) -> None:
        _check_course(self)


def check_course(kind: str, lasts: bool, swings: bool) -> None:
    """Raise ValueError if duration_s or frequency_hz does not fit this kind of signal.

    - lasts: True if duration_s is present
    - swings: True if frequency_hz is present
    """
    if kind == "step" and lasts:
        raise ValueError(
            "a step lasts to the end of the scenario and has no duration_s; for a limited time "
            "write kind: pulse"
        )
    if kind == "pulse" and not lasts:
        raise ValueError("a pulse needs duration_s; for an effort without an end write kind: step")
    if kind == "ramp" and not lasts:
        raise ValueError("a ramp needs duration_s, the time from 0 to `level`")
    if (kind == "sine") != swings:
        raise ValueError("frequency_hz: required with kind sine, and allowed with no other kind")


def _check_course(one: Disturbance | Signal) -> None:
    check_course(one.kind, one.duration_s is not None, one.frequency_hz is not None)
    if one.phase_deg != 0.0 and one.kind != "sine":
        raise ValueError("phase_deg belongs to kind sine")


def check_fault(kind: str, counts: object, offset: object, gain_error: object) -> None:
    """Raise ValueError if the values of a sensor fault do not fit its kind.

    `counts`, `offset`, `gain_error`: values of these keys, None if the key is absent.
    """
    for key, needed, value in (
        ("counts", "lost_counts", counts),
        ("offset", "drive_offset", offset),
        ("gain_error", "drive_gain", gain_error),
    ):
        if (value is not None) != (kind == needed):
            raise ValueError(f"{key}: required with kind {needed}, and allowed with no other kind")


class DriftPoint(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Factor on a parameter at one time.

    The factor is linear between points, and constant before the first and after the last point.

    - `factor`: Factor by which the initial parameter is multiplied.
    """

    at_s: Instant
    factor: Factor


class Drifts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Factors by which plant parameters change over time, for example because of wear.

    - `friction`: Factor on all dry friction: Coulomb friction, breakaway, and the friction inside
      the backlash.
    - `viscous`: Factor on the viscous friction of every speed regime.
    - `constant`: Factor on the effort per unit of the drive and on the back-EMF.
    """

    friction: tuple[DriftPoint, ...] = ()
    viscous: tuple[DriftPoint, ...] = ()
    constant: tuple[DriftPoint, ...] = ()

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            for before, after in itertools.pairwise(getattr(self, name)):
                if before.at_s >= after.at_s:
                    raise ValueError(
                        f"{name}: found at_s {after.at_s:g} after {before.at_s:g}; "
                        "allowed: rising times"
                    )


class ControllerCommand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Supervisor's command, which acts from the first sample at or after `at_s`.

    - `command`: Command by name. `disable`: the drive is 0 until the command `enable`. `enable`:
      the controller starts at rest at the measured position. `hold`: the last valid reference is
      kept until the command `follow`. `fault`: the drive is 0 until the command `reset`, which also
      acts as `enable` and `follow`.
    """

    command: Literal["disable", "enable", "hold", "follow", "fault", "reset"]
    at_s: Instant


class SensorFault(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Sensor fault that begins at `at_s`.

    - `kind`: Kind of the fault. `lost_counts`: the encoder's reading is too low by `counts` counts.
      `encoder_stuck`: the encoder repeats its last count. `encoder_invalid`: the encoder reports
      NaN, as after a lost telegram. `drive_offset`, `drive_gain`: the drive's sensor shows (1 +
      gain_error) drive + offset. A current drive feeds this value back, so that the true current
      changes. In a voltage drive, only the logged value is wrong.
    - `until_s`: End of the fault; required with kind `encoder_stuck`, not allowed with
      `lost_counts`. The default is the end of the scenario.
    - `counts`: Number of lost counts; negative if the reading is too high.
    - `offset`: Offset of the drive's sensor.
    - `gain_error`: Gain error of the drive's sensor.
    """

    kind: Kind
    at_s: Instant
    until_s: PositiveNumber | None = None
    counts: int | None = None
    offset: DriveOffset | None = None
    gain_error: GainError | None = None

    def __post_init__(self) -> None:
        check_fault(self.kind, self.counts, self.offset, self.gain_error)
        if self.counts == 0:
            raise ValueError("counts: found 0; allowed: a whole number other than 0")
        if self.kind == "lost_counts" and self.until_s is not None:
            raise ValueError(
                "until_s: not allowed with kind lost_counts, whose error of the position is "
                "permanent; to end it, add a second fault with the opposite counts at that time"
            )
        if self.kind == "encoder_stuck" and self.until_s is None:
            raise ValueError("encoder_stuck needs until_s, the time at which the fault ends")
        if self.until_s is not None and self.until_s <= self.at_s:
            raise ValueError(f"until_s: found {self.until_s:g}; allowed: after at_s, {self.at_s:g}")
