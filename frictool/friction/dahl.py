"""Dahl's law with any exponent i > 0 (thesis 2.37-2.38).

    F = sigma z        z' = v |a|^i sign(a),   a = 1 - sigma z sign(v)/F_c

z is the deflection of the contact, sigma its stiffness, v the velocity, and F_c the Coulomb
friction. For i = 1 this is z' = v (1 - sigma z sign(v)/F_c), (2.38). In steady slip |F| = F_c. The
law is dissipative with the storage function sigma z^2/2.
"""

from __future__ import annotations

import math

from frictool.friction.dynamic_kernels import no_memory, scalar_reset
from frictool.friction.law import DynamicKernels, Law
from frictool.friction.parameter import POSITIVE_COULOMB, STIFFNESS, LawParameter
from frictool.friction.status_codes import NOT_FINITE, OK
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

EXPONENT = LawParameter(  # i; 1 in (2.38)
    "exponent", "", 0.0, 100.0, exclusive=True, default=1.0, comparison_value=lambda _: 1.0
)


@kernel
def rate(z: Vector, v: float, p: Vector, out: Vector) -> int:
    """Write the rate z' [m/s | rad/s] of the state z to out (1,); return a status code."""
    towards = 1.0 if v >= 0.0 else -1.0
    a = 1.0 - p[1] * z[0] * towards / p[0]
    slipped = v * math.copysign(abs(a) ** p[2], a)
    if not math.isfinite(slipped):
        return NOT_FINITE
    out[0] = slipped
    return OK


@kernel
def force(z: Vector, zdot: Vector, v: float, p: Vector) -> float:
    """Return the friction sigma z [N | N m] at the state z."""
    return float(p[1] * z[0])


LAW = Law(
    "dahl",
    "Dahl",
    "(2.37)-(2.38)",
    (POSITIVE_COULOMB, STIFFNESS, EXPONENT),
    DynamicKernels(rate, force, no_memory, scalar_reset),
)
