"""The elasto-plastic law (2.43)-(2.48): LuGre whose presliding is purely elastic below z_ba.

    z' = v (1 - alpha(z, v) sigma_0 sign(v) z/g(v))        F = sigma_0 z + sigma_1 z' + sigma_v v
    alpha = 0 where |z| < z_ba or z opposes v; rises as half a sine up to z_max = F_s/sigma_0; 1 beyond           (2.45)-(2.46)

z_ba lies below z_max: table 3.1 prints 0.009 m for 0.009 mm, with which nothing would ever slide.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.friction.dynamic_kernels import no_memory, scalar_reset
from frictool.friction.law import DynamicKernels, Law
from frictool.friction.lugre import SIGMA_0, force
from frictool.friction.parameter import DAMPING, POSITIVE_STRIBECK, STIFFNESS, Axis, LawParameter
from frictool.friction.status import NOT_FINITE, OK
from frictool.friction.stribeck import BREAKAWAY, curve
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]
ELASTIC_LIMIT = LawParameter("elastic_limit", "m", "rad")  # z_ba
Z_BA = 7


@kernel
def plasticity(z: float, v: float, p: Vector) -> float:
    """alpha(z, v) in [0, 1], (2.45)-(2.46): 0 sticks, 1 slips."""
    size, yielded = abs(z), p[BREAKAWAY] / p[SIGMA_0]
    if z * v <= 0.0 or size < p[Z_BA]:
        return 0.0
    if size >= yielded:
        return 1.0
    return 0.5 * (
        math.sin(math.pi * (size - 0.5 * (yielded + p[Z_BA])) / (yielded - p[Z_BA])) + 1.0
    )


@kernel
def rate(z: Vector, v: float, p: Vector, out: Vector) -> int:
    """Fills out (1,) with z' [m/s | rad/s], (2.44). Returns friction/status.py."""
    slipped = v - plasticity(z[0], v, p) * p[SIGMA_0] * abs(v) * z[0] / curve(v, p)
    if not math.isfinite(slipped):
        return NOT_FINITE
    out[0] = slipped
    return OK


@dataclass(frozen=True)
class ElastoPlasticLaw(Law):
    """The law, with the relation between its parameters that single bounds do not tell."""

    def pack(
        self, values: Mapping[str, float], axis: Axis = "linear", tail: Vector | None = None
    ) -> Vector:
        """As `Law.pack`; also raises ValueError where z_ba is not below z_max = F_s/sigma_0."""
        p = super().pack(values, axis, tail)
        yielded = p[BREAKAWAY] / p[SIGMA_0]
        if p[Z_BA] >= yielded:
            unit = ELASTIC_LIMIT.unit(axis)
            raise ValueError(
                f"elastic_limit is {p[Z_BA]:g} {unit}; allowed: < breakaway/stiffness, {yielded:g} {unit} (nothing would ever slide)"
            )
        return p


LAW = ElastoPlasticLaw(
    "elasto_plastic",
    "Elasto-plastic",
    "(2.43)-(2.48)",
    (*POSITIVE_STRIBECK, STIFFNESS, DAMPING, ELASTIC_LIMIT),
    DynamicKernels(rate, force, no_memory, scalar_reset),
)
