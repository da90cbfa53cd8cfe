"""What static laws share: the rest, the band of velocities that count as rest, the breakaway.

at rest   F = u   within [-F_s(-), F_s(+)], the nearer end outside          (2.30)-(2.35), first
          lines
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]


@kernel
def sticking_force(effort: float, forward: float, backward: float) -> float:
    """Friction [N | N m] on a body at rest under `effort`: sign(u) min(|u|, F_s), the breakaway of
    each direction >= 0."""
    return min(max(effort, -backward), forward)


@kernel
def coulomb_breakaway(direction: float, p: Vector) -> float:
    """Breakaway of a law in which F_s = F_c."""
    return float(p[0])


@kernel
def breakaway_level(direction: float, p: Vector) -> float:
    """Breakaway F_s, the second parameter of the laws that have one."""
    return float(p[1])


@kernel
def never_sticks(direction: float, p: Vector) -> float:
    """Breakaway of a regularised law: 0, any effort moves the body."""
    return 0.0


@kernel
def no_band(p: Vector) -> float:
    """Half width of the velocities that count as rest in an exact law."""
    return 0.0


@kernel
def true_velocity(v: float, p: Vector) -> float:
    """Velocity that a law reports where it has none of its own."""
    return v
