"""Masing's hysteresis with non-local memory (annex A of the thesis), from a virgin curve.

    rule I    F = f(z)                              no reversal in memory
    rule II   F = F_m + 2 f((z - z_m)/2)            after the reversal (z_m, F_m)

f is the virgin curve (friction/virgin_curve.py), z the position, and F the force.
friction/reversal_memory.py defines the memory. An inner hysteresis loop closes at its starting
point.
"""

from __future__ import annotations

from frictool.friction.reversal_memory import branch_start, remember
from frictool.friction.virgin_curve import virgin_force
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def masing_force(memory: Vector, z: float, breakaway: float, limit: float) -> float:
    """Return the force [N | N m] after a monotonic movement to z [m | rad].

    The memory of reversals is not changed.

    - breakaway: breakaway force [N | N m]
    - limit: largest deflection [m | rad]
    """
    virgin, start, start_force = branch_start(memory, z)
    if virgin:
        return virgin_force(z, breakaway, limit)
    return start_force + 2.0 * virgin_force(0.5 * (z - start), breakaway, limit)


@kernel
def masing_move(memory: Vector, z: float, breakaway: float, limit: float) -> int:
    """Move monotonically to z and update the memory of reversals; return a status code.

    Afterwards memory[1] is the force.
    """
    return remember(memory, z, masing_force(memory, z, breakaway, limit))
