"""`weights` of `design.yaml`: weights of the closed-loop norm."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.quantity import NonNegativeLength

Positive = Annotated[float, msgspec.Meta(gt=0)]
NonNegative = Annotated[float, msgspec.Meta(ge=0)]
Share = Annotated[float, msgspec.Meta(gt=0, lt=1)]


class NoiseFilter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Dynamics of W4, annex (25), with `frequency_hz` f4.

    Annex (25) as printed has its pole at 2 pi f4 and its zero a decade above, which is a low-pass.
    The text calls it a high-pass, which is its reciprocal. `reading` selects one of them.
    """

    frequency_hz: Positive
    reading: Literal["as printed", "reciprocal"]


class Weights(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Weights of the generalised plant (5.53)-(5.58), annex (24)-(26).

    Absent weights are derived from the specification and the bench.

    `bandwidth_rad_s`: z2 of (5.56), 2 pi f2 of (24). `modulus_margin`: M_mod of (5.57).
    `static_error`: relative e_stat of (5.57). `disturbance`: W1. `drive`: W3, on the drive that
    reaches the actuator. `command`: weight on the commanded drive [1/A | 1/V], 0 for none. `noise`:
    amplitude of the measurement noise in the design [rad | m] (G4 of the annex), 0 for none.
    `noise_filter`: dynamics of W4. `eta`: weight on the measured signal. `uncertainty_hz`: f5 of W5
    (26); by default W5 = 1.

    `count_share`: if `command` is absent, the share of the drive's limit that one encoder count may
    command.
    """

    bandwidth_rad_s: Positive | None = None
    disturbance: Positive | None = None
    drive: Positive | None = None
    command: NonNegative | None = None
    noise: NonNegativeLength | None = None
    modulus_margin: Share | None = None
    static_error: Share | None = None
    noise_filter: NoiseFilter | None = None
    eta: NonNegative = 0.0
    uncertainty_hz: Positive | None = None
    count_share: Positive = 1.0
