"""Conditions that change while a loop runs: against the loop in Python, against plants that have
the condition from the start, and by its physics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.axis_model import axis_of
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import control_step
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.engine.axis_motion import advance
from frictool.engine.closed_loop import (
    COMMAND,
    MEASURED,
    RECORD_SIZE,
    TRUE_DRIVE,
    TRUE_POSITION,
    TRUE_VELOCITY,
    measure,
    run,
)
from frictool.engine.disturbances_and_faults import (
    CONSTANT_FACTOR,
    DISTURBANCE,
    ENCODER_FAULT,
    FRICTION,
    LOST,
    NO_CONDITIONS,
    SENSOR_GAIN,
    SENSOR_OFFSET,
    VISCOUS_FACTOR,
    neutral,
)
from frictool.engine.status_codes import NOT_FINITE, OK
from frictool.plant.axis import DRIVE, POSITION, VELOCITY, AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisFrictionLevels, AxisLaws
from frictool.plant.position_load import PositionLoad
from frictool.typing import Vector
from studies.rigs.example_controllers import ROOT, started
from tests.support.axis_runs import CONTROLLER, ENCODED, PERIOD

PUBLISHED = axis_of(load(ROOT / "configs/clutch/nonlinear.yaml", Model))
SPRING = PositionLoad(stiffness=5e-4)
CURVED = ENCODED._replace(laws=AxisLaws(stribeck_velocity=5.0, fresh=0.95, rise_time=0.1))
REFERENCE = np.repeat([40.0, 10.0, 25.0], 250)


def loop(
    axis: AxisParameters,
    conditions: Vector,
    reference: Vector = REFERENCE,
    weight: PositionLoad | None = None,
    start: float = 5.0,
) -> Vector:
    """The kernel's record (n, 7) under the conditions; one sample of delay."""
    record, own = (
        np.zeros((reference.size, RECORD_SIZE)),
        started(CONTROLLER, measure(start, axis.encoder_step)),
    )
    state, opposing = rest(start), (weight or PositionLoad()).as_array()
    assert (
        run(axis.as_array(), state, own, reference, PERIOD, 1, record, opposing, conditions) == OK
    )
    return record


def scaled(
    axis: AxisParameters, friction: float = 1.0, viscous: float = 1.0, constant: float = 1.0
) -> AxisParameters:
    """The plant that has the factors from the start, written without the engine's arrays."""
    laws, back = axis.laws, axis.laws.backward
    if back is not None:
        laws = laws._replace(
            backward=AxisFrictionLevels(
                viscous * back.viscous, friction * back.coulomb, friction * back.breakaway
            )
        )
    regimes = tuple(
        regime._replace(forward=viscous * regime.forward, backward=viscous * regime.backward)
        for regime in laws.regimes
    )
    return axis._replace(
        viscous=viscous * axis.viscous,
        coulomb=friction * axis.coulomb,
        breakaway=friction * axis.breakaway,
        backlash_coulomb=friction * axis.backlash_coulomb,
        backlash_breakaway=friction * axis.backlash_breakaway,
        constant=constant * axis.constant,
        laws=laws._replace(regimes=regimes),
    )


@pytest.mark.parametrize("axis", [ENCODED, CURVED, PUBLISHED], ids=["plain", "curved", "published"])
@pytest.mark.parametrize("weight", [PositionLoad(), SPRING], ids=["free", "spring"])
def test_conditions_in_which_nothing_happens_change_no_bit(
    axis: AxisParameters, weight: PositionLoad
) -> None:
    np.testing.assert_array_equal(
        loop(axis, neutral(REFERENCE.size), weight=weight),
        loop(axis, NO_CONDITIONS, weight=weight),
        strict=True,
    )


@pytest.mark.parametrize("axis", [ENCODED, CURVED, PUBLISHED], ids=["plain", "curved", "published"])
@pytest.mark.parametrize(
    "factors", [(2.0, 1.0, 1.0), (0.5, 2.0, 1.0), (1.0, 0.5, 2.0), (2.0, 0.5, 0.5)]
)
def test_factors_act_as_the_parameters_that_they_multiply(
    axis: AxisParameters, factors: tuple[float, float, float]
) -> None:
    """To the last bit: powers of two do not round."""
    conditions = neutral(REFERENCE.size)
    conditions[:, [FRICTION, VISCOUS_FACTOR, CONSTANT_FACTOR]] = factors
    found = loop(axis, conditions)
    np.testing.assert_array_equal(found, loop(scaled(axis, *factors), NO_CONDITIONS))
    assert np.ptp(found[:, TRUE_POSITION]) > 1.0


def test_a_disturbance_acts_as_an_offset_of_the_other_sign() -> None:
    conditions = neutral(REFERENCE.size)
    conditions[:, DISTURBANCE] = 0.02
    for axis, weight in ((ENCODED, PositionLoad()), (PUBLISHED, PositionLoad()), (ENCODED, SPRING)):
        expected = loop(axis._replace(offset=axis.offset - 0.02), NO_CONDITIONS, weight=weight)
        np.testing.assert_array_equal(loop(axis, conditions, weight=weight), expected)


def in_python(axis: AxisParameters, conditions: Vector, reference: Vector) -> Vector:
    """(n, 5): measured, position, velocity, command, drive; the loop written out, with a plant of
    its own for each sample."""
    state, waiting, found, shown = rest(5.0), [0.0], [], math.nan
    own = started(CONTROLLER, math.floor(5.0 / axis.encoder_step) * axis.encoder_step)
    for k, target in enumerate(reference):
        row = conditions[k]
        shown = (
            shown
            if row[ENCODER_FAULT]
            else (math.floor(state[POSITION] / axis.encoder_step) - row[LOST]) * axis.encoder_step
        )
        command = control_step(own, target, shown, state[VELOCITY])
        waiting.append(command)
        acting = (min(max(waiting.pop(0), -50.0), 50.0) - row[SENSOR_OFFSET]) / row[SENSOR_GAIN]
        plant = scaled(axis, row[FRICTION], row[VISCOUS_FACTOR], row[CONSTANT_FACTOR])
        plant = plant._replace(offset=plant.offset - row[DISTURBANCE], drive_limit=math.inf)
        found.append(
            [
                shown,
                state[POSITION],
                state[VELOCITY],
                command,
                state[DRIVE] if axis.lag > 0.0 else acting,
            ]
        )
        assert advance(state, acting, plant.as_array(), PERIOD) == OK
    return np.array(found)


@st.composite
def happenings(draw: st.DrawFn) -> Vector:
    """Conditions of 300 samples, each column constant over spans of random length; sound at the
    first sample."""
    rows = neutral(300)
    values = {
        DISTURBANCE: st.floats(-0.2, 0.2),
        FRICTION: st.floats(0.3, 2.0),
        VISCOUS_FACTOR: st.floats(0.3, 2.0),
        CONSTANT_FACTOR: st.floats(0.7, 1.3),
        LOST: st.integers(-20, 20),
        ENCODER_FAULT: st.sampled_from([0.0, 1.0]),
        SENSOR_OFFSET: st.floats(-2.0, 2.0),
        SENSOR_GAIN: st.floats(0.8, 1.2),
    }
    for column, value in values.items():
        for begin in draw(st.lists(st.integers(1, 299), max_size=3)):
            rows[begin:, column] = draw(value)
    return rows


@settings(derandomize=True, deadline=None, max_examples=25)
@given(
    conditions=happenings(),
    lag=st.sampled_from([0.0, 3e-3]),
    curved=st.booleans(),
    target=st.floats(5.0, 60.0),
)
def test_equals_the_loop_in_python(
    conditions: Vector, lag: float, curved: bool, target: float
) -> None:
    axis, reference = (CURVED if curved else ENCODED)._replace(lag=lag), np.full(300, target)
    found = loop(axis, conditions, reference)[
        :, [MEASURED, TRUE_POSITION, TRUE_VELOCITY, COMMAND, TRUE_DRIVE]
    ]
    np.testing.assert_allclose(found, in_python(axis, conditions, reference), rtol=1e-9, atol=1e-9)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(
    efforts=st.lists(st.floats(-0.0549, 0.0549), min_size=1, max_size=8),
    friction=st.floats(1.0, 3.0),
)
def test_what_pushes_less_than_the_breakaway_moves_nothing(
    efforts: list[float], friction: float
) -> None:
    """Not even inside the backlash, whose breakaway is the least of all."""
    conditions = np.repeat(neutral(len(efforts)), 50, axis=0)
    conditions[:, DISTURBANCE], conditions[:, FRICTION] = np.repeat(efforts, 50), friction
    still = np.full(conditions.shape[0], measure(5.0, ENCODED.encoder_step))
    record = loop(ENCODED, conditions, still)
    assert np.all(record[:, TRUE_POSITION] == 5.0)
    assert np.all(record[:, TRUE_VELOCITY] == 0.0)


def test_what_pushes_more_than_the_breakaway_moves() -> None:
    conditions = neutral(50)
    conditions[:, DISTURBANCE] = 0.0551
    record = loop(ENCODED, conditions, np.full(50, measure(5.0, ENCODED.encoder_step)))
    assert record[-1, TRUE_POSITION] > 5.0


def test_wear_stops_what_an_effort_moves() -> None:
    """The same effort moves the axis, until its friction is larger; then it is held, exactly."""
    conditions = neutral(400)
    conditions[:, DISTURBANCE] = 0.12
    conditions[:, FRICTION] = np.where(np.arange(400) < 200, 1.0, 1.5)
    axis = ENCODED._replace(drive_limit=1e-12, backlash=0.0)
    record = loop(axis, conditions, np.full(400, 40.0))
    stopped = int(np.flatnonzero(record[200:, TRUE_VELOCITY] == 0.0)[0]) + 200
    assert record[199, TRUE_VELOCITY] > 0.0
    assert np.ptp(record[stopped:, TRUE_POSITION]) == 0.0


@settings(derandomize=True, deadline=None, max_examples=25)
@given(
    efforts=st.lists(st.floats(-0.3, 0.3), min_size=10, max_size=10),
    frictions=st.lists(st.floats(0.1, 3.0), min_size=10, max_size=10),
    axis=st.sampled_from([ENCODED, CURVED, PUBLISHED]),
)
def test_friction_that_drifts_makes_no_energy(
    efforts: list[float], frictions: list[float], axis: AxisParameters
) -> None:
    """Over each sample kinetic energy grows by no more than what the disturbance does; end stops
    only take away."""
    conditions = np.repeat(neutral(10), 30, axis=0)
    conditions[:, DISTURBANCE], conditions[:, FRICTION] = (
        np.repeat(efforts, 30),
        np.repeat(frictions, 30),
    )
    record = loop(axis._replace(drive_limit=1e-12), conditions, np.full(300, 30.0), start=30.0)
    kinetic = 0.5 * axis.inertia * record[:, TRUE_VELOCITY] ** 2
    work = conditions[:-1, DISTURBANCE] * np.diff(record[:, TRUE_POSITION])
    assert np.all(np.diff(kinetic) <= work + 1e-9)
    assert kinetic.max() > 0.0 or np.max(np.abs(efforts)) < 0.2


def test_a_stuck_encoder_freezes_what_is_measured_and_nothing_else() -> None:
    conditions = neutral(REFERENCE.size)
    conditions[30:60, ENCODER_FAULT] = 1.0
    found, sound = loop(ENCODED, conditions), loop(ENCODED, NO_CONDITIONS)
    np.testing.assert_array_equal(found[:30], sound[:30])
    assert np.ptp(found[29:60, MEASURED]) == 0.0
    np.testing.assert_array_equal(
        found[30, TRUE_POSITION:TRUE_VELOCITY], sound[30, TRUE_POSITION:TRUE_VELOCITY]
    )
    assert found[59, TRUE_POSITION] - found[30, TRUE_POSITION] > 5.0
    assert found[60, MEASURED] == measure(found[60, TRUE_POSITION], ENCODED.encoder_step)


def test_lost_counts_shift_what_is_measured_and_the_loop_follows_them() -> None:
    reference, lost = np.full(3000, 30.0), 30
    conditions = neutral(3000)
    conditions[1500:, LOST] = lost
    found = loop(ENCODED, conditions, reference)
    shown = np.array([measure(x, ENCODED.encoder_step) for x in found[:, TRUE_POSITION]])
    np.testing.assert_allclose(
        found[1500:, MEASURED], shown[1500:] - lost * ENCODED.encoder_step, atol=1e-9
    )
    assert found[1499, TRUE_POSITION] == pytest.approx(30.0, abs=1.5)
    assert found[-1, TRUE_POSITION] == pytest.approx(30.0 + lost * ENCODED.encoder_step, abs=1.5)


@pytest.mark.parametrize("lag", [0.0, 3e-3])
def test_a_wrong_current_sensor_makes_a_wrong_current(lag: float) -> None:
    """The loop of the current makes the measured one follow the command: b i + a = command once it
    has settled, beyond the limit too."""
    stopped = ENCODED._replace(lag=lag, breakaway=5.0, backlash_breakaway=5.0)
    conditions = neutral(400)
    conditions[:, SENSOR_OFFSET], conditions[:, SENSOR_GAIN] = -0.5, 0.9
    record = loop(stopped, conditions, np.full(400, 50.0))
    command = record[:, COMMAND]
    assert command[-1] == 50.0
    assert record[-1, TRUE_DRIVE] == pytest.approx((50.0 + 0.5) / 0.9, rel=1e-9)
    if lag == 0.0:
        np.testing.assert_array_equal(record[1:, TRUE_DRIVE], (command[:-1] + 0.5) / 0.9)


def test_a_command_that_is_no_number_is_reported() -> None:
    record, reference = np.zeros((3, RECORD_SIZE)), np.full(3, 55.0)
    own = started(CONTROLLER, 5.0)
    own.real[controller_program(CONTROLLER).states["x[0]"].index] = math.nan
    status = run(
        ENCODED.as_array(),
        rest(5.0),
        own,
        reference,
        PERIOD,
        0,
        record,
        PositionLoad().as_array(),
        neutral(3),
    )
    assert status == NOT_FINITE


def test_a_disturbance_adds_to_a_load() -> None:
    """Before it acts, the loop under a load is that without conditions."""
    conditions = neutral(REFERENCE.size)
    conditions[300:, DISTURBANCE] = 0.05
    found, free = (
        loop(ENCODED, conditions, weight=SPRING),
        loop(ENCODED, NO_CONDITIONS, weight=SPRING),
    )
    np.testing.assert_array_equal(found[:301, TRUE_POSITION], free[:301, TRUE_POSITION])
    assert np.max(np.abs(found[301:, TRUE_POSITION] - free[301:, TRUE_POSITION])) > 0.01
