"""Limit-cycle limiter of a position loop (thesis 5.7), which releases the drive near the target.

    energy   | |e| - J v^2/(2 F') | < delta_e,  F' = F_c + F_cv (5.40)
    error    |e| < delta_e                          (not recommended by section 5.2.1 of the thesis)

The design selects one of the two conditions, `energy` or `error`. The drive is released while this
condition is true. e is the position error, v the speed, J the inertia, and delta_e the half-width
of a band of positions around the target. F_c is the real friction; the virtual friction F_cv is an
effort of the drive that brakes the axis. With `energy` the drive is released if real and virtual
friction together would stop the axis within delta_e of the target. The effort of the released drive
is -F_cv tanh(v/v_r) (5.41), with the speed scale v_r. The thesis prints the two cases of (5.41) in
the wrong order: as printed, the brake would act outside the band, and the axis would never start.
While the drive is released, the integrator keeps its value; the other states of the controller are
updated as usual.

Property (proposition 5.2.1): if F' equals the true friction, the axis ends at rest with a drive of
0. Boundedness and rest are proved, but not stability, because the derivative (5.12) of the Lyapunov
function has no definite sign. delta_e should be at least one encoder step, and above |e| dF'/F' for
the largest error dF' of the friction. v_r should be a few encoder steps per time constant of the
speed filter, for example 0.01 m/s for the mass of table 5.1.
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
    """Return the condition | |e| - J v^2/(2 F') | < band that releases the drive (thesis 5.7).

    - error: position error e [rad | m]
    - speed: speed v [rad/s | m/s]
    - band: half-width of the band of positions around the target [rad | m]
    - inertia: inertia J [kg m2 | kg]
    - friction: sum F' of real and virtual friction [N m | N]
    """
    program.block("limit-cycle limiter (5.7): friction alone stops the axis in the band")
    path = program.named(
        "path",
        program.constant(0.5 * inertia / friction, "path_per_speed_squared") * (speed * speed),
    )
    return program.named(
        "released", abs(abs(error) - path) < program.constant(band, "release_band")
    )


def error_released(program: Program, error: ProgramNode, band: float) -> ProgramNode:
    """Return the condition |error| < band [rad | m], under which the drive is released."""
    program.block("limit-cycle limiter: the position error is in the band")
    return program.named("released", abs(error) < program.constant(band, "release_band"))


def virtual_friction(
    program: Program, speed: ProgramNode, drive_per_virtual: float, virtual_speed: float
) -> ProgramNode:
    """Return the drive [A | V] of the virtual friction, which opposes the measured speed.

    - drive_per_virtual: drive that produces the full virtual friction F_cv [A | V]
    - virtual_speed: speed scale v_r [rad/s | m/s]
    """
    program.block("virtual friction (5.41)")
    ratio = program.constant(1.0 / virtual_speed, "per_virtual_speed") * speed
    return program.named(
        "braking",
        -(program.constant(drive_per_virtual, "virtual_drive") * saturating(program, ratio)),
    )
