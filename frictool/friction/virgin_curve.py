"""The virgin curve of presliding: force against displacement of a contact that has never moved.

    f(z) = F_s (1 - (1 - z/z_max)^2)    for 0 <= z <= z_max,  F_s beyond,  f(-z) = -f(z)

z is the deflection of the contact, z_max its largest value, and F_s the breakaway. Source: annex A
of the thesis, rule I; figure 3.8. The curve is concave, and the hysteresis generated from it
therefore dissipates in every movement (annex A: y'' <= 0).
"""

from __future__ import annotations

import math

from frictool.runtime.kernels import kernel


@kernel
def virgin_force(z: float, breakaway: float, limit: float) -> float:
    """Return the force f(z) [N | N m] at a displacement z; f(limit) = breakaway."""
    left = 1.0 - min(abs(z) / limit, 1.0)
    return math.copysign(breakaway * (1.0 - left * left), z)
