"""Kernels that the hybrid laws share (thesis 3.2-3.5): slip of mode 1 and capture C_{1->0}.

====  ========  ==========================================================================
mode  name      motion
====  ========  ==========================================================================
0     STUCK     version A: v' = -p0 v; versions B, C: spring or hysteresis in presliding
1     SLIPPING  m v' = u - g(v) sign(v) - sigma_v v (Stribeck's law)
====  ========  ==========================================================================

v is the velocity, u the effort, m the mass, F_c the Coulomb friction, F_s the breakaway, g the
curve of friction/stribeck.py, and sigma_v the viscous coefficient. friction/hybrid_time_step.py
defines p0, Sigma and v_s.

C_{1->0} is (u < F_c and 0 < v < Sigma) or (u > -F_c and -Sigma < v < 0), (3.2), valid for Sigma > 3
v_s. At v = 0 the body slips in the direction of the effort. If F_c or F_s differ by direction, p
contains the values for one direction: in slip the direction of the velocity, at rest the direction
of the effort.
"""

from __future__ import annotations

import math

from frictool.friction.parameter import STRIBECK, LawParameter
from frictool.friction.status_codes import OK
from frictool.friction.stribeck import COULOMB, slip_force
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

STUCK, SLIPPING = 0, 1

INERTIA = LawParameter("inertia", "kg", exclusive=True, simulation_only=True)  # m
CAPTURE_VELOCITY = LawParameter(  # Sigma
    "capture_velocity", "m/s", exclusive=True, simulation_only=True
)
CONVERGENCE_RATE = LawParameter(  # p0 of version A
    "convergence_rate", "1/s", exclusive=True, simulation_only=True
)
HYBRID = (*STRIBECK, INERTIA, CAPTURE_VELOCITY)
MASS, SIGMA = 5, 6  # indices in p


@kernel
def sliding_force(v: float, u: float, p: Vector) -> float:
    """Return the friction in mode 1 [N | N m] (thesis 3.4)."""
    direction = math.copysign(1.0, v) if v != 0.0 else math.copysign(1.0, u)
    return slip_force(v, direction, p)


@kernel
def no_memory(mode: int, z: Vector, p: Vector) -> int:
    """Return the status OK: `commit` of a law without memory has nothing to store."""
    return OK


@kernel
def is_captured(v: float, u: float, p: Vector) -> bool:
    """Return True if the capture condition C_{1->0} holds (thesis 3.2)."""
    return bool(
        (0.0 < v < p[SIGMA] and u < p[COULOMB]) or (-p[SIGMA] < v < 0.0 and u > -p[COULOMB])
    )
