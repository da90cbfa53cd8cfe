"""The Preisach operator in Everett form (thesis 3.18), on a triangle of n x n cells (3.4.3, 3.7.1).

    F = int_S+ mu - int_S- mu          S+: set of relays (alpha, beta), alpha >= beta, that are up;
                                       S-: set of relays that are down; mu: density of the relays
    E(alpha, beta)                     integral of mu over the triangle between beta and alpha;
                                       equals half the change of F from a reversal at beta to alpha
    virgin (demagnetised)              F = sign(z) E(|z|, -|z|)
    after a reversal (z_m, F_m)        F = F_m +- 2 E(max(z, z_m), min(z, z_m)), + if z rises

F is computed from the stored reversals (friction/reversal_memory.py) instead of the relays. The
table ((n+1)^2,) contains E at the nodes -1, -1 + 2/n .. 1, in rows of equal alpha; beta is the
column. Displacements are in units of z_max, forces in units of F_s. E is bilinear between nodes,
and linear in alpha - beta in the cells on the diagonal. The density mu is therefore uniform in each
cell off the diagonal. In the cells on the diagonal, mu is concentrated in relays of zero width,
which give the elastic part of F. Friction loops run clockwise, so that mu is negative off the
diagonal.
"""

from __future__ import annotations

import math

from frictool.friction.reversal_memory import branch_start, remember
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def everett(table: Vector, upper: float, lower: float) -> float:
    """Return the Everett function E(upper, lower), -1 <= lower <= upper <= 1, in units of F_s."""
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
    """Return the force [N | N m] after a monotonic movement to z [m | rad].

    The memory is not changed.
    """
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
    """Move monotonically to the displacement z and update the memory; return a status code.

    Positions in the memory are in units of `limit` = z_max, forces in units of the breakaway.
    """
    position = min(max(z / limit, -1.0), 1.0)
    return remember(memory, position, _unit_force(memory, position, table))
