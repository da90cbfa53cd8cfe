"""Kernels that static laws share: force at rest, breakaway, and velocity band of rest.

At rest F is the effort u limited to [-F_s(-), F_s(+)], the breakaway of each direction, as in the
first lines of thesis (2.30)-(2.35).
"""

from __future__ import annotations

from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def sticking_force(effort: float, forward: float, backward: float) -> float:
    """Return the friction [N | N m] on a body at rest under `effort`, limited to the breakaway.

    `forward` and `backward` are the breakaway in each direction, >= 0.
    """
    return min(max(effort, -backward), forward)


@kernel
def coulomb_breakaway(direction: float, p: Vector) -> float:
    """Return the breakaway of a law without a separate one: its Coulomb friction p[0]."""
    return float(p[0])


@kernel
def breakaway_level(direction: float, p: Vector) -> float:
    """Return the breakaway F_s, which is p[1]."""
    return float(p[1])


@kernel
def never_sticks(direction: float, p: Vector) -> float:
    """Return 0, the breakaway of a regularised law: any effort moves the body."""
    return 0.0


@kernel
def no_band(p: Vector) -> float:
    """Return 0, the half width of the velocity band of rest in an exact law."""
    return 0.0


@kernel
def true_velocity(v: float, p: Vector) -> float:
    """Return v, because an exact law does not modify the velocity."""
    return v
