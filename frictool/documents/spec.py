"""`spec.yaml`: requirements of the closed loop; each key is one requirement of the verdict."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.quantity import Axis, DriveLimit, NonNegativeLength, PositiveLength


class Rest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Rest after `after_s` of constant reference (thesis 5.4.1).

    Allowed are motion within the sensor's step and a drive up to `drive` [A | V], by default zero.
    """

    after_s: PositiveNumber
    drive: Annotated[float, msgspec.Meta(ge=0)] = 0.0


class Energy(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Limit of the drive's mean square over the first `window_s` of a step [A^2 | V^2].

    This is the energy of table 5.3.
    """

    window_s: PositiveNumber
    limit: PositiveNumber


class Spec(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`spec.yaml`. Each key is defined in docs/theory/report.md.

    `limit_cycle`: largest allowed amplitude, half of the peak-to-peak value. `drive_rms`: over a
    whole log. `saturation_time_s`: time with the drive at its limit, in one hold.
    `load_static_error`: of the mechanical position behind the backlash. `examples`: as in
    bench.yaml.
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
