"""Each block against a slow reference or another library's form of it, and the properties that the design rests on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from frictool.control.band import BRAKE, REST, RUN, next_mode
from frictool.control.difference_equation import equation_advance, equation_output
from frictool.control.limiter import limit
from frictool.control.position_law import speed_reference
from frictool.control.prefilter import prefilter_coefficients, prefilter_step
from frictool.control.speed_filter import speed_filter_coefficients, speed_filter_step
from frictool.control.speed_integral import next_eta

PERIOD = 1e-3
numbers = st.floats(-1e3, 1e3)
positive = st.floats(1e-6, 1e6)


def _filtered(w: float, m: float, reference: list[float], start: float = 0.0) -> tuple[list[float], list[float]]:
    h, p, q = prefilter_coefficients(w, m, PERIOD)
    f, v, last = start, 0.0, start
    filtered, speed = [], []
    for r in reference:
        f, v = prefilter_step(h, p, q, f, v, last, r)
        last = r
        filtered.append(f)
        speed.append(v)
    return filtered, speed


@given(st.floats(1.0, 500.0), st.floats(0.2, 2.0), st.lists(numbers, min_size=1, max_size=60))
def test_prefilter_is_the_tustin_form_of_5_69(w: float, m: float, reference: list[float]) -> None:
    numerator, denominator = signal.bilinear([1.0], [1 / w**2, 2 * m / w, 1.0], 1 / PERIOD)
    filtered, speed = _filtered(w, m, reference)
    scale = max(1.0, max(abs(r) for r in reference))
    np.testing.assert_allclose(filtered, signal.lfilter(numerator, denominator, reference), atol=1e-9 * scale)
    # and its speed is that of s/(..), sampled the same way
    numerator, denominator = signal.bilinear([1.0, 0.0], [1 / w**2, 2 * m / w, 1.0], 1 / PERIOD)
    np.testing.assert_allclose(speed, signal.lfilter(numerator, denominator, reference), atol=1e-9 * w * scale)


@given(st.floats(5.0, 200.0), st.floats(0.7, 1.0))
def test_prefilter_has_unit_gain_and_its_own_time_constant(w: float, m: float) -> None:
    filtered, speed = _filtered(w, m, [1.0] * int(20 / (w * PERIOD)))
    assert filtered[-1] == pytest.approx(1.0, abs=1e-4)
    assert abs(speed[-1]) < 1e-3 * w
    assert max(filtered) == pytest.approx(1 + (math.exp(-math.pi * m / math.sqrt(1 - m * m)) if m < 1 else 0), abs=5e-3)
    # the area above the step response is the delay 2 m/w
    assert PERIOD * sum(1 - f for f in filtered) == pytest.approx(2 * m / w, abs=1.5 * PERIOD)


@given(st.floats(-1e3, 1e3), st.floats(1.0, 500.0), st.floats(0.1, 2.0))
def test_settled_prefilter_does_not_move_by_a_bit(position: float, w: float, m: float) -> None:
    filtered, speed = _filtered(w, m, [position] * 5, start=position)
    assert filtered == [position] * 5
    assert speed == [0.0] * 5


@given(st.floats(1.0, 1000.0), st.lists(numbers, min_size=1, max_size=40))
def test_speed_filter_is_a_low_pass_by_tustin(bandwidth: float, differences: list[float]) -> None:
    a, b0, b1 = speed_filter_coefficients(bandwidth, PERIOD)
    speed, last, measured = 0.0, 0.0, []
    for difference in differences:
        speed = speed_filter_step(a, b0, b1, speed, difference, last)
        last = difference
        measured.append(speed)
    expected = signal.lfilter(*signal.bilinear([bandwidth], [1.0, bandwidth], 1 / PERIOD), differences)
    np.testing.assert_allclose(measured, expected, atol=1e-9 * max(1.0, max(map(abs, differences))))
    assert b0 + b1 == pytest.approx(1 - a, rel=1e-12)


@given(numbers, numbers, numbers)
def test_no_speed_filter_is_the_difference_itself(speed: float, difference: float, last: float) -> None:
    assert speed_filter_step(*speed_filter_coefficients(0.0, PERIOD), speed, difference, last) == difference


def _law(gain: float, band: float, error: float) -> float:
    return speed_reference(gain, gain / math.sqrt(band), band, error)


@given(positive, positive, st.floats(0.0, 1e6))
def test_position_law_is_odd_and_stops_the_axis_by_friction_alone(gain: float, band: float, error: float) -> None:
    law = _law(gain, band, error)
    assert _law(gain, band, -error) == -law
    if error > band:
        assert law == gain * math.sqrt(error)
        # with k = sqrt(2 F/J), the way that friction F/J = k^2/2 takes to stop from omega_c is the error: (5.5)
        assert law**2 / gain**2 == pytest.approx(error, rel=1e-12)
    else:
        assert law == pytest.approx(gain * error / math.sqrt(band), rel=1e-12)
        assert law <= gain * math.sqrt(error) * (1 + 1e-12)


@given(positive, positive, st.floats(-1e3, 1e3), st.floats(1e-9, 1e3))
def test_position_law_rises_and_nowhere_faster_than_at_the_band(gain: float, band: float, error: float, change: float) -> None:
    step = _law(gain, band, error + change) - _law(gain, band, error)
    rounding = 1e-12 * gain * math.sqrt(abs(error) + change + band)
    assert -rounding <= step <= gain / math.sqrt(band) * change * (1 + 1e-6) + rounding


modes = st.sampled_from([RUN, BRAKE, REST])


@given(modes, st.booleans(), positive, positive, positive, numbers, numbers, numbers)
def test_band_acts_inside_and_settled_only(
    mode: float, brakes: bool, band: float, settled: float, rest: float, error: float, reference_speed: float, speed: float
) -> None:
    new = next_mode(mode, brakes, band, settled, rest, error, reference_speed, speed)
    inside = abs(error) <= band and abs(reference_speed) < settled
    assert (new == RUN) == (not inside)
    if inside and not brakes:
        assert new == REST
    if inside and brakes:
        assert new == (REST if mode == REST or abs(speed) < rest else BRAKE)


def test_band_includes_its_edge_and_a_moving_prefilter_keeps_the_loop_closed() -> None:
    assert next_mode(RUN, False, 2.0, 5.0, 0.0, 2.0, 0.0, 0.0) == REST
    assert next_mode(RUN, False, 2.0, 5.0, 0.0, math.nextafter(2.0, 3.0), 0.0, 0.0) == RUN
    assert next_mode(REST, False, 2.0, 5.0, 0.0, 0.0, 5.0, 0.0) == RUN
    assert next_mode(RUN, True, 2.0, 5.0, 40.0, 0.0, 0.0, 40.0) == BRAKE
    assert next_mode(BRAKE, True, 2.0, 5.0, 40.0, 0.0, 0.0, math.nextafter(40.0, 0.0)) == REST


@given(numbers, numbers, numbers, st.sampled_from([-1.0, 0.0, 1.0]))
def test_eta_is_the_integral_unless_it_pushes_into_the_limit(eta: float, increment: float, motion: float, limited: float) -> None:
    new = next_eta(eta, increment, motion, limited)
    free = eta + (increment - motion)
    if limited == 0.0:
        assert new == free
    else:
        assert new in (eta, free)
        assert limited * (new - eta) <= 0.0


@given(st.floats(allow_nan=False), positive)
def test_limit_is_never_exceeded(drive: float, bound: float) -> None:
    limited, met = limit(drive, bound)
    assert abs(limited) <= bound
    assert met == (0.0 if limited == drive else math.copysign(1.0, drive))
    if abs(drive) <= bound:
        assert limited == drive


@given(st.integers(0, 5), st.integers(0, 2**32 - 1))
def test_difference_equation_is_the_state_space(n: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    a, b, c, gain = (random.standard_normal(shape) for shape in ((n, n), n, n, n))
    d, place, x_place = float(random.standard_normal()), 3, 2
    parameters = np.concatenate([np.zeros(place), a.ravel(), b, c, [d], gain])
    state = np.concatenate([np.zeros(x_place), random.standard_normal(n), np.full(n, np.nan)])
    x = state[x_place : x_place + n].copy()
    eta, excess = random.standard_normal(2)
    assert equation_output(parameters, place, state, x_place, n, eta) == pytest.approx(c @ x + d * eta, abs=1e-12)
    equation_advance(parameters, place, state, x_place, n, eta, excess)
    np.testing.assert_allclose(state[x_place : x_place + n], a @ x + b * eta + gain * excess, atol=1e-12)
    assert not state[:x_place].any()
