"""Hybrid law, version B: linear presliding (thesis 3.32-3.36).

    mode 0   z' = v, m v' = u - k1 z - k2 v     C_{0->1}: (z >= z_max, u > F_s, v >= 0)
                                                       or (z <= -z_max, u < -F_s, v <= 0)
    mode 1   Stribeck's law, z = +-z_max        C_{1->0}: (3.2)
    k1 = F_s/z_max, k2 = 2 sqrt(m F_s/z_max)    (3.35)

m is the mass, u the effort, x the position, v the velocity, and F_s the breakaway. With k1 and k2,
the spring force is F_s at z_max, and the damping is critical. C_{i->j} is the condition for the
switch from mode i to mode j. The state is z = [z], the presliding displacement, which is limited to
+-z_max. A capture is the switch from mode 1 to mode 0. The code corrects three points of the
thesis:

- (3.12) and (3.13) exchange k1 and k2; the code follows (3.17) and (3.32).
- (3.13) and (3.32) have x = x_{1->0} + z. In the code, x_{1->0} is the value of x - z at the
  capture, so that x is continuous. An integration of x' = v has the same result.
- (3.34) has no condition on v. A body that moves back while u rises past F_s would then start to
  slip at the wrong limit and be captured immediately (3.27).
"""

from __future__ import annotations

import math

from frictool.friction.dynamic_kernels import scalar_reset
from frictool.friction.hybrid_kernels import (
    HYBRID,
    MASS,
    SLIPPING,
    STUCK,
    is_captured,
    no_memory,
    sliding_force,
)
from frictool.friction.law import HybridKernels, Law
from frictool.friction.parameter import PRESLIDING_LIMIT
from frictool.friction.status_codes import NOT_FINITE, OK
from frictool.friction.stribeck import BREAKAWAY
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

LIMIT = 7


@kernel
def presliding_stiffness(p: Vector) -> float:
    """Return the stiffness k1 in presliding [N/m | N m/rad] (thesis 3.35)."""
    return float(p[BREAKAWAY] / p[LIMIT])


@kernel
def presliding_damping(p: Vector) -> float:
    """Return the damping k2 in presliding [N s/m | N m s/rad] (thesis 3.35)."""
    return 2.0 * math.sqrt(p[MASS] * p[BREAKAWAY] / p[LIMIT])


@kernel
def mode_after(mode: int, v: float, u: float, z: Vector, p: Vector) -> int:
    """Return the next mode (thesis 3.34); slip starts only if v is 0 or has the sign of z."""
    if mode == SLIPPING:
        return STUCK if is_captured(v, u, p) else SLIPPING
    broken = (z[0] >= p[LIMIT] and u > p[BREAKAWAY] and v >= 0.0) or (
        z[0] <= -p[LIMIT] and u < -p[BREAKAWAY] and v <= 0.0
    )
    return SLIPPING if broken else STUCK


@kernel
def enter(mode: int, v: float, u: float, z: Vector, p: Vector) -> int:
    """Set the presliding z to +-z_max for a new mode (thesis 3.33); return a status code.

    At the start of slip, z gets the sign of the effort u. At the start of stick, z gets the sign of
    the velocity v; if v is 0, z does not change.
    """
    if mode == SLIPPING:
        z[0] = math.copysign(p[LIMIT], u)
    elif v != 0.0:
        z[0] = math.copysign(p[LIMIT], v)
    return OK


@kernel
def force(mode: int, v: float, u: float, z: Vector, p: Vector) -> float:
    """Return the friction at velocity v and effort u [N | N m] (thesis 3.32, 3.33)."""
    if mode == STUCK:
        return float(presliding_stiffness(p) * z[0] + presliding_damping(p) * v)
    return sliding_force(v, u, p)


@kernel
def acceleration(mode: int, v: float, u: float, z: Vector, p: Vector) -> float:
    """Return the acceleration v' of the body under effort u [m/s^2 | rad/s^2]."""
    return float((u - force(mode, v, u, z, p)) / p[MASS])


@kernel
def rate(mode: int, v: float, z: Vector, p: Vector, out: Vector) -> int:
    """Write the rate of z [m/s | rad/s] to out[0]; return a status code.

    All other entries of `out` are set to 0.
    """
    out[:] = 0.0
    if mode == STUCK:
        out[0] = v
    return OK if math.isfinite(v) else NOT_FINITE


LAW = Law(
    "hybrid_b",
    "Hybrid B, linear presliding",
    "(3.32)-(3.36)",
    (*HYBRID, PRESLIDING_LIMIT),
    HybridKernels(mode_after, enter, force, acceleration, rate, no_memory, scalar_reset),
)
