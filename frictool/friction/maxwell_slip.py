"""The generalised Maxwell-slip law (reference [29] of the thesis, section 2.4.3.1).

Parallel elements stick or slip independently:

    sticking   F_i' = k_i v                                       until |F_i| reaches w_i g(v)
    slipping   F_i' = C (w_i sign(v) - F_i/g(v))                  until the velocity changes sign
    F = sum F_i + sigma_v v

F_i is the force of element i, k_i its stiffness, w_i its share of the friction, v the velocity, and
sigma_v the viscous coefficient. C [N/s | N m/s] is the rate at which slipping friction follows
Stribeck's curve g: frictional memory with the time constant g/C. The state is [F_1 .. F_N, mode_1
.. mode_N] with mode 0 for sticking and +-1 for slipping in that direction. `commit` updates the
modes after a step; within the step, an element slips as soon as |F_i| reaches w_i g(v).
friction/maxwell_bank.py defines the elements: k_i = w_i F_s/(d_i z_max).
"""

from __future__ import annotations

import math

import numpy as np

from frictool.friction.law import DynamicKernels, Law
from frictool.friction.maxwell_bank import parabolic_bank
from frictool.friction.parameter import POSITIVE_STRIBECK, PRESLIDING_LIMIT, LawParameter
from frictool.friction.status_codes import NOT_FINITE, OK
from frictool.friction.stribeck import BREAKAWAY, VISCOUS, curve
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

# C; in comparisons g/C is the time constant of LuGre at v_s, g/(stiffness v_s)
ATTRACTION = LawParameter(
    "attraction",
    "N/s",
    exclusive=True,
    comparison_value=lambda values: values["stiffness"] * values["stribeck_velocity"],
)
LIMIT, PULL, FIXED = 5, 6, 7


@kernel
def _loaded(force: float, v: float, limit: float) -> bool:
    return v != 0.0 and math.copysign(force, force * v) >= limit


@kernel
def rate(z: Vector, v: float, p: Vector, out: Vector) -> int:
    """Write the rates of the N forces [N/s | N m/s], then N zeros for the modes, to out (2 N,).

    Returns a status code.
    """
    count = z.shape[0] // 2
    level = curve(v, p)
    towards = math.copysign(1.0, v)
    total = 0.0
    for i in range(count):
        weight = p[FIXED + count + i]
        if z[count + i] * v > 0.0 or _loaded(z[i], v, weight * level):
            out[i] = p[PULL] * (weight * towards - z[i] / level)
        else:
            out[i] = weight * p[BREAKAWAY] / (p[FIXED + i] * p[LIMIT]) * v
        out[count + i] = 0.0
        total += out[i]
    return OK if math.isfinite(total) else NOT_FINITE


@kernel
def force(z: Vector, zdot: Vector, v: float, p: Vector) -> float:
    """Return the friction [N | N m]."""
    total = p[VISCOUS] * v
    for i in range(z.shape[0] // 2):
        total += z[i]
    return float(total)


@kernel
def commit(z: Vector, v: float, p: Vector) -> int:
    """Update which elements stick and which slip; return a status code."""
    if not math.isfinite(v):
        return NOT_FINITE
    count = z.shape[0] // 2
    level = curve(v, p)
    towards = math.copysign(1.0, v)
    for i in range(count):
        if z[count + i] * v <= 0.0:
            z[count + i] = towards if _loaded(z[i], v, p[FIXED + count + i] * level) else 0.0
    return OK


@kernel
def reset(p: Vector) -> Vector:
    """Return the state (2 N,) of a contact that has never moved: no force, all elements stick."""
    return np.zeros(p.shape[0] - FIXED)


LAW = Law(
    "maxwell_slip",
    "Generalised Maxwell-slip",
    "2.4.3.1, [29]",
    (*POSITIVE_STRIBECK, PRESLIDING_LIMIT, ATTRACTION),
    DynamicKernels(rate, force, commit, reset),
    tail=lambda values: parabolic_bank(),
)
