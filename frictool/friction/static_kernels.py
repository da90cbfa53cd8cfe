"""Kernels that static friction laws share: force at rest, breakaway, and width of the rest band.

F_s(+) and F_s(-) are the breakaways in positive and negative direction. At rest, F equals the
effort u, limited to [-F_s(-), F_s(+)] (first lines of thesis 2.30 to 2.35). The rest band is the
range of low velocities that a law treats as rest.
"""

from __future__ import annotations

from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def sticking_force(effort: float, forward: float, backward: float) -> float:
    """Return the friction [N | N m] on a body at rest: `effort`, limited to the breakaway.

    `forward` and `backward` are the breakaway in each direction, >= 0.
    """
    return min(max(effort, -backward), forward)


@kernel
def coulomb_breakaway(direction: float, p: Vector) -> float:
    """Return the Coulomb friction p[0], the breakaway of a law without a separate breakaway."""
    return float(p[0])


@kernel
def breakaway_level(direction: float, p: Vector) -> float:
    """Return the breakaway F_s, stored in p[1]."""
    return float(p[1])


@kernel
def never_sticks(direction: float, p: Vector) -> float:
    """Return 0, the breakaway of a regularised law: any effort moves the body."""
    return 0.0


@kernel
def no_band(p: Vector) -> float:
    """Return 0, the half width of the rest band (in velocity), for a law without a rest band."""
    return 0.0


@kernel
def true_velocity(v: float, p: Vector) -> float:
    """Return v, the rate of the position in every law except Karnopp's."""
    return v
