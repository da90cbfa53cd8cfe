"""Hybrid version A, without presliding (3.28)-(3.31). State z = [t_0], the time spent stuck,
counted up to T_0.

    mode 0   v' = -p0 v, F = u           C_{0->1}: |u| > F_s and (sign u = sign v or t_0 >= T_0)
    mode 1   Stribeck's law              C_{1->0}: (3.2)

(3.30) prints t_0 > T_0 where (3.28) stops t_0 at T_0, which would never leave: >= is meant. T_0 = 0
is the simplified C_{0->1} of 3.6. Dissipates (3.42) with the storage m v^2/2 and the supply (u -
F_sec) v.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.friction.hybrid_kernels import (
    HYBRID,
    MASS,
    SLIPPING,
    STUCK,
    is_captured,
    sliding_force,
)
from frictool.friction.law import HybridKernels, Law
from frictool.friction.parameter import LawParameter
from frictool.friction.status import NOT_FINITE, OK
from frictool.friction.stribeck import BREAKAWAY
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]
CONVERGENCE_RATE = LawParameter("convergence_rate", "1/s", "1/s", exclusive=True)  # p0
HOLD_TIME = LawParameter("hold_time", "s", "s", default=0.0)  # T_0
RATE, HOLD = 7, 8


@kernel
def mode_after(mode: int, v: float, u: float, z: Vector, p: Vector) -> int:
    """The mode that follows, (3.30)."""
    if mode == SLIPPING:
        return STUCK if is_captured(v, u, p) else SLIPPING
    return SLIPPING if abs(u) > p[BREAKAWAY] and (u * v > 0.0 or z[0] >= p[HOLD]) else STUCK


@kernel
def enter(mode: int, v: float, u: float, z: Vector, p: Vector) -> int:
    """Starts the clock of the mode just entered. Returns friction/status.py."""
    z[0] = 0.0
    return OK


@kernel
def force(mode: int, v: float, u: float, z: Vector, p: Vector) -> float:
    """Friction [N | N m]: the effort itself in mode 0, (3.28)."""
    return u if mode == STUCK else sliding_force(v, u, p)


@kernel
def acceleration(mode: int, v: float, u: float, z: Vector, p: Vector) -> float:
    """v' [m/s^2 | rad/s^2], (3.28), (3.29)."""
    return float(-p[RATE] * v if mode == STUCK else (u - sliding_force(v, u, p)) / p[MASS])


@kernel
def rate(mode: int, v: float, z: Vector, p: Vector, out: Vector) -> int:
    """Fills out (1,) with t_0'. Returns friction/status.py."""
    out[0] = 1.0 if mode == STUCK and z[0] < p[HOLD] else 0.0
    return OK if math.isfinite(v) else NOT_FINITE


@kernel
def commit(mode: int, z: Vector, p: Vector) -> int:
    """There is no memory. Returns friction/status.py."""
    return OK


@kernel
def reset(p: Vector) -> Vector:
    """State (1,) of a body just stuck."""
    return np.zeros(1)


LAW = Law(
    "hybrid_a",
    "Hybrid A, no presliding",
    "(3.28)-(3.31)",
    (*HYBRID, CONVERGENCE_RATE, HOLD_TIME),
    HybridKernels(mode_after, enter, force, acceleration, rate, commit, reset),
)
