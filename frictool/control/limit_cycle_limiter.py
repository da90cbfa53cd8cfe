"""Limit-cycle limiter of a position loop (5.7): the drive is released where friction alone, real
and virtual, ends at the target.

    energy   | |e| - J v^2/(2 F') | < delta_e,  F' = F_c + F_cv (5.40)      error   |e| < delta_e,
             the cut-off that 5.2.1 argues against

Where released the effort is -F_cv tanh(v/v_r) (5.41), read with its branches the right way round:
printed, the brake acts outside the band and the axis never leaves its rest. The integrator is
frozen meanwhile (5.2.2), the rest of the controller goes on watching the error.

Known of it (proposition 5.2.1, with its reservation): the axis ends at rest where F' is the
friction that acts, and nothing drives there; the derivative (5.12) has no sign, so that boundedness
and rest is what holds and not a Lyapunov decrease. Rule: delta_e at least the encoder's step, and
above |e| dF'/F' of the moves that occur; v_r some encoder steps per filter time, 0.01 m/s on the
mass of table 5.1.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode
from frictool.control.saturation_function import saturating


def energy_released(
    program: Program,
    error: ProgramNode,
    speed: ProgramNode,
    band: float,
    inertia: float,
    friction: float,
) -> ProgramNode:
    """(5.7), whether friction alone [N m | N] ends within `band` [rad | m] of the target."""
    program.block("limit-cycle limiter (5.7): friction alone ends at the target")
    path = program.named(
        "path",
        program.constant(0.5 * inertia / friction, "path_per_speed_squared") * (speed * speed),
    )
    return program.named(
        "released", abs(abs(error) - path) < program.constant(band, "release_band")
    )


def error_released(program: Program, error: ProgramNode, band: float) -> ProgramNode:
    """|e| < band alone."""
    program.block("cut-off: the position error alone")
    return program.named("released", abs(error) < program.constant(band, "release_band"))


def virtual_friction(
    program: Program, speed: ProgramNode, drive_per_virtual: float, virtual_speed: float
) -> ProgramNode:
    """(5.41): the drive [A | V] that opposes the measured speed."""
    program.block("virtual friction (5.41)")
    ratio = program.constant(1.0 / virtual_speed, "per_virtual_speed") * speed
    return program.named(
        "braking",
        -(program.constant(drive_per_virtual, "virtual_drive") * saturating(program, ratio)),
    )
