"""The loop with machine code: the record and the last state of the interpreted loop, bit by bit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program, copy_program, start_at
from frictool.control.machine_code import machine_code, started_values
from frictool.control.program_replay import value_along
from frictool.engine.closed_loop import RECORD_SIZE, load_of_run, measure, run
from frictool.engine.coded_loop import replay_coded, run_coded
from frictool.engine.disturbances_and_faults import (
    CONSTANT_FACTOR,
    DISTURBANCE,
    ENCODER_FAULT,
    FRICTION,
    INVALID,
    NO_CONDITIONS,
    SENSOR_GAIN,
    SENSOR_OFFSET,
    VISCOUS_FACTOR,
    neutral,
)
from frictool.engine.status_codes import NOT_FINITE, OK
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisFrictionLevels, AxisLaws, ViscousRegime
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from frictool.typing import Vector
from studies.rigs.example_controllers import clutch_controller

PERIOD, SAMPLES, START = 1e-3, 400, 4.5
PROGRAM = compile_program(controller_program(clutch_controller()))
PLAIN = AxisParameters(
    inertia=1.3e-5, viscous=3.8e-4, coulomb=0.1, breakaway=0.13, offset=2e-3, constant=0.0134,
    lag=3e-3, drive_limit=50.0, backlash=0.4, backlash_coulomb=0.05, backlash_breakaway=0.055,
    encoder_step=2.0 * math.pi / 56.0,
)  # fmt: skip
AXES = {
    "plain": PLAIN,
    "no lag": PLAIN._replace(lag=0.0),
    "slow drive": PLAIN._replace(lag=0.1),
    "winding": PLAIN._replace(resistance=0.3, supply=12.0),
    "dwell": PLAIN._replace(laws=AxisLaws(fresh=0.5, rise_time=5e-2)),
    "knee and stops": PLAIN._replace(
        laws=AxisLaws(
            backward=AxisFrictionLevels(1e-4, 0.11, 0.14),
            regimes=(ViscousRegime(40.0, 2e-4, 1e-4),),
            stops=(1.0, 20.0), restitution=0.3,
        )
    ),
    "Stribeck": PLAIN._replace(
        laws=AxisLaws(
            backward=AxisFrictionLevels(1e-4, 0.11, 0.14),
            regimes=(ViscousRegime(40.0, 2e-4, 1e-4),),
            stribeck_velocity=6.0, fresh=0.8, rise_time=5e-3, stops=(1.0, 20.0), restitution=0.3,
        )
    ),
}  # fmt: skip
CURVED = {"Stribeck"}  # axes whose slips have no closed form
LOAD = PositionLoad(1e-3, (LoadHarmonic(1.0, 0.02, 0.01),))


def agree(axis: AxisParameters, reference: Vector, conditions: Vector, load: PositionLoad) -> int:
    """Assert that both loops give the same status, record and state; return the status.

    The interpreted loop is that of any axis, the other loop that of `load_of_run`.
    """
    array, code = axis.as_array(), machine_code(PROGRAM)
    assert code is not None
    start = measure(START, axis.encoder_step)
    interpreted, values = copy_program(PROGRAM), started_values(PROGRAM, start)
    start_at(interpreted, start)
    states = rest(START), rest(START)
    records = np.zeros((2, reference.size, RECORD_SIZE))
    test = reference, PERIOD, 1
    status = run(array, states[0], interpreted, *test, records[0], load.as_array(), conditions)
    used = load_of_run(array, load.as_array())
    coded = run_coded(array, states[1], values, code.address, *test, records[1], used, conditions)
    assert coded == status
    np.testing.assert_array_equal(records[1], records[0])
    np.testing.assert_array_equal(states[1], states[0])
    return int(status)


@st.composite
def courses(draw: st.DrawFn) -> tuple[Vector, Vector]:
    """Return a reference of a few steps, and conditions that change now and then."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    reference = np.repeat(random.uniform(2.0, 30.0, 4), SAMPLES // 4)
    if draw(st.booleans()):
        return reference, NO_CONDITIONS
    rows = neutral(SAMPLES)
    for _ in range(draw(st.integers(1, 4))):
        begin, end = np.sort(random.integers(0, SAMPLES + 1, 2))
        column, low, high = (
            (DISTURBANCE, -0.2, 0.2), (FRICTION, 0.5, 1.5), (VISCOUS_FACTOR, 0.5, 1.5),
            (CONSTANT_FACTOR, 0.8, 1.2), (SENSOR_OFFSET, -0.5, 0.5), (SENSOR_GAIN, 0.9, 1.1),
        )[int(random.integers(6))]  # fmt: skip
        rows[begin:end, column] = random.uniform(low, high)
    lost = int(random.integers(SAMPLES))
    rows[lost : lost + int(random.integers(3)), ENCODER_FAULT] = INVALID
    return reference, rows


@pytest.mark.parametrize("name", AXES)
@settings(derandomize=True, deadline=None, max_examples=12)
@given(course=courses(), loaded=st.booleans())
def test_every_bit_is_that_of_the_interpreted_loop(
    name: str, course: tuple[Vector, Vector], loaded: bool
) -> None:
    """Rest, slip, backlash and stops, under disturbances, drifts and lost samples."""
    axis = AXES[name]
    if loaded and axis.laws == AxisLaws():
        axis = axis._replace(laws=AxisLaws(stops=(-1e3, 1e3)))
    assert agree(axis, *course, LOAD if loaded else PositionLoad()) == OK


@pytest.mark.parametrize("name", AXES)
def test_only_an_axis_whose_slips_are_all_closed_form_runs_without_integrators(name: str) -> None:
    array = AXES[name].as_array()
    assert (load_of_run(array, np.zeros(0)) is None) == (name not in CURVED)
    assert load_of_run(array, LOAD.as_array()) is not None


def test_a_disturbance_moves_an_axis_that_its_drive_holds() -> None:
    """The axis rests for long, is pushed once, and its drive never changes by itself."""
    rows = neutral(SAMPLES)
    rows[300, DISTURBANCE] = 5.0
    assert agree(PLAIN, np.full(SAMPLES, START), rows, PositionLoad()) == OK


def test_a_run_that_cannot_go_on_ends_at_the_same_sample() -> None:
    reference = np.full(SAMPLES, 20.0)
    conditions = neutral(SAMPLES)
    conditions[100:, SENSOR_GAIN] = np.nan
    assert agree(PLAIN, reference, conditions, PositionLoad()) == NOT_FINITE


def test_any_value_is_replayed_as_the_interpreter_computes_it() -> None:
    program = controller_program(clutch_controller())
    inputs = np.random.default_rng(8).uniform(-20.0, 20.0, (3, SAMPLES))
    inputs[1, SAMPLES // 2] = math.nan  # a lost position
    chosen = [node for node in program.nodes if node.op in ("state", "dot") or node.index % 9 == 0]
    for node in chosen:
        code = machine_code(PROGRAM, node.index)
        assert code is not None
        interpreted = copy_program(PROGRAM)
        start_at(interpreted, START)
        before = float(interpreted.real[node.index])
        expected, replayed = np.empty(SAMPLES), np.empty(SAMPLES)
        value_along(interpreted, node.index, *inputs, expected)
        if node.op == "state":  # the code returns it as it is before the sample
            expected = np.append(before, expected[:-1])
        replay_coded(started_values(PROGRAM, START), code.address, *inputs, replayed)
        np.testing.assert_array_equal(replayed, expected)
    assert {node.op for node in chosen} >= {"state", "dot", "select"}
