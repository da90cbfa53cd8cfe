"""The sampled axis's exponentials, enclosed: series, polynomials and axis against fractions and
floating-point matrices."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.verify.exponential_enclosure import (
    LARGEST,
    check_range,
    exponential_series,
    hold_polynomials,
)


@given(
    q=st.integers(0, 2),
    ratio=st.fractions(0, 3, max_denominator=50),
    sigma=st.fractions(-2, 3, max_denominator=50),
)
@settings(deadline=None)
def test_the_series_against_its_plain_double_sum(q: int, ratio: Fraction, sigma: Fraction) -> None:
    series = exponential_series(q, ratio, math.ceil(abs(sigma)))
    terms = [
        (
            m,
            sum((-ratio) ** n / Fraction(math.factorial(m + n + q)) for n in range(45)),
            Fraction(math.factorial(m)),
        )
        for m in range(48)
    ]
    for order in range(4):
        plain = sum(
            (-1) ** m * weight * sigma ** (m - order) * whole / math.factorial(m - order)
            for m, weight, whole in terms
            if m >= order
        )
        centre, radius = series(order, sigma)
        # what 45 terms leave out
        assert abs(plain - centre) <= radius + Fraction(1, 10**18)
        assert radius < Fraction(1, 2**76)


@given(
    ratio=st.fractions(0, 4, max_denominator=20),
    low=st.fractions(-1, 2, max_denominator=100),
    width=st.fractions(0, 1, max_denominator=100),
    place=st.fractions(0, 1, max_denominator=30),
)
@settings(deadline=None)
def test_the_functions_are_within_the_errors_of_the_polynomials(
    ratio: Fraction, low: Fraction, width: Fraction, place: Fraction
) -> None:
    holds = hold_polynomials(ratio, low, low + width)
    sigma = low + place * width
    largest = math.ceil(max(abs(low), abs(low + width)))
    pairs = ((1, Fraction(0)), (2, Fraction(0)), (1, ratio), (2, ratio))
    for (q, lag), row, error in zip(pairs, holds.coefficients, holds.errors, strict=True):
        true, radius = exponential_series(q, lag, largest)(0, sigma)
        value = sum(c * (sigma - holds.middle) ** k for k, c in enumerate(row))
        assert abs(true - value) <= error + radius
        assert error < 3e-16 * (1 if low >= 0 else 3)
    assert abs(math.exp(-ratio) - holds.kept) < 1e-15
    assert holds.kept_error < Fraction(1, 2**90)


@given(
    lag=st.sampled_from([0.0, 3e-4, 3e-3]),
    k=st.floats(1, 2000),
    s=st.floats(-20, 300),
    width=st.floats(0, 50),
    place=st.floats(0, 1),
)
@settings(deadline=None)
def test_the_sampled_axis_follows_from_the_functions(
    lag: float, k: float, s: float, width: float, place: float
) -> None:
    t, f = 1e-3, 0.3 * k
    ratio = Fraction(t) / Fraction(lag) if lag else Fraction(0)
    holds = hold_polynomials(ratio, Fraction(s) * Fraction(t), Fraction(s + width) * Fraction(t))
    sigma = (s + place * width) * t
    h_1, h_2, a, b = (
        sum(float(c) * (sigma - float(holds.middle)) ** j for j, c in enumerate(row))
        for row in holds.coefficients
    )
    plant, o = linear_axis(AxisRates(k, sigma / t, f), lag, t).system, int(lag > 0.0)
    if not lag:
        a = b = 0.0
    expected = {
        (o, o): 1.0 - sigma * h_1,
        (o + 1, o): -t * h_1,
    }
    for (row, column), value in expected.items():
        assert plant.a[row, column] == pytest.approx(value, rel=1e-9, abs=1e-15)
    assert plant.b[o, [0, 2]] == pytest.approx([k * t * (h_1 - a), -f * t * h_1], rel=1e-9)
    assert plant.b[o + 1, [0, 2]] == pytest.approx(
        [-k * t**2 * (h_2 - b), f * t**2 * h_2], rel=1e-9
    )
    if lag:
        assert plant.a[[1, 2], 0] == pytest.approx([k * t * a, -k * t**2 * b], rel=1e-9)
        assert plant.a[0, 0] == pytest.approx(float(holds.kept), rel=1e-12)


def test_a_lag_that_is_no_lag_is_refused() -> None:
    with pytest.raises(
        NoSolutionError, match=f"loop_time_constant_s is below 1/{LARGEST} of the sample period"
    ):
        check_range(Fraction(100), Fraction(0), Fraction(1))
    with pytest.raises(NoSolutionError, match="inertia/viscous is below"):
        check_range(Fraction(0), Fraction(0), Fraction(1000))
