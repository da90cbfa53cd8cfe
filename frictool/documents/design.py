"""`design.yaml`: how a controller is to be found: structure, method, weights, position law."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.quantity import Axis, PositiveLength, PositiveVelocity


class Weights(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Weights of the generalised plant (5.53)-(5.58); what is absent is derived from the specification.

    bandwidth_rad_s: z2 of (5.56). modulus_margin: M_mod of (5.57). static_error: e_stat of (5.57), relative.
    disturbance: W1. drive: W3, on the drive that reaches the actuator. command: weight on the commanded drive
    (per A or V). noise: amplitude of the measurement noise that the design stands (rad or m), at least the encoder's step
    times a few per cent.
    """

    bandwidth_rad_s: PositiveNumber
    disturbance: PositiveNumber
    drive: PositiveNumber
    command: PositiveNumber
    noise: PositiveLength
    modulus_margin: Annotated[float, msgspec.Meta(gt=0, lt=1)] | None = None
    static_error: Annotated[float, msgspec.Meta(gt=0, lt=1)] | None = None


class PositionLaw(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The square-root law (5.19), annex (5), and what happens inside its band.

    formula: `sqrt(2F/J)` is annex (5), `sqrt(F/J)` is annex 5.2 (lower by sqrt 2). virtual_coulomb replaces F by F_cv > F_c (annex 3.1).
    action: `cut` sets the drive to zero inside the band; `brake` keeps the loop closed with a speed reference of zero until the
    measured speed is below `rest_speed`, then sets the drive to zero. Either waits until the prefilter moves slower than `settled_speed`.
    """

    formula: Literal["sqrt(2F/J)", "sqrt(F/J)"]
    band: PositiveLength
    action: Literal["cut", "brake"]
    settled_speed: PositiveVelocity
    rest_speed: PositiveVelocity | None = None
    virtual_coulomb_factor: Annotated[float, msgspec.Meta(ge=1)] = 1.0
    speed_filter_rad_s: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if self.action == "brake" and (self.rest_speed is None or self.speed_filter_rad_s is None):
            raise ValueError("action brake needs rest_speed and speed_filter_rad_s")


class Prefilter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Second-order low-pass of the position reference (5.69)."""

    natural_frequency_rad_s: PositiveNumber
    damping: PositiveNumber


class Design(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`design.yaml`."""

    format: Literal["design/1"]
    name: Name
    axis: Axis
    structure: Literal["speed_cascade"]
    method: Literal["lpv"]
    weights: Weights
    position_law: PositionLaw
    prefilter: Prefilter | None = None
    recentring: Annotated[float, msgspec.Meta(gt=1, le=2)] = 1.1
