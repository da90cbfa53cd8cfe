"""The blocks that know friction: limiter (5.7), virtual friction (5.41), saturating function,
compensation by model and observer."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from frictool.control import friction_compensation, limit_cycle_limiter
from frictool.control.program import Program, ProgramNode
from frictool.control.saturation_function import saturating
from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import OK
from frictool.plant.axis import POSITION, VELOCITY, AxisParameters, rest
from tests.support.single_block import Block
from tests.support.single_block import given as input_of

numbers = st.floats(-1e3, 1e3)
TALLEST = 0.113  # of s - tanh, at x = 1.29


def _saturating() -> Block:
    return Block(lambda p: saturating(p, input_of(p, "x")))


@given(st.floats(-1e6, 1e6), st.floats(0.0, 1e3))
def test_saturating_is_odd_monotone_and_within_one(x: float, more: float) -> None:
    block = _saturating()
    here = block.step(x=x)
    assert block.step(x=-x) == -here
    assert block.step(x=x + more) >= here - 1e-15
    assert abs(here) <= 1.0
    if abs(x) >= 1.5:
        assert here == pytest.approx(math.copysign(1.0, x), abs=1e-15)


def test_saturating_is_near_tanh_and_not_below_it() -> None:
    block, xs = _saturating(), np.linspace(0.0, 20.0, 20001)
    above = block.run(x=xs) - np.tanh(xs)
    assert np.min(above) >= -1e-15
    assert 0.99 * TALLEST <= np.max(above) <= TALLEST
    assert block.step(x=1e-6) == pytest.approx(1e-6, rel=1e-10)  # slope 1


def _released(band: float, inertia: float, friction: float, error: float, speed: float) -> bool:
    block = Block(
        lambda p: limit_cycle_limiter.energy_released(
            p, input_of(p, "error"), input_of(p, "speed"), band, inertia, friction
        )
    )
    return block.step(error=error, speed=speed) != 0.0


@given(
    st.floats(1e-5, 10.0),
    st.floats(1e-2, 10.0),
    st.floats(1e-3, 1.0),
    st.floats(0.0, 10.0),
    st.floats(-2.0, 2.0),
)
def test_where_the_limiter_releases_friction_alone_ends_within_the_band(
    inertia: float, friction: float, band: float, error: float, offset: float
) -> None:
    """(5.5), (5.7): an axis let go while it moves towards its target, with a speed near the
    parabola, played by the engine."""
    path = max(error + offset * band, 0.0)
    speed = math.sqrt(2.0 * friction * path / inertia)
    axis = AxisParameters(inertia=inertia, viscous=0.0, coulomb=friction, breakaway=friction)
    state = rest(-error)
    state[VELOCITY] = speed
    assert advance(state, 0.0, axis.as_array(), 1.1 * speed * inertia / friction + 1e-6) == OK
    assert state[VELOCITY] == 0.0
    ends_inside = abs(state[POSITION]) < band
    if abs(abs(state[POSITION]) - band) > 1e-6 * (band + path):
        assert _released(band, inertia, friction, error, speed) == ends_inside
        assert _released(band, inertia, friction, -error, -speed) == ends_inside


@given(st.floats(1e-3, 10.0), numbers)
def test_the_cut_off_looks_at_the_error_alone(band: float, error: float) -> None:
    block = Block(lambda p: limit_cycle_limiter.error_released(p, input_of(p, "error"), band))
    assert (block.step(error=error) != 0.0) == (abs(error) < band)


@given(st.floats(1e-3, 100.0), st.floats(1e-3, 100.0), numbers)
def test_virtual_friction_opposes_the_speed(
    level: float, virtual_speed: float, speed: float
) -> None:
    """(5.41) inside the band: -F_cv s(v/v_r), odd, never above its level, all of it from 3/2 v_r
    on, viscous at rest."""
    block = Block(
        lambda p: limit_cycle_limiter.virtual_friction(
            p, input_of(p, "speed"), level, virtual_speed
        )
    )
    brake = block.step(speed=speed)
    assert brake * speed <= 0.0
    assert block.step(speed=-speed) == -brake
    assert abs(brake) <= level * (1 + 1e-15)
    if abs(speed) >= 1.5 * virtual_speed * (1 + 1e-12):
        assert abs(brake) == pytest.approx(level, rel=1e-14)
    slow = 1e-5 * virtual_speed
    assert block.step(speed=slow) == pytest.approx(-level * slow / virtual_speed, rel=1e-9)


@given(st.floats(0.0, 10.0), st.floats(0.0, 1.0), st.floats(1e-3, 100.0), numbers)
def test_modelled_compensation_is_the_friction_where_the_axis_slips(
    coulomb: float, viscous: float, smoothing: float, speed: float
) -> None:
    block = Block(
        lambda p: friction_compensation.model_compensation(
            p, input_of(p, "speed"), coulomb, viscous, smoothing
        )
    )
    added = block.step(speed=speed)
    assert block.step(speed=-speed) == -added
    assert added * speed >= 0.0
    if abs(speed) >= 1.5 * smoothing * (1 + 1e-12):
        assert added == pytest.approx(
            math.copysign(coulomb, speed) + viscous * speed, rel=1e-12, abs=1e-12
        )
    assert block.step(speed=0.0) == 0.0


@given(
    st.lists(st.floats(-100.0, 100.0), min_size=2, max_size=12, unique=True),
    st.integers(0, 2**32 - 1),
    numbers,
)
def test_a_table_is_interpolated_and_its_ends_continue(
    speeds: list[float], seed: int, speed: float
) -> None:
    points = np.sort(np.round(speeds, 3))
    assume(np.all(np.diff(points) > 0.0))
    drives = np.random.default_rng(seed).normal(size=points.size)
    block = Block(
        lambda p: friction_compensation.curve_compensation(
            p, input_of(p, "speed"), points.tolist(), drives.tolist()
        )
    )
    k = int(np.clip(np.searchsorted(points, speed) - 1, 0, points.size - 2))
    slope = (drives[k + 1] - drives[k]) / (points[k + 1] - points[k])
    steepest = float(np.max(np.abs(np.diff(drives) / np.diff(points))))
    scale = steepest * (abs(speed) + 200.0)
    assert block.step(speed=speed) == pytest.approx(
        drives[k] + slope * (speed - points[k]), abs=1e-12 * scale
    )


@given(
    st.floats(1.0, 500.0),
    st.floats(1e-5, 10.0),
    st.floats(0.1, 1.5),
    st.floats(-5.0, 5.0),
    st.floats(-3.0, 3.0),
    st.integers(5, 60),
)
def test_observer_finds_a_constant_friction(
    bandwidth: float, inertia: float, gain: float, friction: float, push: float, samples: int
) -> None:
    """J v' = u - F of drive units, by Euler: what is left of the error falls by 1 - L T a sample,
    whatever drives the axis."""
    period, most = 1e-3, 10.0

    def build(program: Program) -> ProgramNode:
        added, found = friction_compensation.observer_compensation(
            program, input_of(program, "speed"), bandwidth, inertia, gain, most
        )
        friction_compensation.observe(program, input_of(program, "drive"), found, bandwidth, period)
        return added

    block, speed = Block(build), 0.0
    for k in range(samples):
        drive = push * math.sin(0.3 * k)
        added = block.step(speed=speed, drive=drive)
        left = (1.0 - bandwidth * period) ** k
        assert block.value("friction_found") == pytest.approx(
            friction * (1.0 - left), abs=1e-9 * (1.0 + bandwidth)
        )
        assert added == gain * block.value("friction_found")
        speed += period / inertia * (drive - friction)


def test_observer_is_never_above_the_drives_limit() -> None:
    block = Block(
        lambda p: friction_compensation.observer_compensation(
            p, input_of(p, "speed"), 100.0, 1.0, 1.0, 2.0
        )[0]
    )
    assert block.set(observed=50.0).step(speed=0.0) == 2.0
    assert block.step(speed=10.0) == -2.0
