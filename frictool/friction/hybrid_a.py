"""Hybrid law, version A: no presliding (thesis 3.28-3.31).

    mode 0   v' = -p0 v, F = u           C_{0->1}: |u| > F_s and (sign u = sign v or t_0 >= T_0)
    mode 1   Stribeck's law              C_{1->0}: (3.2)

v is the velocity, u the effort, F the friction, m the mass, F_s the breakaway, and p0 the decay
rate of the remaining velocity after the switch to stick. C_{i->j} is the condition for the switch
from mode i to mode j.

The state is z = [t_0]. t_0 is the time at rest, limited to T_0 (3.28). The condition t_0 > T_0 of
(3.30) would therefore never be met; the code uses t_0 >= T_0. T_0 = 0 gives the simplified C_{0->1}
of section 3.6. The law is dissipative (3.42) with the storage function m v^2/2 and the supply rate
(u - F_sec) v, where F_sec is the dry friction.
"""

from __future__ import annotations

import math

from frictool.friction.dynamic_kernels import scalar_reset
from frictool.friction.hybrid_kernels import (
    CONVERGENCE_RATE,
    HYBRID,
    MASS,
    SLIPPING,
    STUCK,
    is_captured,
    no_memory,
    sliding_force,
)
from frictool.friction.law import HybridKernels, Law
from frictool.friction.parameter import LawParameter
from frictool.friction.status_codes import NOT_FINITE, OK
from frictool.friction.stribeck import BREAKAWAY
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

HOLD_TIME = LawParameter(  # T_0
    "hold_time", "s", default=0.0, simulation_only=True, comparison_value=lambda _: 0.0
)
RATE, HOLD = 7, 8


@kernel
def mode_after(mode: int, v: float, u: float, z: Vector, p: Vector) -> int:
    """Return the next mode (thesis 3.30)."""
    if mode == SLIPPING:
        return STUCK if is_captured(v, u, p) else SLIPPING
    return SLIPPING if abs(u) > p[BREAKAWAY] and (u * v > 0.0 or z[0] >= p[HOLD]) else STUCK


@kernel
def enter(mode: int, v: float, u: float, z: Vector, p: Vector) -> int:
    """Set the time at rest t_0 to 0 s; return a status code."""
    z[0] = 0.0
    return OK


@kernel
def force(mode: int, v: float, u: float, z: Vector, p: Vector) -> float:
    """Return the friction [N | N m]; in mode 0 it equals the effort (thesis 3.28)."""
    return u if mode == STUCK else sliding_force(v, u, p)


@kernel
def acceleration(mode: int, v: float, u: float, z: Vector, p: Vector) -> float:
    """Return the body's acceleration v' [m/s^2 | rad/s^2] (thesis 3.28, 3.29)."""
    return float(-p[RATE] * v if mode == STUCK else (u - sliding_force(v, u, p)) / p[MASS])


@kernel
def rate(mode: int, v: float, z: Vector, p: Vector, out: Vector) -> int:
    """Write the rate t_0' of the time at rest to out (1,); return a status code."""
    out[0] = 1.0 if mode == STUCK and z[0] < p[HOLD] else 0.0
    return OK if math.isfinite(v) else NOT_FINITE


LAW = Law(
    "hybrid_a",
    "Hybrid A, no presliding",
    "(3.28)-(3.31)",
    (*HYBRID, CONVERGENCE_RATE, HOLD_TIME),
    HybridKernels(mode_after, enter, force, acceleration, rate, no_memory, scalar_reset),
)
