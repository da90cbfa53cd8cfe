"""Stiffness of the LuGre law from slow effort loops below the breakaway.

    F -> s F_s + (F - s F_s) e^(-stiffness |dx|/F_s)          s = sign(dx)

F is the friction force, and F_s the breakaway. The arrow replaces F by the friction after a
displacement dx between two counts. The new value is the solution of thesis (2.40) at zero speed,
dF/dx = stiffness (1 - sign(dx) F/F_s).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.identify.presliding.loops import PreslidingLoops
from frictool.identify.presliding.path_fit import PreslidingFit, fit_path
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def lugre_path(
    position: Vector, starts: NDArray[np.bool_], stiffness: float, breakaway: float, out: Vector
) -> None:
    """Compute the friction of the LuGre law along a path.

    - position: positions of the path, (n,), rad | m
    - starts: True for the first row of a record, at which friction is 0, (n,)
    - stiffness, breakaway: stiffness [N m/rad | N/m] and breakaway [N m | N] of the law
    - out: result, friction at each position, (n,), N m | N
    """
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
    """Return the fit of the stiffness sigma_0 [N m/rad | N/m] of the LuGre law.

    Raises UnusableLogs if the loops do not determine the stiffness.
    """
    return fit_path(loops, _path, np.array([loops.breakaway.value / loops.reach]), confidence)
