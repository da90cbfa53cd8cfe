"""Tracking error, motions of a reference and settling after them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.metrics.reference_motion import MIN_SAMPLES, find_motions
from frictool.metrics.settling_after_profile import NO_REST, settling_after_profile
from frictool.metrics.tracking_error import tracking_error_peak, tracking_error_rms

TIME = np.arange(5000) * 1e-3
RAMPS = np.interp(TIME, [0.0, 0.5, 1.5, 3.0, 3.5], [0.0, 0.0, 1.0, 1.0, 0.5])


def test_tracking_error() -> None:
    reference = np.sin(TIME)
    position = reference + 0.1 * np.cos(2 * math.pi * TIME)
    assert tracking_error_peak(reference, position) == pytest.approx(0.1)
    assert tracking_error_rms(reference, position) == pytest.approx(0.1 / math.sqrt(2.0), rel=1e-9)


def test_motions_begin_and_end_with_the_ramps() -> None:
    assert find_motions(RAMPS) == ((500, 1500), (3000, 3500))


def test_a_step_is_no_motion_and_a_smooth_reference_is_one() -> None:
    steps = np.where(TIME < 1.0, 0.0, 1.0)
    assert find_motions(steps) == ()
    assert find_motions(np.zeros(50)) == ()
    assert find_motions(np.sin(TIME)) == ((0, TIME.size - 1),)
    resampled = steps.copy()
    resampled[1000:1003] = (0.3, 0.6, 0.9)
    assert find_motions(resampled) == ()


def decaying(constant: float, size: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return a position that is `size` off the ramps and decays to them after each."""
    error = np.full(TIME.size, size)
    for stop, following in ((1500, 3001), (3500, TIME.size)):
        error[stop:following] = size * np.exp(-(TIME[stop:following] - TIME[stop]) / constant)
    return RAMPS - error


@given(st.floats(0.01, 0.2), st.floats(0.02, 0.5))
def test_settling_is_the_time_of_an_exponential_to_its_band(constant: float, band: float) -> None:
    found = settling_after_profile(TIME, RAMPS, decaying(constant, 1.0), band, 0.0)
    assert found == pytest.approx(constant * math.log(1.0 / band), abs=1.1e-3)


def test_the_sensor_step_widens_the_band() -> None:
    position = decaying(0.05, 1.0)
    assert settling_after_profile(TIME, RAMPS, position, 1e-9, 0.1) == settling_after_profile(
        TIME, RAMPS, position, 0.1, 0.0
    )


def test_an_axis_that_stays_outside_never_settles() -> None:
    assert settling_after_profile(TIME, RAMPS, RAMPS - 0.2, 0.1, 0.0) == math.inf


def test_a_reference_without_rest_has_no_settling_time() -> None:
    assert settling_after_profile(TIME, np.sin(TIME), np.sin(TIME), 0.1, 0.0) == NO_REST
    assert settling_after_profile(TIME, np.zeros(5000), np.zeros(5000), 0.1, 0.0) == NO_REST


@pytest.mark.parametrize("rest", [MIN_SAMPLES - 1, MIN_SAMPLES])
def test_a_rest_of_enough_samples_divides_a_motion(rest: int) -> None:
    ramp = np.arange(100) / 100.0
    reference = np.concatenate((ramp, np.full(rest - 1, 1.0), 1.0 + ramp, np.full(200, 2.0)))
    found = find_motions(reference)
    turn = 100
    if rest < MIN_SAMPLES:
        assert found == ((0, turn + rest - 1 + 100),)
    else:
        assert found == ((0, turn), (turn + rest - 1, turn + rest - 1 + 100))
