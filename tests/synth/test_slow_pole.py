"""A slow pole that is moved leaves the controller around the bandwidth as it was, and one that is
not slow stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti
from frictool.synth.slow_pole import stabilise_slow_pole, with_integrator

BANDWIDTH, PERIOD = 40.0, 1e-3


def controller(seed: int, slow: float, order: int, period: float) -> Lti:
    """Random, in random coordinates, with one pole at `slow` [rad/s] and the others beyond 100
    rad/s."""
    random = np.random.default_rng(seed)
    rates = -np.r_[-slow, random.uniform(100.0, 900.0, order - 1)]
    a = np.diag(np.exp(rates * period) if period else rates)
    t = np.linalg.qr(random.normal(size=(order, order)))[0] * random.uniform(0.3, 3.0, order)
    b, c = random.uniform(0.5, 2.0, (order, 1)), random.uniform(0.5, 2.0, (1, order))
    return Lti(np.linalg.solve(t, a @ t), np.linalg.solve(t, b), c @ t, np.ones((1, 1)), period)


@given(
    st.integers(0, 10_000), st.floats(-0.5, 0.5), st.integers(1, 6), st.sampled_from([0.0, PERIOD])
)
def test_around_the_bandwidth_the_controller_stays(
    seed: int, slow: float, order: int, period: float
) -> None:
    k = controller(seed, slow, order, period)
    moved = with_integrator(k, BANDWIDTH)
    assert np.min(np.abs(np.linalg.eigvals(moved.a) - (1.0 if period else 0.0))) < 1e-12
    frequencies = np.array([BANDWIDTH, 3 * BANDWIDTH, 10 * BANDWIDTH])
    before, after = k.response(frequencies)[:, 0, 0], moved.response(frequencies)[:, 0, 0]
    # r/(jw - p) - r/jw = r p/(jw (jw - p)): a part of the slow term that falls with p/w
    share = abs(slow) / frequencies
    slow_term = np.abs(k.response([1e-9])[0, 0, 0]) * share  # the slow term's size at w, and more
    assert np.all(
        np.abs(after - before) <= 2.0 * share * np.maximum(slow_term, np.abs(before)) + 1e-9
    )


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.01, 3.0), st.sampled_from([0.0, PERIOD]))
def test_only_an_unstable_slow_pole_is_brought_inside(
    seed: int, slow: float, period: float
) -> None:
    assert stabilise_slow_pole(controller(seed, -slow, 4, period), BANDWIDTH, 0.3).order == 4
    unstable = controller(seed, slow, 4, period)
    moved = stabilise_slow_pole(unstable, BANDWIDTH, 0.3)
    assert not unstable.stable
    assert moved.stable
    stable = controller(seed, -slow, 4, period)
    assert stabilise_slow_pole(stable, BANDWIDTH, 0.3) is stable


def test_a_pole_that_is_not_slow_is_not_moved() -> None:
    with pytest.raises(NoSolutionError, match="slowest controller pole is"):
        with_integrator(controller(1, -20.0, 1, PERIOD), BANDWIDTH)
    with pytest.raises(NoSolutionError, match="slowest controller pole is"):
        stabilise_slow_pole(controller(1, 20.0, 1, PERIOD), BANDWIDTH, 0.3)
