"""A program in the number format of the target, as the simulation runs it."""

from __future__ import annotations

from typing import Literal

from frictool.control.compiled_program import CompiledProgram, compile_program
from frictool.control.fixed_point import BITS, fixed_machine, fixed_program
from frictool.control.program import Program


def machine_in(
    program: Program, number: Literal["double", "float", "q31", "q15"]
) -> CompiledProgram:
    """Return the program in a number format, at rest at the position 0.

    Raises FixedPointOverflow with the value's name if fixed point cannot be scaled.
    """
    if number in BITS:
        return fixed_machine(fixed_program(program, BITS[number]))
    return compile_program(program, single=number == "float")
