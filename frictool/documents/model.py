"""`model.yaml`: identified parameters with intervals, the bench, and reasons for missing values."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Bench, Name
from frictool.documents.laws import Laws
from frictool.documents.measurement import Measurement
from frictool.documents.presliding import Presliding
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import (
    Axis,
    EffortEstimate,
    InertiaEstimate,
    NonNegativeEffortEstimate,
    PositiveVelocityEstimate,
    ViscousEstimate,
)
from frictool.documents.resonances import Resonances


class Parameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Parameters of J dv/dt = u - offset - viscous v - coulomb sign(v), with breakaway at rest.

    The equations are (4.17) and (4.43). With `stribeck_velocity` v_s the friction falls from
    `breakaway` to `coulomb` by (2.34).
    """

    inertia: InertiaEstimate
    viscous: ViscousEstimate
    coulomb: NonNegativeEffortEstimate
    breakaway: NonNegativeEffortEstimate
    offset: EffortEstimate
    stribeck_velocity: PositiveVelocityEstimate | None = None


class Fit(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Quality of the fit on its own logs.

    `held_out_force_error` occurs in models of earlier versions only.
    """

    force_error: float | None
    condition: float
    samples: int
    held_out_force_error: float | None = None


class Model(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`model.yaml`.

    `not_identified` maps each parameter that the logs do not determine to the reason. `laws`:
    friction by direction, speed, position and time at rest. `presliding`: friction before
    breakaway. `measurement`: properties of the bench. `resonances`: modes of compliant links; a
    controller is verified with them, but a simulation of one axis cannot include them.

    `bench_values_only`: the reason why nothing was identified. Every parameter then has the bench's
    value, and `synth` refuses the model.
    """

    format: Literal["model/1"]
    name: Name
    axis: Axis
    law: Literal["coulomb", "stribeck"]
    method: str
    confidence: Annotated[float, msgspec.Meta(gt=0, lt=1)]
    bench: Bench
    parameters: Parameters
    provenance: Provenance
    not_identified: dict[str, str] = {}
    fit: Fit | None = None
    laws: Laws | None = None
    presliding: Presliding | None = None
    measurement: Measurement | None = None
    resonances: Resonances | None = None
    bench_values_only: str | None = None

    def __post_init__(self) -> None:
        if (self.law == "stribeck") != (self.parameters.stribeck_velocity is not None):
            raise ValueError(
                f"law: found {self.law}; parameters.stribeck_velocity belongs to law "
                "stribeck, which needs it"
            )
