"""The compiled closed loop against the same loop written out in Python; encoder, delay and drive as
documented."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from frictool.control.compiled_program import control_step
from frictool.engine.axis_motion import advance
from frictool.engine.closed_loop import (
    COMMAND,
    LOAD,
    MEASURED,
    RECORD_SIZE,
    TRUE_DRIVE,
    TRUE_POSITION,
    TRUE_VELOCITY,
    measure,
    run,
)
from frictool.engine.disturbances_and_faults import NO_CONDITIONS, SENSOR_OFFSET, neutral
from frictool.engine.status_codes import NOT_FINITE, OK
from frictool.plant.axis import DRIVE, LOAD_POSITION, POSITION, VELOCITY, AxisParameters, rest
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from studies.references.event_integration import event_integration
from studies.rigs.example_controllers import BRAKE_LAW, started
from tests.support.axis_runs import CLUTCH, CONTROLLER, ENCODED, PERIOD

NO_LOAD = PositionLoad().as_array()


def loop(
    axis: AxisParameters, reference: NDArray[np.float64], delay: int, start: float = 5.0
) -> NDArray[np.float64]:
    """The kernel's record (n, 7) for the example controller with the braking law."""
    record = np.zeros((reference.size, RECORD_SIZE))
    own = started(CONTROLLER, measure(start, axis.encoder_step))
    assert (
        run(
            axis.as_array(),
            rest(start),
            own,
            reference,
            PERIOD,
            delay,
            record,
            NO_LOAD,
            NO_CONDITIONS,
        )
        == OK
    )
    return record


@settings(derandomize=True, deadline=None, max_examples=15)
@given(
    targets=st.lists(st.floats(0.0, 63.0), min_size=1, max_size=3),
    delay=st.integers(0, 2),
    lag=st.sampled_from([0.0, 3e-3]),
    step=st.sampled_from([0.0, ENCODED.encoder_step]),
)
def test_equals_the_loop_in_python(
    targets: list[float], delay: int, lag: float, step: float
) -> None:
    axis = CLUTCH._replace(lag=lag, encoder_step=step)
    reference = np.repeat(targets, 200)
    record = loop(axis, reference, delay)
    state, array = rest(5.0), axis.as_array()
    own, commands = (
        started(CONTROLLER, math.floor(5.0 / step) * step if step else 5.0),
        [0.0] * delay,
    )
    for k, target in enumerate(reference):
        y = math.floor(state[POSITION] / step) * step if step else state[POSITION]
        commands.append(control_step(own, target, y, state[VELOCITY]))
        expected = [y, state[POSITION], state[VELOCITY], state[LOAD_POSITION], commands[-1]]
        assert advance(state, commands[k], array, PERIOD) == OK
        np.testing.assert_array_equal(
            record[k, [MEASURED, TRUE_POSITION, TRUE_VELOCITY, LOAD, COMMAND]], expected
        )
        if lag == 0.0:
            assert record[k, TRUE_DRIVE] == commands[k]
        elif k + 1 < reference.size:
            assert record[k + 1, TRUE_DRIVE] == state[DRIVE]


@settings(derandomize=True, deadline=None)
@given(position=st.floats(-1e3, 1e3), step=st.floats(1e-6, 1.0))
def test_encoder_reports_the_edge_below(position: float, step: float) -> None:
    reported = measure(position, step)
    assert -1e-9 * abs(position) <= position - reported <= step * (1 + 1e-9) + 1e-9 * abs(position)
    assert reported / step == pytest.approx(round(reported / step), abs=1e-6)


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_nothing_acts_before_the_delay(delay: int) -> None:
    record = loop(ENCODED._replace(lag=0.0), np.full(20, 55.0), delay)
    first = int(np.flatnonzero(record[:, COMMAND])[0])
    np.testing.assert_array_equal(record[: first + delay, TRUE_DRIVE], 0.0)
    np.testing.assert_array_equal(
        record[first + delay :, TRUE_DRIVE], record[first : 20 - delay, COMMAND]
    )


def test_a_failing_sample_is_reported_and_what_came_before_is_kept() -> None:
    record, state = np.zeros((3, RECORD_SIZE)), rest(5.0)
    reference, conditions = np.full(3, 5.0), neutral(3)
    conditions[1, SENSOR_OFFSET] = math.nan
    assert (
        run(
            ENCODED.as_array(),
            state,
            started(CONTROLLER, 5.0),
            reference,
            PERIOD,
            0,
            record,
            NO_LOAD,
            conditions,
        )
        == NOT_FINITE
    )
    assert record[0, TRUE_POSITION] == 5.0
    assert record[2, TRUE_POSITION] == 0.0


def test_reaches_the_target_within_the_band_and_stays_without_drive() -> None:
    record = loop(ENCODED, np.full(16_000, 55.0), 1)
    assert abs(record[-1, MEASURED] - 55.0) <= BRAKE_LAW.band + ENCODED.encoder_step
    np.testing.assert_array_equal(record[-1000:, COMMAND], 0.0)
    assert np.ptp(record[-10_000:, TRUE_POSITION]) == 0.0


def plain_loop_with_load(
    axis: AxisParameters, load: PositionLoad, reference: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Positions (n,): the loop written out, each sample moved by scipy."""
    state, own, found = rest(5.0), started(CONTROLLER, measure(5.0, axis.encoder_step)), []
    for target in reference:
        found.append(state[POSITION])
        command = control_step(
            own, target, measure(state[POSITION], axis.encoder_step), state[VELOCITY]
        )
        state[:4] = event_integration(axis, state, command, PERIOD, load=load)
    return np.array(found)


@settings(derandomize=True, deadline=None, max_examples=4)
@given(
    stiffness=st.floats(-2e-3, 2e-3), sine=st.floats(-0.1, 0.1), cosine=st.floats(-0.1, 0.1),
    number=st.sampled_from([1.0, 7.0 / 6.0]),
    target=st.floats(0.0, 60.0),
)  # fmt: skip
def test_a_load_acts_as_the_loop_in_python_says(
    stiffness: float, sine: float, cosine: float, number: float, target: float
) -> None:
    load, reference = (
        PositionLoad(stiffness, (LoadHarmonic(number, sine, cosine),)),
        np.full(100, target),
    )
    record, own = (
        np.zeros((100, RECORD_SIZE)),
        started(CONTROLLER, measure(5.0, CLUTCH.encoder_step)),
    )
    assert (
        run(
            CLUTCH.as_array(),
            rest(5.0),
            own,
            reference,
            PERIOD,
            0,
            record,
            load.as_array(),
            NO_CONDITIONS,
        )
        == OK
    )
    np.testing.assert_allclose(
        record[:, TRUE_POSITION], plain_loop_with_load(CLUTCH, load, reference), rtol=0, atol=1e-7
    )


def test_what_rests_under_a_load_stays_where_it_is() -> None:
    axis = AxisParameters(1e-5, 4e-4, 0.1, 0.11, drive_limit=1e-12)
    record = np.zeros((500, RECORD_SIZE))
    load = PositionLoad(0.0, (LoadHarmonic(1.0, 0.05, 0.09),)).as_array()
    assert (
        run(
            axis.as_array(),
            rest(5.0),
            started(CONTROLLER, 5.0),
            np.full(500, 20.0),
            PERIOD,
            1,
            record,
            load,
            NO_CONDITIONS,
        )
        == OK
    )
    assert np.all(record[:, TRUE_POSITION] == 5.0)
