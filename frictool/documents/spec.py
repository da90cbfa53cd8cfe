"""`spec.yaml`: requirements of the closed loop; each key is one requirement of the verdict."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.quantity import Axis, DriveLimit, NonNegativeLength, PositiveLength


class Rest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Rest after some seconds of constant reference.

    Allowed are motion within the sensor's step and a drive up to `drive`.

    - `after_s`: Duration of a constant reference after which the axis must rest.
    - `drive`: Largest drive at rest [A | V].
    """

    # thesis 5.4.1
    after_s: PositiveNumber
    drive: Annotated[float, msgspec.Meta(ge=0)] = 0.0


class Energy(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Limit of the drive's mean square over the first seconds of a step.

    - `window_s`: Duration over which the mean is taken, from the step on.
    - `limit`: Largest mean square of the drive [A^2 | V^2].
    """

    # the energy of table 5.3
    window_s: PositiveNumber
    limit: PositiveNumber


class Spec(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Requirements on the closed loop: `spec.yaml`. Each key but the first four is one requirement.

    docs/metrics.md defines each metric.

    - `response_time_95_s`: Largest time from a step of the reference until the position stays
      within 5 % of the step.
    - `rise_time_s`: Largest time from 10 % to 90 % of a step.
    - `overshoot_percent`: Largest overshoot, relative to the step.
    - `static_error`: Largest error at the end of a hold.
    - `load_static_error`: Largest error of the mechanical position behind the backlash, at the end
      of a hold.
    - `oscillations`: Largest number of reversals during a step.
    - `limit_cycle`: Largest amplitude of a limit cycle: half of the peak-to-peak value.
    - `modulus_margin`: Smallest distance of the loop's Nyquist curve from -1.
    - `drive_peak`: Largest magnitude of the drive.
    - `drive_rms`: Largest rms of the drive over a whole log.
    - `saturation_time_s`: Longest time with the drive at its limit, in one hold.
    - `rest`: Condition of rest.
    - `energy`: Limit of the drive's mean square.
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
