"""The limit of the drive: a symmetric bound and, if the drive is a current, the supply voltage.

    |u| <= bound,   |R i + K v| <= V   ->   (-V - K v)/R <= i <= (V - K v)/R

The second condition applies if the drive is the current i of a winding. R is its resistance, V the
supply voltage, K the torque constant (equal to the back-EMF constant in SI units), and v the
measured speed. The lag of the measured speed delays this limit.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode


def bounds(
    program: Program,
    bound: float,
    winding: tuple[float, float, float] | None,
    speed: ProgramNode | None,
) -> tuple[ProgramNode, ProgramNode]:
    """Return the nodes (low, high) of the limits of the drive [A | V].

    - bound: largest |drive| [A | V]
    - winding: (resistance [ohm], torque constant [N m/A], supply voltage [V]), or None if the
      supply voltage does not limit the drive
    - speed: measured speed [rad/s | m/s]; required if `winding` is not None
    """
    high = program.constant(bound, "drive_limit")
    low = program.named("drive_low" if winding is None else "lowest", -high)
    if winding is None or speed is None:
        return low, high
    resistance, constant, voltage = winding
    program.block("limits of the current by the supply voltage and the back-EMF")
    back = program.constant(constant / resistance, "back_emf") * speed
    most = program.constant(voltage / resistance, "stall_current")
    upper = program.smaller(high, program.larger(low, most - back))
    lower = program.larger(low, program.smaller(high, -most - back))
    return program.named("drive_low", lower), program.named("drive_high", upper)


def limit(
    program: Program, drive: ProgramNode, low: ProgramNode, high: ProgramNode
) -> tuple[ProgramNode, ProgramNode]:
    """Return the limited drive and a node that is +1 at the limit `high`, -1 at `low`, else 0."""
    program.block("limit of the drive")
    zero, one = program.constant(0.0), program.constant(1.0)
    above = program.named("above", drive > high)
    below = program.named("below", drive < low)
    limited = program.named("limited_drive", program.smaller(program.larger(drive, low), high))
    met = program.named(
        "met", program.select(above, one, program.select(below, program.constant(-1.0), zero))
    )
    return limited, met
