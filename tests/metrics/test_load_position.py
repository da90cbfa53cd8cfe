"""The load behind the backlash: bounds hold the load of an axis that is played, and close once it
has been taken along."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.metrics.load_position_bounds import load_bounds, load_static_error
from frictool.typing import Vector


def plain_load(position: list[float], half: float, gap: float) -> Vector:
    """Sample by sample: the motor pushes the load where it has come to the edge of the gap."""
    load, out = position[0] - gap, []
    for value in position:
        if value - load > half:
            load = value - half
        elif value - load < -half:
            load = value + half
        out.append(load)
    return np.array(out)


@given(
    st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=40),
    st.floats(0.0, 6.0),
    st.floats(-1.0, 1.0),
    st.floats(-1.0, 1.0),
    st.integers(0, 10**6),
)
def test_the_bounds_hold_the_load_whatever_is_unknown(
    steps: list[float], backlash: float, gap: float, wider: float, seed: int
) -> None:
    """The place in the gap, the sensor's error and the backlash's interval."""
    true = np.cumsum(steps)
    measured = true + 0.1 * np.random.default_rng(seed).uniform(-1.0, 1.0, true.size)
    actual = max(0.0, backlash + 0.4 * wider)
    load = plain_load(true.tolist(), 0.5 * actual, 0.5 * gap * actual)
    low, high = load_bounds(measured, backlash, 0.1 + 0.2)
    assert np.all(low <= load + 1e-9)
    assert np.all(load <= high + 1e-9)


def test_a_stroke_beyond_the_backlash_tells_where_the_load_is() -> None:
    position = np.concatenate((np.linspace(0.0, 10.0, 101), np.linspace(10.0, 8.0, 21)))
    low, high = load_bounds(position, 3.0, 0.05)
    assert (low[0], high[0]) == (pytest.approx(-1.55), pytest.approx(1.55))
    pushed = np.minimum(position[40:] - 1.5, 8.5)
    pushed[position[40:].argmax() :] = (
        8.5  # the motor comes back by 2, less than the backlash: the load does not move
    )
    np.testing.assert_allclose(low[40:], pushed - 0.05)
    np.testing.assert_allclose(high[40:] - low[40:], 0.1)


def test_without_a_backlash_the_load_is_the_position() -> None:
    position = np.array([0.0, 3.0, -1.0])
    low, high = load_bounds(position, 0.0, 0.0)
    np.testing.assert_array_equal(low, position)
    np.testing.assert_array_equal(high, position)


def test_the_load_of_an_axis_that_moves_has_its_largest_error() -> None:
    """A limit cycle that is wider than the backlash moves the load, whose mean is at the target."""
    time = np.arange(4000) * 1e-3
    step, amplitude, backlash = 1e-3, 0.5, 0.2
    motor = np.floor((2.0 + amplitude * np.sin(20.0 * time)) / step) * step
    true = plain_load(motor.tolist(), 0.5 * backlash, 0.0)
    largest = float(np.max(np.abs(true[-400:] - 2.0)))
    low, high = load_static_error(load_bounds(motor, backlash, step), 2.0, step)
    assert low <= largest <= high
    assert low > 0.7 * amplitude
    resting = load_bounds(np.full(4000, 2.0), backlash, step)
    assert load_static_error(resting, 2.0, step) == load_static_error(resting, 2.0)
