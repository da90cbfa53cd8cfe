"""Rate, jitter, gaps and encoder step of constructed records."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.logs.quality.time_base import encoder_step, levels, time_base


def test_a_time_base_with_gaps_and_jitter():
    intervals = np.array([0.01, 0.011, 0.009, 0.05, 0.01, 0.03, 0.01])
    base = time_base(np.concatenate(([2.0], 2.0 + np.cumsum(intervals))))
    assert base.samples == 8
    assert base.rate_hz == pytest.approx(100.0)
    assert base.gaps == 2
    assert base.longest_gap_s == pytest.approx(0.05)
    assert base.jitter_s == pytest.approx(np.std([0.01, 0.011, 0.009, 0.01, 0.01]))
    assert base.duration_s == pytest.approx(0.13)


def test_one_sample_has_no_rate():
    base = time_base(np.array([1.0]))
    assert np.isnan(base.rate_hz)
    assert base.gaps == 0


@given(
    step=st.floats(1e-9, 10.0),
    offset=st.floats(-5.0, 5.0),
    seed=st.integers(0, 1000),
    speed=st.sampled_from([1, 3, 20]),
)
def test_the_step_of_a_quantised_motion_is_found(step: float, offset: float, seed: int, speed: int):
    """Also from one so fast that neighbouring counts are rarely both seen."""
    rng = np.random.default_rng(seed)
    counts = np.cumsum(rng.integers(-speed, speed + 1, 2000))
    found = encoder_step((counts + offset) * step)
    assert found == pytest.approx(step, rel=1e-6)


def test_even_counts_only_look_like_twice_the_step():
    assert encoder_step(np.arange(0, 100, 2) * 0.1) == pytest.approx(0.2)


def test_counts_that_never_are_neighbours_still_give_the_step():
    assert encoder_step(np.cumsum([0, *[2, 3] * 20]) * 0.1) == pytest.approx(0.1)


@given(st.integers(0, 1000))
def test_a_continuous_motion_has_no_step(seed: int):
    assert encoder_step(np.random.default_rng(seed).normal(size=300)) is None


def test_levels_that_differ_by_rounding_are_one():
    assert levels(np.full(10, 0.3)) == 1
    assert levels(np.array([0.1 + 0.2, 0.3, 0.4, 0.4])) == 2


def test_too_few_positions_tell_nothing():
    assert encoder_step(np.array([0.0, 1.0, 2.0] * 50)) is None
