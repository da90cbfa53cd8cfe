"""Masing's hysteresis with non-local memory (annex A, rules I and II) on the virgin curve of
friction/virgin_curve.py.

    rule I    F = f(z)                              no reversal in memory
    rule II   F = F_m + 2 f((z - z_m)/2)            on the branch that leaves the reversal (z_m,
              F_m)

The memory is that of friction/reversal_memory.py. Inner loops close where they were opened.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.friction.reversal_memory import branch_start, remember
from frictool.friction.virgin_curve import virgin_force
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]


@kernel
def masing_force(memory: Vector, z: float, breakaway: float, limit: float) -> float:
    """Force [N | N m] after a straight movement to z [m | rad]; the memory stays as it is."""
    virgin, start, start_force = branch_start(memory, z)
    if virgin:
        return virgin_force(z, breakaway, limit)
    return start_force + 2.0 * virgin_force(0.5 * (z - start), breakaway, limit)


@kernel
def masing_move(memory: Vector, z: float, breakaway: float, limit: float) -> int:
    """Moves straight to z: the memory takes it in, its second entry is the force. Returns
    friction/status.py."""
    return remember(memory, z, masing_force(memory, z, breakaway, limit))
