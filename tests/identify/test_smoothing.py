"""Zero-phase smoothing: the kernel, the weights of the effort, and the exact equation of motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from frictool.identify.fit_result import Interval, SlidingFit
from frictool.identify.motion_record import make_record
from frictool.identify.rows.slip_fit import (
    LARGEST_SHARE,
    SMALLEST_SHARE,
    _bearable_share,
    shortest_window,
    slipping_window,
)
from frictool.identify.rows.smoothing import (
    acceleration_filter,
    choose_window,
    position_noise,
    smoothed,
    smoothing_kernel,
)
from frictool.plant.weak_form import effort_weights
from tests.support.linear_axis import linear_axis

PERIOD = 1e-3
WINDOWS = st.integers(3, 60).map(lambda n: 2 * n + 1)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(window=WINDOWS)
def test_the_filter_is_the_second_difference_of_the_bump(window: int) -> None:
    g, c = smoothing_kernel(window, PERIOD), acceleration_filter(window, PERIOD)
    assert g.sum() == pytest.approx(1.0, rel=1e-9)
    assert np.allclose(g, g[::-1], atol=1e-12)
    assert np.all(g > 0.0)
    assert np.convolve(g, [1.0, -2.0, 1.0]) / PERIOD**2 == pytest.approx(
        c, abs=1e-9 * np.abs(c).max()
    )


@settings(derandomize=True, deadline=None, max_examples=30)
@given(lag=st.floats(1e-4, 0.5))
def test_effort_weights_integrate_a_lagging_effort_over_the_triangle(lag: float) -> None:
    r = PERIOD / lag

    def rise(s: float) -> float:
        return float(np.expm1(-r * s) / np.expm1(-r))

    after = quad(lambda s: (1.0 - s) * rise(s), 0.0, 1.0)[0]
    rising = quad(lambda s: s * rise(s), 0.0, 1.0)[0]
    assert effort_weights(PERIOD, lag) == pytest.approx(
        (0.5 - rising, rising + 0.5 - after, after), abs=1e-6
    )


def test_a_held_effort_weighs_the_two_intervals_before_it() -> None:
    assert effort_weights(PERIOD, 0.0) == (0.5, 0.5, 0.0)
    assert effort_weights(PERIOD, 1e-6) == pytest.approx((0.0, 0.5, 0.5), abs=2e-3)


@pytest.mark.parametrize("window", [11, 31, 101])
def test_smoothing_leaves_no_bias_under_a_zero_order_hold(window: int) -> None:
    """An inertia without friction under random held efforts: acceleration and effort are the same
    number at every sample."""
    generator = np.random.default_rng(3)
    effort, inertia = generator.normal(size=600), 2.5
    position, speed = np.zeros(600), 0.0
    for k in range(599):
        position[k + 1] = position[k] + speed * PERIOD + 0.5 * effort[k] / inertia * PERIOD**2
        speed += effort[k] / inertia * PERIOD
    record = make_record(
        "free", np.arange(600) * PERIOD, position, effort, resolution=1e-12, lag=0.0
    )
    acceleration, velocity, mean = smoothed(record, window)
    inner = np.isfinite(acceleration)
    assert inner.sum() == 600 - window + 1
    assert np.isfinite(velocity).sum() == inner.sum()
    assert inertia * acceleration[inner] == pytest.approx(mean[inner], abs=1e-6)


def test_a_straight_line_has_its_slope_and_no_acceleration() -> None:
    record = make_record(
        "line",
        np.arange(300) * PERIOD,
        7.0 + 3.0 * np.arange(300) * PERIOD,
        np.ones(300),
        resolution=1e-9,
        lag=0.0,
    )
    acceleration, velocity, effort = (values[20:-20] for values in smoothed(record, 21))
    assert np.abs(acceleration).max() < 1e-6
    assert velocity == pytest.approx(3.0)
    assert effort == pytest.approx(1.0)


def test_the_window_grows_with_the_encoder_step_up_to_a_share_of_the_stroke() -> None:
    time = np.arange(3000) * PERIOD
    path = np.sin(2.0 * np.pi * time)
    windows = []
    for step in (1e-7, 1e-4, 1e-2):
        record = make_record(
            "sine", time, np.floor(path / step) * step, np.zeros(3000), resolution=step, lag=0.0
        )
        assert position_noise(record) == pytest.approx(step / 12.0**0.5, rel=0.25)
        windows.append(choose_window(record, 500.0, 0.0075))
    assert windows[0] == 11
    assert 11 < windows[1] < windows[2] == 83


def test_records_of_two_encoders_share_the_window_of_the_coarser_one() -> None:
    _, fine = linear_axis(3)
    step = 20.0 * fine.resolution
    coarse = make_record(
        "coarse", fine.time, np.floor(fine.position / step) * step, fine.effort, step, fine.lag
    )
    alone = [shortest_window([record], SMALLEST_SHARE) for record in (fine, coarse)]
    assert alone[0] < alone[1]
    for records in ([fine, coarse], [coarse, fine]):
        assert (
            shortest_window(records, SMALLEST_SHARE) == slipping_window(records, None) == alone[1]
        )


@pytest.mark.parametrize("half", [1e-6, 1e-4, 1e-3])
def test_the_attenuation_of_the_inertia_stays_far_below_its_deviation(half: float) -> None:
    """A share s of noise attenuates the inertia by s^2; no share is above the largest one."""
    inertia = 2.0
    reach = half * inertia * float(scipy.special.ndtri(0.975))
    result = SlidingFit({"inertia": Interval.around(inertia, reach)}, {}, 0.0, None, 1.0, 1)
    share = _bearable_share(result, 0.95)
    assert share**2 == pytest.approx(0.2 * half)
    assert _bearable_share(result, 0.99) < share
    wide = SlidingFit({"inertia": Interval.around(inertia, inertia)}, {}, 0.0, None, 1.0, 1)
    assert _bearable_share(wide, 0.95) == LARGEST_SHARE
    assert _bearable_share(replace(result, parameters={}), 0.95) == LARGEST_SHARE
