"""`spec.yaml`: what the closed loop has to do. Each key that is present is one requirement of the
verdict."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.quantity import Axis, DriveLimit, NonNegativeLength, PositiveLength


class Rest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """After `after_s` of constant reference: no motion beyond the sensor's step and no more drive
    than `drive` (thesis 5.4.1: none)."""

    after_s: PositiveNumber
    drive: Annotated[float, msgspec.Meta(ge=0)] = 0.0


class Energy(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Mean square of the drive over the first `window_s` of a step, as table 5.3 counts energy, in
    A^2 or V^2."""

    window_s: PositiveNumber
    limit: PositiveNumber


class Spec(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`spec.yaml`. What each key asks for is defined in docs/theory/report.md.

    limit_cycle: the largest amplitude allowed, half of the peak to peak. drive_rms: over the whole
    of a log. saturation_time_s: with the drive at its limit, in one hold. load_static_error: of the
    mechanical position behind the backlash. examples: as in bench.yaml.
    """

    format: Literal["spec/1"]
    name: Name
    axis: Axis
    drive: Literal["current", "voltage"]
    response_time_95_s: PositiveNumber | None = None
    rise_time_s: PositiveNumber | None = None
    overshoot_percent: Annotated[float, msgspec.Meta(ge=0)] | None = None
    static_error: PositiveLength | None = None
    load_static_error: PositiveLength | None = None
    oscillations: Annotated[int, msgspec.Meta(ge=0)] | None = None
    limit_cycle: NonNegativeLength | None = None
    modulus_margin: Annotated[float, msgspec.Meta(gt=0, lt=1)] | None = None
    drive_peak: DriveLimit | None = None
    drive_rms: DriveLimit | None = None
    saturation_time_s: Annotated[float, msgspec.Meta(ge=0)] | None = None
    rest: Rest | None = None
    energy: Energy | None = None
    examples: tuple[str, ...] = ()


REQUIREMENTS = tuple(
    key
    for key in Spec.__struct_fields__
    if key not in ("format", "name", "axis", "drive", "examples")
)
