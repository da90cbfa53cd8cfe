"""`weights` of `design.yaml`: weights of the closed-loop norm."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.quantity import NonNegativeLength

Positive = Annotated[float, msgspec.Meta(gt=0)]
NonNegative = Annotated[float, msgspec.Meta(ge=0)]
Share = Annotated[float, msgspec.Meta(gt=0, lt=1)]


class NoiseFilter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Frequency dependence of the noise weight W4.

    - `frequency_hz`: Corner frequency.
    - `reading`: `as printed` is a low-pass filter with its pole at 2 pi frequency_hz and its zero a
      decade above; `reciprocal` is the inverse of that filter, a high-pass filter.
    """

    # annex (25) as printed is a low-pass; the annex text describes the reciprocal, a high-pass
    frequency_hz: Positive
    reading: Literal["as printed", "reciprocal"]


class Weights(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Weights of the generalised plant (docs/theory/plants.md).

    A weight whose key is absent is derived from the specification and bench.yaml.

    - `bandwidth_rad_s`: Bandwidth of the error weight W2.
    - `disturbance`: Disturbance weight W1.
    - `drive`: Weight W3 on the drive that reaches the actuator.
    - `command`: Weight on the commanded drive [1/A | 1/V]; with 0, the drive is not weighted.
    - `noise`: Amplitude of the measurement noise in the design; 0 for a design without noise.
    - `modulus_margin`: Modulus margin that the error weight W2 requires.
    - `static_error`: Relative static error that the error weight W2 allows.
    - `noise_filter`: Frequency dependence of the noise weight W4. By default W4 is constant.
    - `eta`: Weight on eta, the position error that is the input of the linear controller.
    - `uncertainty_hz`: Corner frequency of the uncertainty weight W5. The default is W5 = 1.
    - `count_share`: Fraction of the drive's limit that one encoder count may command. This key is
      used if `command` is absent.
    """

    # generalised plant (5.53)-(5.58), annex (24)-(26): bandwidth_rad_s is z2 of (5.56), 2 pi f2 of
    # (24);
    # modulus_margin and static_error are M_mod and e_stat of (5.57); noise is G4; uncertainty_hz f5
    # of (26)
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
