"""The limit of the drive: symmetric, and narrower if the back-EMF leaves less current.

    |u| <= bound,   |R i + K v| <= V   ->   (-V - K v)/R <= i <= (V - K v)/R

The second condition applies to a current through a winding. K is the torque constant, equal to the
back-EMF constant in SI units; v is the measured speed, whose lag is also a lag of this limit.
Property: with the anti-windup of the difference equation the loop is linear again as soon as the
drive leaves the limit.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode


def bounds(
    program: Program,
    bound: float,
    winding: tuple[float, float, float] | None,
    speed: ProgramNode | None,
) -> tuple[ProgramNode, ProgramNode]:
    """Return (low, high) of the drive [A | V].

    winding: resistance [ohm], constant [N m/A] and voltage [V]; it needs a speed.
    """
    high = program.constant(bound, "drive_limit")
    low = program.named("drive_low" if winding is None else "lowest", -high)
    if winding is None or speed is None:
        return low, high
    resistance, constant, voltage = winding
    program.block("current that the voltage leaves beside the back-EMF")
    back = program.constant(constant / resistance, "back_emf") * speed
    most = program.constant(voltage / resistance, "stall_current")
    upper = program.smaller(high, program.larger(low, most - back))
    lower = program.larger(low, program.smaller(high, -most - back))
    return program.named("drive_low", lower), program.named("drive_high", upper)


def limit(
    program: Program, drive: ProgramNode, low: ProgramNode, high: ProgramNode
) -> tuple[ProgramNode, ProgramNode]:
    """Return the drive within its bounds, and the bound that it met: -1, 0 (none) or +1."""
    program.block("limit of the drive")
    zero, one = program.constant(0.0), program.constant(1.0)
    above = program.named("above", drive > high)
    below = program.named("below", drive < low)
    limited = program.named("limited_drive", program.smaller(program.larger(drive, low), high))
    met = program.named(
        "met", program.select(above, one, program.select(below, program.constant(-1.0), zero))
    )
    return limited, met
