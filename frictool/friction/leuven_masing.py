"""The Leuven law (thesis 2.49-2.51) with Masing's hysteresis as its force F_h.

friction/leuven.py has the equations. The state is [z, memory of friction/reversal_memory.py].
"""

from __future__ import annotations

import math

import numpy as np

from frictool.friction.law import DynamicKernels, Law
from frictool.friction.leuven import EXPONENT, LIMIT, SIGMA_1, presliding_rate
from frictool.friction.masing import masing_force, masing_move
from frictool.friction.parameter import DAMPING, POSITIVE_STRIBECK, PRESLIDING_LIMIT
from frictool.friction.reversal_memory import DEPTH, FIRST
from frictool.friction.status_codes import NOT_FINITE, OK
from frictool.friction.stribeck import BREAKAWAY, VISCOUS
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

Z, MEMORY = 0, 1


@kernel
def rate(z: Vector, v: float, p: Vector, out: Vector) -> int:
    """Write the rate of z [m/s | rad/s] to out[0]; return a status code.

    All other entries of `out` are set to 0: the rate of the memory of the turning points, which
    `commit` updates.
    """
    slipped = presliding_rate(masing_force(z[MEMORY:], z[Z], p[BREAKAWAY], p[LIMIT]), v, p)
    if not math.isfinite(slipped):
        return NOT_FINITE
    out[:] = 0.0
    out[Z] = slipped
    return OK


@kernel
def force(z: Vector, zdot: Vector, v: float, p: Vector) -> float:
    """Return the friction [N | N m] (thesis 2.51)."""
    return float(
        masing_force(z[MEMORY:], z[Z], p[BREAKAWAY], p[LIMIT])
        + p[SIGMA_1] * zdot[Z]
        + p[VISCOUS] * v
    )


@kernel
def commit(z: Vector, v: float, p: Vector) -> int:
    """Move the hysteresis to the displacement z after an accepted step; return a status code."""
    if not math.isfinite(z[Z]):
        return NOT_FINITE
    return masing_move(z[MEMORY:], z[Z], p[BREAKAWAY], p[LIMIT])


@kernel
def reset(p: Vector) -> Vector:
    """Return the state (n,) of a contact that has never moved, with memory for DEPTH reversals."""
    return np.zeros(MEMORY + FIRST + 2 * DEPTH)


LAW = Law(
    "leuven_masing",
    "Leuven, Masing hysteresis",
    "(2.49)-(2.51), annex A",
    (*POSITIVE_STRIBECK, PRESLIDING_LIMIT, DAMPING, EXPONENT),
    DynamicKernels(rate, force, commit, reset),
)
