"""The Preisach operator in Everett form (3.18), on a triangle of n x n cells (3.4.3, 3.7.1).

    F = int_S+ mu - int_S- mu          S+, S-: relays (alpha, beta), alpha >= beta, that are up,
                                       down
    E(alpha, beta) = int of mu over the triangle between beta and alpha: half the change of F from a
    reversal at beta to alpha

    virgin (demagnetised)     F = sign(z) E(|z|, -|z|)
    after a reversal (z_m)    F = F_m +- 2 E(max(z, z_m), min(z, z_m))

The integral needs the reversals that are not wiped out (friction/reversal_memory.py) and not the
relays. table: E at the nodes -1, -1 + 2/n .. 1, shape ((n+1)^2,), row alpha, column beta;
displacement in units of z_max, force in units of F_s. Between nodes E is bilinear, and linear in
alpha - beta in the cells on the diagonal: a density mu uniform in each cell off the diagonal, and
on the diagonal relays of no width, the elastic part. Friction loops run clockwise: off the diagonal
mu is negative.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.friction.reversal_memory import branch_start, remember
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]


@kernel
def everett(table: Vector, upper: float, lower: float) -> float:
    """E(upper, lower) for -1 <= lower <= upper <= 1, in units of F_s."""
    nodes = round(math.sqrt(table.shape[0]))
    cells = nodes - 1
    a, b = 0.5 * cells * (upper + 1.0), 0.5 * cells * (lower + 1.0)
    i, j = min(int(a), cells - 1), min(int(b), cells - 1)
    s, t = a - i, b - j
    if i == j:
        return float(table[(i + 1) * nodes + i] * (s - t))
    below = table[i * nodes + j] * (1.0 - t) + table[i * nodes + j + 1] * t
    above = table[(i + 1) * nodes + j] * (1.0 - t) + table[(i + 1) * nodes + j + 1] * t
    return float(below * (1.0 - s) + above * s)


@kernel
def preisach_force(
    memory: Vector, z: float, table: Vector, breakaway: float, limit: float
) -> float:
    """Force [N | N m] after a straight movement to z [m | rad]; the memory stays as it is."""
    return breakaway * _unit_force(memory, min(max(z / limit, -1.0), 1.0), table)


@kernel
def _unit_force(memory: Vector, z: float, table: Vector) -> float:
    if not math.isfinite(z):
        return math.nan
    virgin, start, start_force = branch_start(memory, z)
    if virgin:
        return math.copysign(everett(table, abs(z), -abs(z)), z)
    if z >= start:
        return start_force + 2.0 * everett(table, z, start)
    return start_force - 2.0 * everett(table, start, z)


@kernel
def preisach_move(memory: Vector, z: float, table: Vector, limit: float) -> int:
    """Moves straight to z: the memory, in units of z_max and F_s, takes it in. Returns
    friction/status.py."""
    place = min(max(z / limit, -1.0), 1.0)
    return remember(memory, place, _unit_force(memory, place, table))
