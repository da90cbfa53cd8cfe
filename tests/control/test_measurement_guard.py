"""The guard of the inputs, in every number format: the last valid value replaces an invalid input,
then the drive is 0."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.controller_composition import controller_program
from frictool.control.coefficient_words import BITS
from frictool.control.compiled_program import (
    CompiledProgram,
    compile_program,
    control_step,
    copy_program,
    hold,
    read,
    start_at,
)
from frictool.control.fixed_point import fixed_program
from frictool.control.number_format import machine_in
from frictool.control.program import Program
from frictool.documents.controller import Controller
from tests.control.random_controllers import Sample, wanderings
from tests.support.export_cases import CASES
from tests.support.interpreted_program import InFloat, InWords

FORMATS = ("double", "float", "q31")
LOST = (math.nan, math.inf, -math.inf)
losses = st.lists(
    st.tuples(st.integers(0, 2), st.sampled_from(LOST), st.integers(1, 6), st.integers(0, 8)),
    max_size=8,
)
cases = st.sampled_from([name for name in CASES if name != "scheduled"])


def _guarded(case: str, held: int) -> tuple[Controller, Program]:
    controller = msgspec.structs.replace(CASES[case], measurement_hold_samples=held)
    return controller, controller_program(controller)


def _fault(program: Program, made: CompiledProgram) -> bool:
    assert program.guard is not None
    return bool(read(made, program.guard.left.index) < 0.0)


def _with_losses(
    samples: list[Sample], lost: list[tuple[int, float, int, int]]
) -> list[list[float]]:
    """The samples with bursts of invalid inputs: input, value, length, distance to the burst
    before."""
    rows, at = [list(sample) for sample in samples], 0
    for which, value, length, distance in lost:
        at += distance
        for row in rows[at : at + length]:
            row[which] = value
        at += length
    return rows


@given(cases, st.sampled_from(FORMATS), st.sampled_from([0, 1, 3, 5]), wanderings(60), losses)
def test_lost_inputs_are_bridged_by_their_last_valid_values_then_the_drive_is_zero(
    case: str,
    number: str,
    held: int,
    sequence: tuple[float, list[Sample]],
    lost: list[tuple[int, float, int, int]],
) -> None:
    """Beside a controller that loses nothing and is given the last valid values by the test."""
    start, samples = sequence
    _, program = _guarded(case, held)
    inputs = list(program.inputs)
    made = machine_in(program, number)
    plain = copy_program(made)
    start_at(made, start)
    start_at(plain, start)
    last, in_a_row, fault = [start, start, 0.0], 0, False
    for row in _with_losses(samples, lost):
        drive = control_step(made, *row)
        valid = [math.isfinite(value) for value in row]
        last = [
            value if one else before for value, one, before in zip(row, valid, last, strict=True)
        ]
        in_a_row = 0 if all(valid[: len(inputs)]) else in_a_row + 1
        fault = fault or in_a_row > held
        expected = control_step(plain, *last)
        assert drive == (0.0 if fault else expected)
        assert _fault(program, made) == fault


@settings(max_examples=settings.default.max_examples // 2)
@given(cases, st.sampled_from([0, 3]), wanderings(60), losses)
def test_results_that_are_kept_from_the_last_sample_are_those_of_every_operation(
    case: str,
    held: int,
    sequence: tuple[float, list[Sample]],
    lost: list[tuple[int, float, int, int]],
) -> None:
    """The kernel leaves out the guard's operations after a valid sample; here all of them are done
    at every sample."""
    start, samples = sequence
    _, program = _guarded(case, held)
    rows = _with_losses(samples, lost)
    single, words = compile_program(program, single=True), machine_in(program, "q31")
    slow = (
        InFloat(program, float(np.float32(start))),
        InWords(fixed_program(program, BITS["q31"]), start),
    )
    for made, plain in ((single, slow[0]), (words, slow[1])):
        start_at(made, start)
        for row in rows:
            given_inputs = dict(zip(("reference", "position", "velocity"), row, strict=True))
            with np.errstate(invalid="ignore"):
                expected = plain.step(given_inputs)
            assert control_step(made, *row) == expected
    assert [float(single.single[place]) for place in slow[0].states] == [
        float(value) for value in slow[0].states.values()
    ]
    assert [int(words.word[place]) for place in slow[1].states] == list(slow[1].states.values())


@pytest.mark.parametrize("number", FORMATS)
@pytest.mark.parametrize("lost", LOST)
def test_a_start_at_an_invalid_position_is_the_fault_and_a_valid_start_ends_it(
    number: str, lost: float
) -> None:
    _, program = _guarded("cut", 3)
    new = machine_in(program, number)
    made, other = copy_program(new), copy_program(new)
    start_at(made, lost)
    assert _fault(program, made)
    assert [control_step(made, 30.0, 5.0, 0.0) for _ in range(20)] == [0.0] * 20
    assert _fault(program, made)
    made = copy_program(new)
    start_at(made, 5.0)
    start_at(other, 5.0)
    drives = [control_step(made, 30.0, 5.0, 0.0) for _ in range(20)]
    assert drives == [control_step(other, 30.0, 5.0, 0.0) for _ in range(20)]
    assert max(drives) > 1.0
    assert not _fault(program, made)


def test_a_scheduled_parameter_that_is_no_number_is_ignored() -> None:
    program = controller_program(CASES["scheduled"])
    made = compile_program(program)
    place = next(
        node.index for node in program.states.values() if node.index not in program.updates
    )
    hold(made, place, 0.013)
    for value in LOST:
        hold(made, place, value)
    assert made.real[place] == 0.013


def test_only_an_input_may_be_no_number() -> None:
    program = Program()
    with pytest.raises(ValueError, match="is constant; allowed: an input"):
        program.valid(program.constant(1.0))
