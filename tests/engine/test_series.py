"""The pieces of the exact engine against plain references: zeros of polynomials, the matrix
exponential, one step of the integrator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from frictool.engine.dormand_prince import STAGES, dense_output, layer_step
from frictool.engine.drive import EffortFunction, effort
from frictool.engine.polynomial_events import (
    NEVER,
    curvature_bound,
    first_fall,
    value,
    value_and_slope,
)
from frictool.engine.power_series import TERMS, motion, reach
from frictool.friction.kernel_signatures import SLIP_FORCE
from frictool.runtime.kernels import function_pointer
from studies.references.stick_slip import stribeck

coefficients = st.lists(st.floats(-3.0, 3.0).map(lambda c: round(c, 6)), min_size=2, max_size=7)


@given(c=coefficients, h=st.floats(0.1, 2.0))
@settings(max_examples=2 * settings.default.max_examples)
def test_first_fall_is_the_first_real_root(c: list[float], h: float) -> None:
    """Against a dense look: positive before, no longer positive just after; none where the whole
    piece is clearly positive."""
    array = np.array([abs(c[0]) + 0.1, *c[1:]])
    grid = np.linspace(0.0, h, 4001)
    values = np.polynomial.polynomial.polyval(grid, array)
    found = first_fall(array, h)
    if found == NEVER:
        assert np.all(values > -1e-9)
    else:
        assert abs(value(array, found)) < 1e-12 * np.sum(np.abs(array) * h ** np.arange(array.size))
        assert np.all(values[grid < found] > -1e-9)


@given(roots=st.lists(st.floats(0.05, 0.95), min_size=1, max_size=4, unique=True))
def test_first_fall_of_a_product(roots: list[float]) -> None:
    c = np.polynomial.polynomial.polyfromroots(roots)
    c *= math.copysign(1.0, c[0])
    assert first_fall(c, 1.0) == pytest.approx(min(roots), abs=1e-6)


def test_a_zero_at_the_start_is_left_or_fallen_from() -> None:
    assert first_fall(np.array([0.0, 0.0, 1.0, -1.0]), 2.0) == pytest.approx(1.0, rel=1e-15)
    assert first_fall(np.array([0.0, 0.0, 1.0, -1.0]), 0.5) == NEVER
    assert first_fall(np.array([0.0, -1e-30, 1.0]), 0.5) == 0.0
    assert first_fall(np.zeros(4), 1.0) == NEVER
    assert first_fall(np.array([-1.0, 2.0]), 1.0) == 0.0
    assert first_fall(np.array([1.0, -2.0]), 0.0) == NEVER


@given(c=coefficients, h=st.floats(0.1, 2.0))
def test_slope_and_curvature_bound(c: list[float], h: float) -> None:
    array, p = np.array(c), np.polynomial.Polynomial(c)
    assert value_and_slope(array, h) == pytest.approx((p(h), p.deriv()(h)), rel=1e-12, abs=1e-9)
    assert (
        np.max(np.abs(p.deriv(2)(np.linspace(0.0, h, 100))))
        <= curvature_bound(array, h) * (1.0 + 1e-12) + 1e-12
    )


drives = st.builds(
    EffortFunction,
    offset=st.floats(-2.0, 2.0),
    slope=st.floats(-1.0, 1.0),
    amplitude=st.floats(0.0, 3.0),
    frequency=st.floats(0.0, 50.0),
    phase=st.floats(0.0, 6.0),
    proportional=st.floats(0.0, 100.0),
    derivative=st.floats(0.0, 10.0),
    integral=st.floats(0.0, 10.0),
    target=st.floats(-1.0, 1.0),
    target_speed=st.floats(-0.2, 0.2),
)


@given(
    drive=drives,
    mass=st.floats(0.1, 10.0),
    viscous=st.floats(0.0, 50.0),
    v=st.floats(-2.0, 2.0),
    t=st.floats(0.0, 10.0),
)
@settings(max_examples=2 * settings.default.max_examples)
def test_the_series_is_the_matrix_exponential(
    drive: EffortFunction, mass: float, viscous: float, v: float, t: float
) -> None:
    """State (x, v, q, A sin, A cos, 1, t) of the augmented linear system, on the whole length that
    `reach` promises."""
    piece, array, friction = np.zeros((4, TERMS)), drive.as_array(), 0.7
    y = np.array([0.3, v, -0.2])
    start = (effort(t, *y, array) - friction - viscous * v) / mass
    motion(y, t, array, mass, viscous, True, start, piece)
    h = min(reach(piece[1]), 10.0)
    assert h > 0.0
    a = np.zeros((7, 7))
    a[0, 1] = 1.0
    constant = drive.offset - friction + drive.proportional * drive.target
    a[1] = np.array([
        -drive.proportional, -drive.derivative - viscous, -drive.integral, 1.0, 0.0, constant,
        drive.slope + drive.proportional * drive.target_speed,
    ]) / mass  # fmt: skip
    a[2, [0, 5, 6]] = 1.0, -drive.target, -drive.target_speed
    a[3, 4], a[4, 3], a[6, 5] = drive.frequency, -drive.frequency, 1.0
    cycle = drive.frequency * t + drive.phase
    begin = np.array(
        [*y, drive.amplitude * math.sin(cycle), drive.amplitude * math.cos(cycle), 1.0, t]
    )
    end = expm(a * h) @ begin
    size = np.max(np.abs(begin)) + np.max(np.abs(end[:3])) + abs(start) * h
    np.testing.assert_allclose(
        [value(piece[row], h) for row in range(3)],
        end[:3],
        rtol=0.0,
        atol=1e-11 * size * (1.0 + h) ** 2,
    )
    assert value(piece[3], h) == pytest.approx(
        effort(t + h, *end[:3], array), rel=1e-8, abs=1e-8 * size
    )


def test_reach_of_polynomials_is_endless() -> None:
    assert reach(np.array([1.0, 2.0] + [0.0] * (TERMS - 2))) == math.inf
    assert reach(np.zeros(TERMS)) == math.inf


def test_a_step_in_the_layer_is_of_order_five_and_its_output_of_order_four() -> None:
    drive, law = (
        EffortFunction(slope=1.0, offset=1.6, proportional=2.0, derivative=0.5, integral=0.3),
        np.array([1.0, 1.5, 1e-3, 2.0, 0.4]),
    )
    y, array, force = (
        np.array([0.0, 1e-3, 0.1]),
        EffortFunction(1.6, 1.0, 0.0, 0.0, 0.0, 2.0, 0.5, 0.3).as_array(),
        function_pointer(stribeck, SLIP_FORCE),
    )

    def field(t: float, now: np.ndarray) -> list[float]:
        return [now[1], effort(t, *now, array) - stribeck(now[1], 1.0, law), now[0]]

    start, errors, inside, estimates = field(0.0, y)[1], [], [], []
    for h in (8e-4, 4e-4):
        slopes, piece = np.empty((3, STAGES)), np.zeros((3, 5))
        estimates.append(layer_step(force, law, 1.0, 1.0, array, 0.0, h, start, y, slopes))
        dense_output(y, slopes, h, piece)
        exact = solve_ivp(
            field, (0.0, h), y, method="DOP853", rtol=1e-13, atol=1e-18, t_eval=[0.4 * h, h]
        ).y[1]
        inside.append(abs(value(piece[1], 0.4 * h) - exact[0]))
        errors.append(abs(value(piece[1], h) - exact[1]))
    assert drive.as_array().tolist() == array.tolist()
    assert errors[0] > 40.0 * errors[1]  # 2^6
    assert inside[0] > 20.0 * inside[1]  # 2^5
    assert estimates[0] > errors[0]
