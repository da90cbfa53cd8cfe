"""Machines against plain interpreters: float against numpy.float32 operation by operation, copies
and starts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import (
    PORTS,
    compile_program,
    control_step,
    copy_program,
    read,
    start_at,
)
from frictool.control.number_format import machine_in
from frictool.control.program import Program
from frictool.documents.controller import Controller
from studies.rigs.example_controllers import clutch_controller
from tests.control.programs import hostile, random_program
from tests.control.random_controllers import Sample, assaults, controllers, seeds, wanderings
from tests.support.interpreted_program import InFloat


@given(controllers(bounded=True), wanderings(20) | assaults(40))
def test_float_is_numpy_float32_operation_by_operation(
    controller: Controller, sequence: tuple[float, list[Sample]]
) -> None:
    start, samples = sequence
    program = controller_program(controller)
    made, plain = compile_program(program, single=True), InFloat(program, start)
    start_at(made, start)
    for sample in samples:
        assert control_step(made, *sample) == plain.step(dict(zip(PORTS, sample, strict=True)))
        computed = [node.index for node in program.nodes if node.index not in plain.states]
        np.testing.assert_array_equal(
            made.single[computed], [plain.values[place] for place in computed]
        )
        assert all(made.single[state] == value for state, value in plain.states.items())


@given(seeds)
def test_every_operation_in_double_and_float(seed: int) -> None:
    """Any program: float as numpy.float32 does it, and double as Python does."""
    program = random_program(seed)
    single, plain = compile_program(program, single=True), InFloat(program, 0.25)
    start_at(single, 0.25)
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        for row in hostile(seed, program, 5):
            found = control_step(single, *[row[name] for name in PORTS])
            np.testing.assert_array_equal(found, plain.step(row))


@pytest.mark.parametrize("number", ["double", "float", "q31"])
def test_a_copy_runs_by_itself_and_what_rests_stays(number: str) -> None:
    program = controller_program(clutch_controller())
    one = machine_in(program, number)
    start_at(one, 7.5)
    other = copy_program(one)
    assert [control_step(one, 7.5, 7.5, 0.0) for _ in range(50)] == [0.0] * 50
    moved = [control_step(other, 30.0, 7.5, 0.0) for _ in range(50)]
    assert max(moved) > 0.0
    assert [control_step(one, 30.0, 7.5, 0.0) for _ in range(50)] == moved
    filtered = program.states["filtered_before"].index
    assert read(one, filtered) == read(other, filtered) > 7.5


def test_a_program_without_an_output_is_refused() -> None:
    with pytest.raises(ValueError, match="no output"):
        compile_program(Program())


def test_a_dot_has_as_many_of_each() -> None:
    program = Program()
    with pytest.raises(ValueError, match="dot product of 0 coefficients and 0 values; allowed"):
        program.dot([], [])
    with pytest.raises(ValueError, match="dot product of 1 coefficients and 2 values"):
        program.dot([program.constant(1.0)], [program.constant(1.0)] * 2)
