"""Replays against the engine itself, sample by sample, and against what physics asks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.engine.axis_motion import advance
from frictool.engine.bench_position_loop import PositionServo, follow_reference
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.engine.status_codes import NOT_FINITE, OK
from frictool.plant.axis import DRIVE, AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisFrictionLevels, AxisLaws
from frictool.plant.position_load import LoadHarmonic, PositionLoad, load_effort

AXIS = AxisParameters(inertia=0.5, viscous=2.0, coulomb=3.0, breakaway=4.0, offset=0.3)
VARIANTS = {
    "plain": AXIS,
    "frictionless": AXIS._replace(viscous=0.0, coulomb=0.0, breakaway=0.0),
    "backlash": AXIS._replace(backlash=0.02, backlash_coulomb=1.0, backlash_breakaway=1.2),
    "directions and stops": AXIS._replace(
        laws=AxisLaws(backward=AxisFrictionLevels(1.5, 3.5, 4.2), stops=(-0.4, 0.4))
    ),
    "stribeck": AXIS._replace(laws=AxisLaws(stribeck_velocity=0.01)),
}
PERIOD = 1e-3
NO_LOAD = PositionLoad()


def wave(seed: int, size: float, n: int = 600) -> np.ndarray:
    draw = np.random.default_rng(seed)
    angle = 2.0 * np.pi * np.arange(n) * PERIOD
    return np.asarray(
        size * np.sin(draw.uniform(1.0, 8.0) * angle + draw.uniform(0.0, 6.0))
        + 0.5 * draw.standard_normal(n)
    )


def replay_of(
    axis: AxisParameters, effort: np.ndarray, load: PositionLoad = NO_LOAD
) -> tuple[int, np.ndarray, np.ndarray]:
    x, v = np.empty(effort.size), np.empty(effort.size)
    return (
        replay(
            replay_parameters(axis), load.as_array(), rest(0.1), effort, effort, FREE, PERIOD, x, v
        ),
        x,
        v,
    )


def slowly(axis: AxisParameters, effort: np.ndarray) -> np.ndarray:
    """Position and velocity (n, 2), every sample by the engine; between samples the drive relaxes
    so that it meets the next one."""
    p, state, out = replay_parameters(axis), rest(0.1), np.empty((effort.size, 2))
    for k, now in enumerate(effort):
        out[k] = state[:2]
        after = effort[min(k + 1, effort.size - 1)]
        command = (
            now
            if axis.lag == 0.0
            else (after - now * math.exp(-PERIOD / axis.lag)) / (1.0 - math.exp(-PERIOD / axis.lag))
        )
        state[DRIVE] = now
        assert advance(state, command, p, PERIOD) == OK
    return out


@pytest.mark.parametrize("lag", [0.0, 2e-3])
@pytest.mark.parametrize("variant", VARIANTS)
@given(seed=st.integers(0, 10_000), size=st.floats(0.0, 30.0))
@settings(max_examples=8)
def test_a_replay_is_the_engine_sample_by_sample(
    variant: str, lag: float, seed: int, size: float
) -> None:
    axis, effort = VARIANTS[variant]._replace(lag=lag), wave(seed, size)
    status, x, v = replay_of(axis, effort)
    assert status == OK
    reference = slowly(axis, effort)
    scale = 1.0 + np.abs(reference).max(axis=0)
    assert np.abs(x - reference[:, 0]).max() < 1e-9 * scale[0]
    assert np.abs(v - reference[:, 1]).max() < 1e-8 * scale[1]


def test_an_effort_that_is_no_number_is_a_status() -> None:
    effort = wave(1, 5.0)
    effort[300] = np.nan
    assert replay_of(AXIS, effort)[0] == NOT_FINITE


def test_a_spring_without_friction_swings_at_its_frequency() -> None:
    axis = AxisParameters(inertia=0.5, viscous=0.0, coulomb=0.0, breakaway=0.0)
    load = PositionLoad(stiffness=200.0)
    _, x, _ = replay_of(axis, np.zeros(2000), load)
    time = np.arange(x.size) * PERIOD
    omega = math.sqrt(200.0 / 0.5)
    late = (
        omega * time[-1] * (omega * PERIOD) ** 2 / 12.0
    )  # rad: a force held at the middle of its period, error of second order
    assert np.abs(x - 0.1 * np.cos(omega * time)).max() < 0.1 * late


@given(
    x=st.floats(-10.0, 10.0),
    stiffness=st.floats(-5.0, 5.0),
    number=st.floats(0.1, 20.0),
    sine=st.floats(-3, 3),
    cosine=st.floats(-3, 3),
)
def test_a_load_is_the_sum_of_its_terms(
    x: float, stiffness: float, number: float, sine: float, cosine: float
) -> None:
    load = PositionLoad(
        stiffness, (LoadHarmonic(number, sine, cosine), LoadHarmonic(2.0, 0.5, 0.0))
    )
    expected = (
        stiffness * x
        + sine * math.sin(number * x)
        + cosine * math.cos(number * x)
        + 0.5 * math.sin(2.0 * x)
    )
    assert load_effort(load.as_array(), x) == pytest.approx(expected, abs=1e-12)
    assert load_effort(PositionLoad().as_array(), x) == 0.0


def test_the_correction_holds_the_replay_at_the_measured_position() -> None:
    effort = wave(3, 12.0, 3000)
    _, measured, _ = replay_of(AXIS, effort)
    wrong = AXIS._replace(coulomb=2.5)
    x, v = np.empty(effort.size), np.empty(effort.size)
    assert (
        replay(
            replay_parameters(wrong),
            np.empty(0),
            rest(0.1),
            effort,
            measured,
            np.array([0.3, 40.0]),
            PERIOD,
            x,
            v,
        )
        == OK
    )
    assert np.abs(measured - x).max() < 0.01 * np.abs(measured - replay_of(wrong, effort)[1]).max()


def serve_slowly(
    axis: AxisParameters, servo: PositionServo, reference: np.ndarray, start: float
) -> np.ndarray:
    """Position and effort (n, 2) under the sampled controller, every sample by the engine."""
    p, state, out, held = replay_parameters(axis), rest(0.0), np.empty((reference.size, 2)), 0.0
    state[DRIVE] = start
    x_before, r_before = 0.0, 2.0 * reference[0] - reference[1]
    for k, wanted in enumerate(reference):
        x = state[0]
        direct = servo.proportional * (wanted - x)
        direct += (
            servo.derivative
            * (servo.reference_rate * (wanted - r_before) - (x - x_before))
            / PERIOD
        )
        if servo.integral > 0.0:
            held = start - direct if k == 0 else held + servo.integral * (wanted - x) * PERIOD
        x_before, r_before = x, wanted
        out[k] = x, float(np.clip(direct + held, -servo.limit, servo.limit))
        assert advance(state, out[k, 1], p, PERIOD) == OK
    return out


@pytest.mark.parametrize("lag", [0.0, 2e-3])
@given(
    seed=st.integers(0, 1000),
    integral=st.sampled_from([0.0, 2000.0]),
    rate=st.sampled_from([0.0, 1.0]),
    limit=st.floats(3.0, 50.0),
)
@settings(max_examples=8)
def test_a_servo_is_its_difference_equation_around_the_engine(
    seed: int, lag: float, integral: float, rate: float, limit: float
) -> None:
    axis = AXIS._replace(lag=lag)
    servo = PositionServo(400.0, integral, 20.0, rate, limit)
    reference = 0.01 * wave(seed, 10.0)
    x, v, u = (np.empty(reference.size) for _ in range(3))
    assert (
        follow_reference(
            replay_parameters(axis),
            np.empty(0),
            rest(0.0),
            np.array(servo),
            reference,
            1.0,
            PERIOD,
            x,
            v,
            u,
        )
        == OK
    )
    expected = serve_slowly(axis, servo, reference, 1.0)
    assert np.abs(x - expected[:, 0]).max() < 1e-8
    assert np.abs(u - expected[:, 1]).max() < 1e-4
