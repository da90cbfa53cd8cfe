"""A winding limits the current by what the supply leaves beside the back-electromotive force."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from frictool.adapters.axis_model import axis_of
from frictool.documents.bench import Winding
from frictool.engine.axis_motion import advance, drive_range
from frictool.engine.bench_experiment import play_reference
from frictool.engine.bench_position_loop import PositionServo
from frictool.engine.closed_loop import (
    COMMAND,
    RECORD_SIZE,
    TRUE_DRIVE,
    TRUE_VELOCITY,
    measure,
    run,
)
from frictool.engine.disturbances_and_faults import CONSTANT_FACTOR, NO_CONDITIONS, neutral
from frictool.engine.effort_replay import replay_parameters
from frictool.engine.status_codes import OK
from frictool.plant.axis import DRIVE, SUPPLY, VELOCITY, AxisParameters, rest
from frictool.plant.position_load import PositionLoad
from studies.rigs.clutch_model import clutch_model
from studies.rigs.example_controllers import started
from tests.support.axis_runs import CONTROLLER, ENCODED, PERIOD

WOUND = ENCODED._replace(resistance=0.2, supply=6.0)  # 30 A at rest, 448 rad/s without any
FREE = AxisParameters(1.32e-5, 0.0, 0.0, 0.0, constant=0.0134, resistance=0.2, supply=6.0)


def loop(
    axis: AxisParameters, conditions: NDArray[np.float64] = NO_CONDITIONS, target: float = 60.0
) -> NDArray[np.float64]:
    record, own = np.zeros((600, RECORD_SIZE)), started(CONTROLLER, measure(5.0, axis.encoder_step))
    reference = np.repeat([target, 5.0], 300)
    assert (
        run(
            axis.as_array(),
            rest(5.0),
            own,
            reference,
            PERIOD,
            1,
            record,
            PositionLoad().as_array(),
            conditions,
        )
        == OK
    )
    return record


@pytest.mark.parametrize("lag", [0.0, 3e-3])
def test_no_current_beyond_what_the_supply_leaves(lag: float) -> None:
    record = loop(WOUND._replace(lag=lag))
    voltage = 0.2 * record[:, TRUE_DRIVE] + 0.0134 * record[:, TRUE_VELOCITY]
    assert np.max(np.abs(voltage)) <= 6.0 * (1.0 + 1e-12)
    assert np.max(np.abs(voltage)) == pytest.approx(6.0)  # and it is met, both ways
    assert voltage.min() == pytest.approx(-6.0)
    assert np.max(np.abs(record[:, COMMAND])) > 31.0


def test_a_supply_that_never_limits_changes_no_event() -> None:
    """But for the parts of a sample: the exact motion in four parts is that in one, to rounding."""
    np.testing.assert_allclose(loop(WOUND._replace(supply=1e6)), loop(ENCODED), rtol=0, atol=1e-6)


@settings(derandomize=True, deadline=None)
@given(velocity=st.floats(-900.0, 900.0))
def test_the_range_of_the_drive(velocity: float) -> None:
    """(voltage - constant v)/resistance at either end, or the drive's own limit; beyond the idle
    speed it only brakes."""
    low, high = drive_range(WOUND.as_array(), velocity)
    assert high == pytest.approx(min(50.0, (6.0 - 0.0134 * velocity) / 0.2))
    assert low == pytest.approx(max(-50.0, (-6.0 - 0.0134 * velocity) / 0.2))
    assert (high < 0.0) == (velocity > 6.0 / 0.0134)


def test_a_free_axis_runs_up_to_its_idle_speed_as_the_machine_equation_says() -> None:
    """J v' = K (U - K v)/R: the bound is taken at the beginning of each call, an error of first
    order in its length."""
    constant = 0.0134**2 / (1.32e-5 * 0.2)
    errors = []
    for period in (1e-3, 5e-4, 2.5e-4):
        state, array, worst = rest(), FREE.as_array(), 0.0
        for k in range(round(0.05 / period)):
            assert advance(state, math.inf if k < 0 else 1e3, array, period) == OK
            exact = 6.0 / 0.0134 * (1.0 - math.exp(-constant * period * (k + 1)))
            worst = max(worst, abs(state[VELOCITY] - exact))
        errors.append(worst)
    assert errors[0] < 0.03 * 6.0 / 0.0134
    assert errors[1] / errors[0] == pytest.approx(0.5, abs=0.06)
    assert errors[2] / errors[1] == pytest.approx(0.5, abs=0.04)


def test_a_current_that_flows_falls_with_the_bound() -> None:
    """Not with the lag of the current loop, which has no voltage left."""
    state = rest(drive=25.0)
    state[VELOCITY] = 300.0
    array = FREE._replace(lag=1.0).as_array()
    assert advance(state, 25.0, array, 1e-6) == OK
    assert state[DRIVE] == pytest.approx((6.0 - 0.0134 * 300.0) / 0.2, rel=1e-3)


def test_the_back_emf_falls_with_the_constant() -> None:
    conditions = neutral(600)
    conditions[:, CONSTANT_FACTOR] = 0.5
    record = loop(WOUND._replace(lag=0.0), conditions)
    voltage = 0.2 * record[:, TRUE_DRIVE] + 0.5 * 0.0134 * record[:, TRUE_VELOCITY]
    assert np.max(np.abs(voltage)) == pytest.approx(6.0)


def test_the_bench_gives_it_and_a_replay_of_what_was_measured_does_not_take_it() -> None:
    model = clutch_model()
    wound = msgspec.structs.replace(
        model.bench.actuator, winding=Winding(resistance_ohm=0.2, voltage_v=12.0)
    )
    axis = axis_of(
        msgspec.structs.replace(model, bench=msgspec.structs.replace(model.bench, actuator=wound))
    )
    assert (axis.resistance, axis.supply) == (0.2, 12.0)
    assert axis.as_array()[SUPPLY] == 12.0
    np.testing.assert_array_equal(
        replay_parameters(axis)[:SUPPLY], replay_parameters(axis_of(model))[:SUPPLY]
    )


def test_what_cannot_be_is_named() -> None:
    with pytest.raises(ValueError, match="supply is 0; allowed: > 0"):
        WOUND._replace(supply=0.0).as_array()
    with pytest.raises(ValueError, match="resistance is -1; allowed: >= 0"):
        WOUND._replace(resistance=-1.0).as_array()


@pytest.mark.parametrize("lag", [0.0, 3e-3])
def test_a_bench_that_follows_a_reference_has_the_same_winding(lag: float) -> None:
    """Its log too shows no current that the supply cannot drive; the speed is that of the motion,
    by central differences."""
    axis, reference = WOUND._replace(lag=lag, encoder_step=0.0), np.repeat([40.0, 5.0], 300)
    position, drive = np.empty(600), np.empty(600)
    servo = np.array(PositionServo(proportional=0.1, derivative=1e-3))
    assert (
        play_reference(
            axis.as_array(),
            PositionLoad().as_array(),
            rest(5.0),
            servo,
            reference,
            PERIOD,
            0,
            position,
            drive,
        )
        == OK
    )
    voltage = 0.2 * drive[1:-1] + 0.0134 * (position[2:] - position[:-2]) / (2.0 * PERIOD)
    assert np.percentile(np.abs(voltage), 99.0) <= 6.0 * 1.05
    assert np.max(np.abs(drive)) <= 60.0
    sound = np.empty(600)
    loose = axis._replace(resistance=0.0).as_array()
    assert (
        play_reference(
            loose,
            PositionLoad().as_array(),
            rest(5.0),
            servo,
            reference,
            PERIOD,
            0,
            position,
            sound,
        )
        == OK
    )
    assert np.max(np.abs(sound)) > np.max(np.abs(drive))
