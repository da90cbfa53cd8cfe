"""The elasto-plastic law (thesis 2.43-2.48): LuGre with purely elastic presliding below z_ba.

    z' = v (1 - alpha(z, v) sigma_0 sign(v) z/g(v))        F = sigma_0 z + sigma_1 z' + sigma_v v
    alpha = 0 if |z| < z_ba or z v <= 0; rises as half a sine to 1 at z_max = F_s/sigma_0,
            then 1                                                             (2.45)-(2.46)

friction/lugre.py defines the other symbols; F_s is the breakaway. z_ba must be below z_max.
Table 3.1 has z_ba = 0.009 m instead of 0.009 mm; with 0.009 m the body would never slide.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from frictool.friction.dynamic_kernels import no_memory, scalar_reset
from frictool.friction.law import DynamicKernels, Law
from frictool.friction.lugre import SIGMA_0, force
from frictool.friction.parameter import DAMPING, POSITIVE_STRIBECK, STIFFNESS, Axis, LawParameter
from frictool.friction.status_codes import NOT_FINITE, OK
from frictool.friction.stribeck import BREAKAWAY, curve
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

PLASTIC_FROM = 0.9  # default of z_ba/z_max
ELASTIC_LIMIT = LawParameter(  # z_ba
    "elastic_limit",
    "m",
    comparison_value=lambda q: q["plastic_from"] * q["breakaway"] / q["stiffness"],
)
Z_BA = 7


@kernel
def plasticity(z: float, v: float, p: Vector) -> float:
    """Return alpha(z, v) of thesis (2.45)-(2.46), from 0 (elastic) to 1 (plastic)."""
    size = abs(z)
    yielded = p[BREAKAWAY] / p[SIGMA_0]
    if z * v <= 0.0 or size < p[Z_BA]:
        return 0.0
    if size >= yielded:
        return 1.0
    return 0.5 * (
        math.sin(math.pi * (size - 0.5 * (yielded + p[Z_BA])) / (yielded - p[Z_BA])) + 1.0
    )


@kernel
def rate(z: Vector, v: float, p: Vector, out: Vector) -> int:
    """Write the rate z' [m/s | rad/s] of the state z to out (1,); return a status code."""
    slipped = v - plasticity(z[0], v, p) * p[SIGMA_0] * abs(v) * z[0] / curve(v, p)
    if not math.isfinite(slipped):
        return NOT_FINITE
    out[0] = slipped
    return OK


@dataclass(frozen=True)
class ElastoPlasticLaw(Law):
    """The elasto-plastic law; `pack` checks that the elastic limit z_ba is below z_max."""

    def pack(
        self, values: Mapping[str, float], axis: Axis = "linear", tail: Vector | None = None
    ) -> Vector:
        """Return the parameter array p, as `Law.pack` does.

        Also raises ValueError if the elastic limit z_ba is not below the largest presliding
        z_max = F_s/sigma_0, the breakaway divided by the stiffness.
        """
        p = super().pack(values, axis, tail)
        yielded = p[BREAKAWAY] / p[SIGMA_0]
        if p[Z_BA] >= yielded:
            unit = ELASTIC_LIMIT.unit(axis)
            raise ValueError(
                f"elastic_limit is {p[Z_BA]:g} {unit}; allowed: < breakaway/stiffness, "
                f"{yielded:g} {unit}; with a larger value, the contact never slides"
            )
        return p


LAW = ElastoPlasticLaw(
    "elasto_plastic",
    "Elasto-plastic",
    "(2.43)-(2.48)",
    (*POSITIVE_STRIBECK, STIFFNESS, DAMPING, ELASTIC_LIMIT),
    DynamicKernels(rate, force, no_memory, scalar_reset),
)
