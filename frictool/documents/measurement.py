"""`measurement` of `model.yaml`: properties of the rig that were identified from logs.

Friction is not one of these properties.
"""

from __future__ import annotations

import msgspec

from frictool.documents.quantity import (
    NonNegativeLengthEstimate,
    NonNegativeTimeEstimate,
    PositiveConstantEstimate,
    PositiveInductanceEstimate,
    PositiveResistanceEstimate,
    TimeEstimate,
)


class Measurement(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Properties of the rig, apart from friction, that were identified from the logs.

    - `backlash`: Full width of the backlash.
    - `delay`: Delay of the logged drive relative to the position; negative if the drive is ahead.
    - `loop_time_constant`: Time constant of the current loop, identified from commanded and
      measured current.
    - `resistance`: Resistance of the motor's winding, identified from its voltage and current.
    - `back_emf_constant`: Voltage per speed of the motor. For a DC motor, it equals the effort per
      ampere (in SI).
    - `inductance`: Inductance of the motor's winding.
    - `refused`: Reason for each property that could not be identified.
    """

    backlash: NonNegativeLengthEstimate | None = None
    delay: TimeEstimate | None = None
    loop_time_constant: NonNegativeTimeEstimate | None = None
    resistance: PositiveResistanceEstimate | None = None
    back_emf_constant: PositiveConstantEstimate | None = None
    inductance: PositiveInductanceEstimate | None = None
    refused: dict[str, str] = {}


MEASURED = Measurement.__struct_fields__[:-1]  # names of the properties
