"""The LuGre law (thesis 2.40-2.42).

    z' = v - sigma_0 |v| z/g(v)        F = sigma_0 z + sigma_1 z' + sigma_v v

z is the deflection of the contact, sigma_0 its stiffness, sigma_1 its damping, v the velocity, and
sigma_v the viscous coefficient. g is the curve of friction/stribeck.py: steady slip follows
Stribeck's law. The law is dissipative with the storage function sigma_0 z^2/2 as long as
sigma_1 |v| <= 4 g(v). The body drifts under an oscillating effort of any size (table 3.2).
"""

from __future__ import annotations

import math

from frictool.friction.dynamic_kernels import no_memory, scalar_reset
from frictool.friction.law import DynamicKernels, Law
from frictool.friction.parameter import DAMPING, POSITIVE_STRIBECK, STIFFNESS
from frictool.friction.status_codes import NOT_FINITE, OK
from frictool.friction.stribeck import VISCOUS, curve
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

SIGMA_0, SIGMA_1 = 5, 6


@kernel
def rate(z: Vector, v: float, p: Vector, out: Vector) -> int:
    """Write the rate z' [m/s | rad/s] of the deflection z to out (1,); return a status code."""
    slipped = v - p[SIGMA_0] * abs(v) * z[0] / curve(v, p)
    if not math.isfinite(slipped):
        return NOT_FINITE
    out[0] = slipped
    return OK


@kernel
def force(z: Vector, zdot: Vector, v: float, p: Vector) -> float:
    """Return the friction [N | N m] (thesis 2.42)."""
    return float(p[SIGMA_0] * z[0] + p[SIGMA_1] * zdot[0] + p[VISCOUS] * v)


LAW = Law(
    "lugre",
    "LuGre",
    "(2.40)-(2.42)",
    (*POSITIVE_STRIBECK, STIFFNESS, DAMPING),
    DynamicKernels(rate, force, no_memory, scalar_reset),
)
