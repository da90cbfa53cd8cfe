"""The composed program in double: equal to the plain controller bit by bit on any input, for both
structures and every block."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program, control_step, read, start_at
from frictool.documents.controller import Controller
from tests.control.plain_controller import PlainController
from tests.control.random_controllers import Sample, assaults, controllers, wanderings


def _same(one: float, other: float) -> bool:
    """To the last bit; the sign of a zero, too."""
    return one == other and math.copysign(1.0, one) == math.copysign(1.0, other)


@given(controllers(), wanderings() | assaults(), st.floats(0.012, 0.015), st.floats(0.0, 0.2))
def test_equals_the_plain_controller_bit_by_bit(
    controller: Controller, sequence: tuple[float, list[Sample]], constant: float, coulomb: float
) -> None:
    start, samples = sequence
    plain, program = PlainController(controller, start), controller_program(controller)
    made = compile_program(program)
    start_at(made, start)
    for name in plain.scheduled:
        plain.scheduled[name] = made.real[program.states[name].index] = (
            constant if name == "constant" else coulomb
        )
    states = {name: node.index for name, node in program.states.items()}
    letter = "s" if plain.sections else "x"
    for reference, position, velocity in samples:
        drive = control_step(made, reference, position, velocity)
        assert _same(drive, plain.step(reference, position, velocity))
        seen = {
            "filtered_before": plain.r,
            "eta_before": plain.eta,
            "limited_before": float(plain.limited),
            "observed": plain.observed,
        }
        for name in seen.keys() & states.keys():
            assert read(made, states[name]) == seen[name], name
        names = [
            f"s[{i // 2}][{i % 2}]" if letter == "s" else f"x[{i}]" for i in range(len(plain.x))
        ]
        assert [read(made, states[name]) for name in names] == plain.x
