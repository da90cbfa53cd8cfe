"""Error of an estimated velocity."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from frictool.metrics.velocity_error import velocity_error_peak, velocity_error_rms

TIME = np.arange(1000) * 1e-3
SPEEDS = arrays(np.float64, 20, elements=st.floats(-1e3, 1e3))


def test_a_sine_is_off_by_its_amplitude_over_the_root_of_two() -> None:
    velocity = 30.0 * np.sin(2.0 * math.pi * TIME)
    assert velocity_error_rms(
        velocity + 0.1 * np.cos(2.0 * math.pi * TIME), velocity
    ) == pytest.approx(0.1 / math.sqrt(2.0), rel=1e-9)
    assert velocity_error_peak(
        velocity + 0.1 * np.cos(2.0 * math.pi * TIME), velocity
    ) == pytest.approx(0.1, rel=1e-9)


def test_the_true_one_has_no_error_and_a_broken_one_a_number() -> None:
    velocity = np.sin(TIME)
    assert velocity_error_rms(velocity, velocity) == 0.0
    assert velocity_error_rms(velocity + 1e200, velocity) == pytest.approx(1e200)


@given(SPEEDS, SPEEDS)
def test_no_sample_is_further_off_than_the_largest(
    estimated: np.ndarray, velocity: np.ndarray
) -> None:
    rms, largest = velocity_error_rms(estimated, velocity), velocity_error_peak(estimated, velocity)
    assert rms <= largest * (1.0 + 1e-12)
    assert largest <= rms * math.sqrt(velocity.size) * (1.0 + 1e-12)
