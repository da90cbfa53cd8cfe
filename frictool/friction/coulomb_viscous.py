"""Coulomb and viscous friction with a breakaway at rest (thesis 2.30, 4.17).

    slipping   F = coulomb d + viscous v      d = +-1, direction of the motion
    at rest    F = effort                     as long as |effort| <= breakaway

The simulation fixes d for each phase of slip, so that an integrator never evaluates sign(v). The
law dissipates, sticks exactly and does not drift; it has no presliding and no memory (table 2.1).
"""

from __future__ import annotations

from frictool.runtime.kernels import kernel


@kernel
def slip_force(velocity: float, direction: float, coulomb: float, viscous: float) -> float:
    """Return the friction [N m | N] against a motion in `direction` (+1 or -1).

    `velocity` is in rad/s | m/s.
    """
    return direction * coulomb + viscous * velocity


@kernel
def breakaway_direction(effort: float, forward: float, backward: float) -> float:
    """Return the direction, +1 or -1, in which an effort moves a body at rest; 0 if it sticks.

    `forward`, `backward`: breakaway in each direction, >= 0 [N | N m], the unit of `effort`.
    """
    if effort > forward:
        return 1.0
    if effort < -backward:
        return -1.0
    return 0.0
