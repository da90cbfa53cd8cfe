"""The Leuven law with a bank of Maxwell-slip elements as its hysteresis force (thesis 2.49-2.51).

    z' = v (1 - sign(a) |a|^i),  a = F_h(z) sign(v)/g(v)        F = F_h(z) + sigma_1 z' + sigma_v v

F_h is the hysteresis force and i an exponent; friction/lugre.py defines the other symbols. In
(2.49), a has no factor sign(v); z would then grow without bound for v < 0. In references [8] and
[9] of the thesis, g has the sign of the velocity, which is equivalent to the equation above. The
state is [z, z at the last accepted step, deflections of the elements at that step]; within a step,
F_h is computed from these deflections.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from frictool.friction import dahl
from frictool.friction.law import DynamicKernels, Law
from frictool.friction.maxwell_bank import bank_force, bank_move, parabolic_bank
from frictool.friction.parameter import DAMPING, POSITIVE_STRIBECK, PRESLIDING_LIMIT
from frictool.friction.status_codes import NOT_FINITE, OK
from frictool.friction.stribeck import BREAKAWAY, VISCOUS, curve
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

DEFAULT_EXPONENT = 10.0
# i of (2.49)
EXPONENT = replace(dahl.EXPONENT, comparison_value=lambda values: values["leuven_exponent"])
LIMIT, SIGMA_1, POWER, FIXED = 5, 6, 7, 8
Z, ACCEPTED, DEFLECTIONS = 0, 1, 2


@kernel
def presliding_rate(hysteresis: float, v: float, p: Vector) -> float:
    """Return the rate z' [m/s | rad/s] of thesis (2.49) for a hysteresis force [N | N m]."""
    a = math.copysign(1.0, v) * hysteresis / curve(v, p)
    return v * (1.0 - math.copysign(abs(a) ** p[POWER], a))


@kernel
def hysteresis_force(z: Vector, p: Vector) -> float:
    """Return the hysteresis force F_h [N | N m] of a state z (2 + N,) with N elements."""
    return bank_force(z[DEFLECTIONS:], z[Z] - z[ACCEPTED], p[FIXED:], p[BREAKAWAY], p[LIMIT])


@kernel
def rate(z: Vector, v: float, p: Vector, out: Vector) -> int:
    """Write the rate of z [m/s | rad/s] to out[0]; return a status code.

    All other entries of `out` are set to 0: the rate of the memory, which `commit` updates.
    """
    slipped = presliding_rate(hysteresis_force(z, p), v, p)
    if not math.isfinite(slipped):
        return NOT_FINITE
    out[:] = 0.0
    out[Z] = slipped
    return OK


@kernel
def force(z: Vector, zdot: Vector, v: float, p: Vector) -> float:
    """Return the friction [N | N m] (thesis 2.51)."""
    return float(hysteresis_force(z, p) + p[SIGMA_1] * zdot[Z] + p[VISCOUS] * v)


@kernel
def commit(z: Vector, v: float, p: Vector) -> int:
    """Move the elements to the displacement z after an accepted step; return a status code."""
    if not math.isfinite(z[Z]):
        return NOT_FINITE
    bank_move(z[DEFLECTIONS:], z[Z] - z[ACCEPTED], p[FIXED:], p[LIMIT])
    z[ACCEPTED] = z[Z]
    return OK


@kernel
def reset(p: Vector) -> Vector:
    """Return the state (2 + N,) of a contact that has never moved."""
    return np.zeros(DEFLECTIONS + (p.shape[0] - FIXED) // 2)


LAW = Law(
    "leuven",
    "Leuven, Maxwell-slip hysteresis",
    "(2.49)-(2.51)",
    (*POSITIVE_STRIBECK, PRESLIDING_LIMIT, DAMPING, EXPONENT),
    DynamicKernels(rate, force, commit, reset),
    tail=lambda values: parabolic_bank(),
)
