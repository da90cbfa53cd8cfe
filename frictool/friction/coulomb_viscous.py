"""Coulomb and viscous friction with a breakaway at rest (2.30), (4.17).

    slipping   F = coulomb d + viscous v      d = sign of the motion, fixed by the mode and never by
               sign(v) inside an integrator
    at rest    F = effort                     as long as |effort| <= breakaway

Properties (table 2.1): dissipates, sticks exactly, does not drift, has no presliding and no memory.
"""

from __future__ import annotations

from frictool.runtime.kernels import kernel


@kernel
def slip_force(velocity: float, direction: float, coulomb: float, viscous: float) -> float:
    """Friction force [N m | N] that opposes a motion at `velocity` [rad/s | m/s] in `direction` (+1
    or -1)."""
    return direction * coulomb + viscous * velocity


@kernel
def slip_force_slope(velocity: float, direction: float, coulomb: float, viscous: float) -> float:
    """Derivative of `slip_force` by the velocity: the viscous coefficient."""
    return viscous


@kernel
def breakaway_direction(effort: float, forward: float, backward: float) -> float:
    """+1 or -1 where an effort moves a body at rest, 0 where it sticks. `forward`, `backward`:
    breakaway in each direction, >= 0."""
    if effort > forward:
        return 1.0
    if effort < -backward:
        return -1.0
    return 0.0
