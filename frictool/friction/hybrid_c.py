"""Hybrid law, version C: presliding by the Preisach operator (thesis 3.37-3.39).

    mode 0   z' = v, m v' = u - Preisach(z) - k2 v
    mode 1 and the switching conditions C_{0->1}, C_{1->0}: as in version B

friction/hybrid_b.py defines the symbols; Preisach(z) is the force of the operator
(friction/preisach.py). The state is [z, memory of friction/reversal_memory.py]. Equation (3.37) of
the thesis has no damping term. Without damping the stuck body would oscillate, because small
hysteresis loops dissipate little energy. The code therefore adds the term k2 v of version B (3.35).
Slip saturates the operator and deletes all reversals from its memory.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.friction import hybrid_b
from frictool.friction.hybrid_b import LIMIT, mode_after, presliding_damping, rate
from frictool.friction.hybrid_kernels import HYBRID, MASS, STUCK, sliding_force
from frictool.friction.law import HybridKernels, Law
from frictool.friction.parameter import PRESLIDING_LIMIT
from frictool.friction.preisach import preisach_force, preisach_move
from frictool.friction.preisach_cycles import cell_count, masing_table
from frictool.friction.reversal_memory import COUNT, DEPTH, FIRST, FORCE, POSITION
from frictool.friction.status_codes import OK
from frictool.friction.stribeck import BREAKAWAY
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

MEMORY, FIXED = 1, 8


@kernel
def enter(mode: int, v: float, u: float, z: Vector, p: Vector) -> int:
    """Set z as hybrid version B does, and delete all reversals; return a status code."""
    status = hybrid_b.enter(mode, v, u, z, p)
    z[MEMORY + COUNT] = 0.0
    z[MEMORY + POSITION] = z[MEMORY + FORCE] = math.copysign(1.0, z[0])
    return status


@kernel
def force(mode: int, v: float, u: float, z: Vector, p: Vector) -> float:
    """Return the friction [N | N m] (thesis 3.37, 3.38)."""
    if mode == STUCK:
        return (
            preisach_force(z[MEMORY:], z[0], p[FIXED:], p[BREAKAWAY], p[LIMIT])
            + presliding_damping(p) * v
        )
    return sliding_force(v, u, p)


@kernel
def acceleration(mode: int, v: float, u: float, z: Vector, p: Vector) -> float:
    """Return the body's acceleration v' [m/s^2 | rad/s^2]."""
    return float((u - force(mode, v, u, z, p)) / p[MASS])


@kernel
def commit(mode: int, z: Vector, p: Vector) -> int:
    """Move the operator to the displacement z after an accepted step; return a status code."""
    return preisach_move(z[MEMORY:], z[0], p[FIXED:], p[LIMIT]) if mode == STUCK else OK


@kernel
def reset(p: Vector) -> Vector:
    """Return the state (n,) of a contact that has never moved, with memory for DEPTH reversals."""
    return np.zeros(MEMORY + FIRST + 2 * DEPTH)


LAW = Law(
    "hybrid_c",
    "Hybrid C, presliding by Preisach",
    "(3.37)-(3.39)",
    (*HYBRID, PRESLIDING_LIMIT),
    HybridKernels(mode_after, enter, force, acceleration, rate, commit, reset),
    tail=masing_table,
    tail_parameters=cell_count,
)
