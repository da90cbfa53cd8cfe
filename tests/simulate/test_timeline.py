"""Disturbances, drifts and faults of a scenario as the engine's rows: impulses, instants, and what
adds up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.conditions import Disturbance, DriftPoint, Drifts, SensorFault
from frictool.documents.quantity import Quantity
from frictool.engine.disturbances_and_faults import (
    CONSTANT_FACTOR,
    DISTURBANCE,
    ENCODER_FAULT,
    FRICTION,
    LOST,
    SENSOR_GAIN,
    SENSOR_OFFSET,
    VISCOUS_FACTOR,
    neutral,
)
from frictool.simulate.scenario_conditions import conditions_of
from studies.rigs.step_scenario import scenario

T, N = 1e-3, 2000


def torque(value: float) -> Quantity:
    return Quantity(value=value, unit="N m")


def amperes(value: float) -> Quantity:
    return Quantity(value=value, unit="A")


def test_where_nothing_happens_there_are_no_rows() -> None:
    assert conditions_of(scenario(), N, T).shape == (0, 8)


def test_rows_are_neutral_beside_what_happens() -> None:
    rows = conditions_of(scenario(disturbances=(Disturbance("step", torque(0.1), 1.0),)), N, T)
    np.testing.assert_array_equal(
        np.delete(rows, DISTURBANCE, axis=1), np.delete(neutral(N), DISTURBANCE, axis=1)
    )


@pytest.mark.parametrize("at", [0.0, 0.3, 0.7, 1.1])
def test_a_step_is_exactly_its_effort_from_its_sample_on(at: float) -> None:
    rows = conditions_of(scenario(disturbances=(Disturbance("step", torque(0.1), at),)), N, T)[
        :, DISTURBANCE
    ]
    first = round(at / T)
    np.testing.assert_array_equal(rows, np.where(np.arange(N) < first, 0.0, 0.1))


def test_a_step_within_a_sample_acts_for_the_rest_of_it() -> None:
    rows = conditions_of(scenario(disturbances=(Disturbance("step", torque(0.1), 0.50025),)), N, T)[
        :, DISTURBANCE
    ]
    assert rows[499:502] == pytest.approx([0.0, 0.075, 0.1])


@settings(derandomize=True, deadline=None)
@given(at=st.floats(0.0, 1.5), lasts=st.floats(1e-5, 0.4), effort=st.floats(-2.0, 2.0))
def test_a_pulse_keeps_its_impulse_wherever_it_lies(at: float, lasts: float, effort: float) -> None:
    rows = conditions_of(
        scenario(disturbances=(Disturbance("pulse", torque(effort), at, lasts),)), N, T
    )[:, DISTURBANCE]
    assert rows.sum() * T == pytest.approx(effort * lasts, rel=1e-6, abs=1e-12)
    assert np.all(np.abs(rows) <= abs(effort) * (1.0 + 1e-12))


@settings(derandomize=True, deadline=None)
@given(
    at=st.floats(0.0, 1.0),
    lasts=st.floats(1e-4, 0.9),
    frequency=st.floats(0.1, 499.0),
    phase=st.floats(-360.0, 360.0),
)
def test_a_sine_has_the_mean_of_each_sample(
    at: float, lasts: float, frequency: float, phase: float
) -> None:
    """Against its antiderivative, which a sine has."""
    wave = Disturbance("sine", torque(0.3), at, lasts, frequency, phase)
    rows = conditions_of(scenario(disturbances=(wave,)), N, T)[:, DISTURBANCE]
    w = 2.0 * math.pi * frequency
    edges = np.clip(np.arange(N + 1) * T, at, at + lasts) - at
    whole = -0.3 / w * np.cos(w * edges + math.radians(phase))
    np.testing.assert_allclose(rows, np.diff(whole) / T, atol=1e-6)


def test_disturbances_add_up() -> None:
    both = (Disturbance("step", torque(0.1), 0.5), Disturbance("pulse", torque(-0.3), 0.4, 0.2))
    rows = conditions_of(scenario(disturbances=both), N, T)[:, DISTURBANCE]
    assert rows[[399, 450, 550, 650]] == pytest.approx([0.0, -0.3, -0.2, 0.1])


def test_a_drift_is_a_straight_line_in_the_middle_of_each_sample() -> None:
    drifts = Drifts(
        friction=(DriftPoint(0.5, 1.0), DriftPoint(1.5, 2.0)), constant=(DriftPoint(0.0, 0.9),)
    )
    rows = conditions_of(scenario(drifts=drifts), N, T)
    assert rows[[0, 499, 1000, 1999], FRICTION] == pytest.approx([1.0, 1.0, 1.5005, 2.0])
    np.testing.assert_array_equal(rows[:, CONSTANT_FACTOR], 0.9)
    np.testing.assert_array_equal(rows[:, VISCOUS_FACTOR], 1.0)


def test_faults_begin_and_end_at_their_samples() -> None:
    faults = (
        SensorFault("lost_counts", 0.1, counts=5),
        SensorFault("lost_counts", 0.3, counts=-2),
        SensorFault("encoder_stuck", 0.2, until_s=0.25),
        SensorFault("drive_offset", 0.5, offset=amperes(0.4)),
        SensorFault("drive_offset", 0.6, until_s=0.7, offset=amperes(0.1)),
        SensorFault("drive_gain", 0.9005, until_s=1.0, gain_error=-0.1),
    )
    rows = conditions_of(scenario(sensor_faults=faults), N, T)
    np.testing.assert_array_equal(rows[[99, 100, 299, 300, 1999], LOST], [0, 5, 5, 3, 3])
    np.testing.assert_array_equal(rows[[199, 200, 249, 250], ENCODER_FAULT], [0, 1, 1, 0])
    assert rows[[499, 500, 599, 600, 699, 700], SENSOR_OFFSET] == pytest.approx(
        [0, 0.4, 0.4, 0.5, 0.5, 0.4]
    )
    assert rows[[900, 901, 999, 1000], SENSOR_GAIN] == pytest.approx(
        [1, 0.9, 0.9, 1]
    )  # none before its instant


def test_instants_that_rounding_moves_are_still_theirs() -> None:
    """0.3/1e-4 and its like are not whole numbers in floating point."""
    for tenths in range(1, 100):
        at = tenths / 10
        rows = conditions_of(
            scenario(sensor_faults=(SensorFault("lost_counts", at, counts=1),)), 100_000, 1e-4
        )[:, LOST]
        assert int(np.flatnonzero(rows)[0]) == 1000 * tenths
