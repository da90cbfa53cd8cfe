"""Compilation of a program in the number format of the target hardware."""

from __future__ import annotations

from frictool.control.compiled_program import CompiledProgram, compile_program
from frictool.control.fixed_point import fixed_machine, fixed_program
from frictool.control.program import Program


def machine_in(program: Program, number: str) -> CompiledProgram:
    """Return a program compiled for simulation in double, float or q31.

    The program is started for an axis at rest at position 0. Raises FixedPointOverflow with the
    name of the value if a value cannot be scaled.
    """
    if number == "q31":
        return fixed_machine(fixed_program(program))
    return compile_program(program, single=number == "float")
