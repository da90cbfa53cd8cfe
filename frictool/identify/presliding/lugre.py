"""LuGre's stiffness from slow loops: without speed (2.40) is dF/dx = stiffness (1 - sign(dx)
F/F_s), in closed form from count to count.

F -> s F_s + (F - s F_s) e^(-stiffness |dx|/F_s)          s = sign(dx)
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.identify.motion_record import Vector
from frictool.identify.presliding.loops import PreslidingLoops
from frictool.identify.presliding.path_fit import PreslidingFit, fit_path
from frictool.runtime.kernels import kernel


@kernel
def lugre_path(
    position: Vector, starts: NDArray[np.bool_], stiffness: float, breakaway: float, out: Vector
) -> None:
    """Fills out (n,) with the force along `position` (n,), 0 where a path `starts` (n,)."""
    for k in range(position.shape[0]):
        if starts[k]:
            out[k] = 0.0
            continue
        moved = position[k] - position[k - 1]
        end = math.copysign(breakaway, moved)
        out[k] = end + (out[k - 1] - end) * math.exp(-stiffness * abs(moved) / breakaway)


def _path(loops: PreslidingLoops, value: Vector) -> Vector:
    out = np.empty(loops.position.size)
    lugre_path(loops.position, loops.starts, float(value[0]), loops.breakaway.value, out)
    return out


def lugre(loops: PreslidingLoops, confidence: float) -> PreslidingFit:
    """sigma_0, N m/rad | N/m. Raises NothingUsable where the loops do not tell it."""
    return fit_path(loops, _path, np.array([loops.breakaway.value / loops.reach]), confidence)
