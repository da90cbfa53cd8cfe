"""Machine code of a program: the operations of the interpreter, bit by bit."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import (
    PORTS,
    CompiledProgram,
    compile_program,
    control_step,
    copy_program,
    start_at,
)
from frictool.control.machine_code import machine_code, started_values
from frictool.control.number_format import machine_in
from frictool.documents.controller import Controller
from frictool.typing import Vector
from studies.rigs.example_controllers import clutch_controller
from tests.control.programs import hostile, random_program
from tests.control.random_controllers import Sample, assaults, controllers, seeds, wanderings


def coded(program: CompiledProgram, start: float) -> tuple[Callable[..., float], Vector]:
    """Return the compiled function of a sample, and the values that it reads and writes."""
    code = machine_code(program)
    assert code is not None
    kind = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64, *[ctypes.c_double] * 3)
    values = started_values(program, start)
    function = kind(code.address)
    return lambda *sample: function(values.ctypes.data, *sample), values


def agree(program: CompiledProgram, start: float, samples: Sequence[Sample]) -> None:
    """Assert that drive and states are those of the interpreter after every sample."""
    plain = copy_program(program)
    start_at(plain, start)
    step, values = coded(program, start)
    states = program.writes[:, 0]
    for sample in samples:
        np.testing.assert_array_equal(step(*sample), control_step(plain, *sample))
        np.testing.assert_array_equal(values[states], plain.real[states])


@given(controllers(bounded=True), wanderings(20) | assaults(40))
def test_a_controller_does_the_same_whatever_the_sensors_show(
    controller: Controller, sequence: tuple[float, list[Sample]]
) -> None:
    start, samples = sequence
    agree(compile_program(controller_program(controller)), start, samples)


@given(seeds)
def test_every_operation_on_any_values(seed: int) -> None:
    program = random_program(seed)
    rows = hostile(seed, program, 5)
    samples = [(row["reference"], row["position"], row["velocity"]) for row in rows]
    agree(compile_program(program), 0.25, samples)
    assert PORTS == ("reference", "position", "velocity")


def test_programs_that_differ_in_coefficients_share_one_code() -> None:
    program = compile_program(controller_program(clutch_controller()))
    other = copy_program(program)
    other.real[:] *= 2.0
    assert machine_code(program) is machine_code(other)


@pytest.mark.parametrize("number", ["float", "q31"])
def test_other_formats_are_interpreted(number: str) -> None:
    assert machine_code(machine_in(controller_program(clutch_controller()), number)) is None
