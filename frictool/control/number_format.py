"""A program in the number format of the target, as the simulation runs it."""

from __future__ import annotations

from typing import Literal

from frictool.control.compiled_program import CompiledProgram, compile_program
from frictool.control.fixed_point import BITS, fixed_machine, fixed_program
from frictool.control.program import Program


def machine_in(
    program: Program, number: Literal["double", "float", "q31", "q15"]
) -> CompiledProgram:
    """The program at its start with the position 0. Raises DoesNotFit, naming the value, where
    fixed point cannot be scaled."""
    if number in BITS:
        return fixed_machine(fixed_program(program, BITS[number]))
    return compile_program(program, single=number == "float")
