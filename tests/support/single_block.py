"""A program around a single block, run in double sample by sample: inputs and states by name, every
named value to be seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from frictool.control.compiled_program import compile_program, run_values
from frictool.control.program import Program, ProgramNode
from frictool.typing import Vector

WIDE = 1e9


class Block:
    """`build` writes the block into the program and returns what it makes."""

    def __init__(self, build: Callable[[Program], ProgramNode]) -> None:
        self.program = Program()
        self.program.output = build(self.program)
        self.machine = compile_program(self.program)

    def place(self, name: str) -> int:
        """Return the index of an input, a state or a named value."""
        given = self.program.inputs.get(name) or self.program.states.get(name)
        if given is not None:
            return given.index
        return next(place for place, called in self.program.names.items() if called == name)

    def set(self, **values: float) -> Block:
        """Inputs and states."""
        for name, value in values.items():
            self.machine.real[self.place(name)] = value
        return self

    def step(self, **inputs: float) -> float:
        """One sample; what the block makes."""
        self.set(**inputs)
        run_values(self.machine.code, self.machine.terms, self.machine.writes, self.machine.real)
        return float(self.machine.real[self.machine.ports[3]])

    def run(self, **inputs: Sequence[float]) -> Vector:
        """As many samples as the inputs have."""
        rows = zip(*inputs.values(), strict=True)
        return np.array([self.step(**dict(zip(inputs, row, strict=True))) for row in rows])

    def value(self, name: str) -> float:
        """Return an input, a state or a named value after the last sample; for a state, its next
        value."""
        return float(self.machine.real[self.place(name)])


def given(program: Program, name: str) -> ProgramNode:
    """An input that may be anything."""
    return program.inputs.get(name) or program.input(name, -WIDE, WIDE)
