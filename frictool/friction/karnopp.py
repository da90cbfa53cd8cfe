"""Karnopp's law (thesis 2.35-2.36), in which low velocities do not change the position.

The rest band is the range of velocities |v| <= dv. friction/svc.py defines the friction: static,
viscous and Coulomb. m is the mass, u the effort, F_c the Coulomb friction, and sigma_0 the viscous
coefficient. Inside the band, m v' = u - sticking_force(u): the velocity v is still integrated, but
the rate v_m of the position is 0, so that the body does not drift. Outside the band, m v' = u - F_c
sign(v) - sigma_0 v. Thesis (2.36) has + sigma_0 v, which would drive the body.
"""

from __future__ import annotations

from frictool.friction.law import Law, StaticKernels
from frictool.friction.parameter import BREAKAWAY, COULOMB, VISCOUS
from frictool.friction.static_kernels import breakaway_level
from frictool.friction.svc import slip_force
from frictool.friction.svc_band import BAND, band
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def seen_velocity(v: float, p: Vector) -> float:
    """Return the rate v_m [m/s | rad/s] of the position: 0 inside the rest band, else v."""
    return 0.0 if abs(v) <= p[3] else v


LAW = Law(
    "karnopp",
    "Karnopp",
    "(2.35)-(2.36)",
    (COULOMB, BREAKAWAY, VISCOUS, BAND),
    StaticKernels(slip_force, breakaway_level, band, seen_velocity),
)
