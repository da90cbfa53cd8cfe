"""Kernels of the margin: matrices that the block diagrams give, and the peak of a known loop."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti, delay
from frictool.verify.feedback_loops import DIFFERENCE, ETA, SPEED, feedbacks_of, measured_axis
from frictool.verify.hinf_norm import gains
from frictool.verify.margin_kernels import UNKNOWN, exponential, peak, sampled_axis, sensitivity
from frictool.verify.plant_margins import SIGNALS
from studies.rigs.step_scenario import controller

PERIOD = 1e-3
GRID = np.append(0.0, np.geomspace(1e-6 * np.pi, np.pi, 120))
rates = st.tuples(st.floats(1.0, 1e5), st.just(0.0) | st.floats(1e-6, 1e4))
lags = st.just(0.0) | st.floats(1e-5, 1.0)


@given(st.integers(1, 6), st.integers(0, 1000), st.floats(1e-6, 3.0))
def test_the_exponential_is_that_of_scipy(size: int, seed: int, scale: float) -> None:
    matrix = scale * np.random.default_rng(seed).standard_normal((size, size))
    expected = expm(matrix)
    np.testing.assert_allclose(
        exponential(matrix), expected, rtol=0.0, atol=1e-12 * np.abs(expected).max()
    )


@pytest.mark.parametrize("sees", [(ETA,), (DIFFERENCE,), (SPEED,), (DIFFERENCE, ETA), (SPEED, ETA)])
@given(rates=rates, lag=lags)
def test_the_axis_is_that_of_the_diagram(
    sees: tuple[str, ...], rates: tuple[float, float], lag: float
) -> None:
    drive, viscous = rates
    axis = measured_axis(AxisRates(drive, viscous, 0.0), lag, PERIOD, sees).system
    a, b, rows = sampled_axis(
        drive, viscous, lag, PERIOD, np.array([SIGNALS[name] for name in sees])
    )
    for mine, theirs in ((a, axis.a), (b, axis.b[:, 0]), (rows, axis.c[1:])):
        scale = np.abs(theirs).max()
        np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-13 * scale)


@given(rates=rates, lag=lags, samples=st.integers(0, 3))
def test_the_loop_responds_as_its_parts_do(
    rates: tuple[float, float], lag: float, samples: int
) -> None:
    """1/(1 + L) from the responses of controller, delay and axis."""
    (loop,) = feedbacks_of(controller())
    c = loop.system
    sees = np.array([SIGNALS[name] for name in loop.sees])
    axis = sampled_axis(*rates, lag, PERIOD, sees)
    a, b, rows = sensitivity((c.a, c.b, c.c, c.d), samples, axis)
    closed = Lti(a, b[:, None], rows[None, :], np.eye(1), PERIOD)
    seen = Lti(axis[0], axis[1][:, None], axis[2], np.zeros((len(sees), 1)), PERIOD)
    frequencies = np.geomspace(1.0, 0.99 * math.pi / PERIOD, 20)
    returned = c.response(frequencies) @ seen.response(frequencies)
    open_loop = -(returned * delay(samples, PERIOD).response(frequencies))[:, 0, 0]
    np.testing.assert_allclose(gains(closed, frequencies), 1.0 / np.abs(1.0 + open_loop), rtol=1e-6)


def test_the_peak_of_one_resonance_is_its_closed_form() -> None:
    """1 + b/(z - p) with a pole pair near the circle, on a fine grid."""
    radius, angle = 0.98, 0.3
    a = radius * np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    loop = (a, np.array([0.1, 0.0]), np.array([0.0, 1.0]))
    poles, vectors = np.linalg.eig(a)
    found = peak(loop, poles, vectors, GRID)
    closed = Lti(a, loop[1][:, None], loop[2][None, :], np.eye(1), 1.0)
    fine = gains(closed, np.linspace(0.25, 0.35, 200_001)).max()
    assert found == pytest.approx(fine, rel=1e-7)


def test_modes_that_are_no_basis_are_not_used() -> None:
    a = np.array([[0.5, 1.0], [0.0, 0.5]])
    loop = (a, np.array([0.0, 1.0]), np.array([1.0, 0.0]))
    vectors = np.array([[1.0, -1.0], [0.0, 0.0]], dtype=complex)
    assert peak(loop, np.array([0.5, 0.5], dtype=complex), vectors, GRID) == UNKNOWN
