"""What a scenario does to the rig beside the reference: loads from outside, parameters that drift,
sensors that fail; what sources give."""

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
]  # of a mechanism's block; of an axis its own, which `simulate` checks
AnyDrive = Annotated[Quantity, _of("any drive")]
Kind = Literal["lost_counts", "encoder_stuck", "encoder_invalid", "drive_offset", "drive_gain"]


class Disturbance(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """An effort on the axis beside the drive's, from `at_s` on; a positive one drives forward.

    step: `effort` to the end. pulse: `effort` for `duration_s`. sine: `effort` sin(2 pi
    frequency_hz (t - at_s) + phase_deg), for `duration_s` or to the end. on: the block of a
    mechanism; without it the one that the controlled source drives.
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
    """What a source of a mechanism is asked for from `at_s` on, A, V or an effort; signals of one
    source add up.

    step: `level` to the end. pulse: `level` for `duration_s`. ramp: from 0 to `level` in
    `duration_s`, which is then kept. sine: `level` sin(2 pi frequency_hz (t - at_s) + phase_deg),
    for `duration_s` or to the end.
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
    """Raises ValueError where duration_s or frequency_hz, which are given or not, do not belong to
    the kind of course over time."""
    if kind == "step" and lasts:
        raise ValueError(
            "a step lasts to the end; one with duration_s is a pulse: write kind: pulse"
        )
    if kind == "pulse" and not lasts:
        raise ValueError("a pulse needs duration_s; without an end it is a step: write kind: step")
    if kind == "ramp" and not lasts:
        raise ValueError("a ramp needs duration_s, in which it reaches its level")
    if (kind == "sine") != swings:
        raise ValueError("frequency_hz belongs to kind sine, which needs it")


def _check_course(one: Disturbance | Signal) -> None:
    check_course(one.kind, one.duration_s is not None, one.frequency_hz is not None)
    if one.phase_deg != 0.0 and one.kind != "sine":
        raise ValueError("phase_deg belongs to kind sine")


def check_fault(kind: str, counts: object, offset: object, gain_error: object) -> None:
    """Raises ValueError where what is given, not None, is not what the kind of fault needs."""
    for key, needed, given in (
        ("counts", "lost_counts", counts),
        ("offset", "drive_offset", offset),
        ("gain_error", "drive_gain", gain_error),
    ):
        if (given is not None) != (kind == needed):
            raise ValueError(f"{key} belongs to kind {needed}, which needs it")


class DriftPoint(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The factor at a time; straight lines between points, before the first and after the last as
    there."""

    at_s: Instant
    factor: Factor


class Drifts(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Factors over time on what the plant has at the start: wear grows the friction, warmth lowers
    the constant and the viscous friction.

    friction: Coulomb friction and breakaway, their map over position, and those inside the
    backlash. viscous: of every regime of speed. constant: effort per unit of the drive, with the
    back-electromotive force.
    """

    friction: tuple[DriftPoint, ...] = ()
    viscous: tuple[DriftPoint, ...] = ()
    constant: tuple[DriftPoint, ...] = ()

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            for before, after in itertools.pairwise(getattr(self, name)):
                if before.at_s >= after.at_s:
                    raise ValueError(
                        f"{name}: found at_s {after.at_s:g} after {before.at_s:g}; allowed: rising times"
                    )


class SensorFault(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Sensor fault from `at_s` to `until_s`, or to the end.

    lost_counts: from `at_s` on the encoder reports `counts` too few (negative: too many).
    encoder_stuck: it repeats its last count. encoder_invalid: it reports NaN, as after a lost
    telegram. drive_offset, drive_gain: the drive's sensor shows (1 + gain_error) drive + offset. In
    the loop of a current drive the current then differs from what is measured; a voltage is not fed
    back, only its record is wrong.
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
                "until_s: what an encoder has lost it does not find again; lose -counts at that time where it is reset"
            )
        if self.kind == "encoder_stuck" and self.until_s is None:
            raise ValueError("encoder_stuck needs until_s")
        if self.until_s is not None and self.until_s <= self.at_s:
            raise ValueError(f"until_s: found {self.until_s:g}; allowed: after at_s, {self.at_s:g}")
