"""Integers that enclose numbers: products, exponential series and the sampled axis against
fractions and floating-point matrices."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.verify.enclosed_axis import LARGEST, EnclosedAxis, corners, cubic, exponential_series
from frictool.verify.interval_arithmetic import ONE, Enclosure

numbers = st.fractions(-1000, 1000, max_denominator=10**6)


def _holds(enclosure: Enclosure, value: Fraction) -> bool:
    return bool(abs(value * ONE - enclosure.centre) <= enclosure.radius)


@given(x=numbers, y=numbers, z=numbers)
def test_sums_and_products_hold_the_exact_value(x: Fraction, y: Fraction, z: Fraction) -> None:
    a, b, c = map(Enclosure.of, (x, y, z))
    assert _holds(a * b + c, x * y + z)
    assert _holds((a - b) * (c - a) * b, (x - y) * (z - x) * y)


@given(x=st.floats(-1e6, 1e6).filter(lambda v: v == 0.0 or abs(v) > 2.0**-43))
def test_a_double_is_exact(x: float) -> None:
    found = Enclosure.of(x)
    assert (Fraction(found.centre, ONE), found.radius) == (Fraction(x), 0)


@given(seed=st.integers(0, 10**6), wide=st.integers(0, 2**80))
@settings(max_examples=30)
def test_a_matrix_product_holds_the_product_of_anything_inside(seed: int, wide: int) -> None:
    random = np.random.default_rng(seed)
    a, b = (Enclosure.matrix(random.normal(size=(3, 3))).widened(wide) for _ in range(2))
    found = a @ b
    for sign in (-1, 1):
        inside = (a.centre + sign * a.radius) @ (b.centre - sign * b.radius)
        for true, centre, radius in zip(
            inside.ravel(), found.centre.ravel(), found.radius.ravel(), strict=True
        ):
            assert abs(true - centre * ONE) <= radius * ONE


@given(
    q=st.integers(0, 2),
    ratio=st.fractions(0, 3, max_denominator=50),
    sigma=st.fractions(-2, 3, max_denominator=50),
)
@settings(max_examples=60, deadline=None)
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
        found = series(order, sigma)
        assert abs(plain * ONE - found.centre) <= found.radius + Fraction(
            ONE, 10**18
        )  # what 45 terms leave out
        assert found.radius < 2**20


@given(
    q=st.integers(0, 2),
    ratio=st.fractions(0, 4, max_denominator=20),
    low=st.fractions(-1, 2, max_denominator=100),
    width=st.fractions(0, 1, max_denominator=100),
    place=st.fractions(0, 1, max_denominator=30),
)
@settings(max_examples=60, deadline=None)
def test_the_function_is_within_the_bernstein_form(
    q: int, ratio: Fraction, low: Fraction, width: Fraction, place: Fraction
) -> None:
    points, sigma = cubic(q, ratio, low, low + width), low + place * width
    weights = [math.comb(3, i) * place**i * (1 - place) ** (3 - i) for i in range(4)]
    centre = sum(w * p.centre for w, p in zip(weights, points, strict=True))
    room = max(p.radius for p in points)
    true = exponential_series(q, ratio, math.ceil(max(abs(low), abs(low + width))))(0, sigma)
    assert abs(true.centre - centre) <= room + true.radius


def _coefficients(axis: EnclosedAxis) -> list[Enclosure]:
    return [
        axis.kept_speed, axis.speed_from_command, axis.speed_from_friction, axis.eta_from_speed,
        axis.eta_from_command,
        axis.eta_from_friction,
    ]  # fmt: skip


@given(
    lag=st.sampled_from([0.0, 3e-4, 3e-3]),
    k=st.floats(1, 2000),
    k_width=st.floats(0, 500),
    s=st.floats(-20, 300),
    s_width=st.floats(0, 50),
    places=st.tuples(st.floats(0, 1), st.floats(0, 1)),
)
@settings(max_examples=60, deadline=None)
def test_every_plant_of_a_rectangle_lies_between_the_corners(
    lag: float, k: float, k_width: float, s: float, s_width: float, places: tuple[float, float]
) -> None:
    t = 1e-3
    x, y = places
    friction = (0.3 * k, 0.3 * (k + k_width))
    found = corners(
        (Fraction(k), Fraction(k + k_width)),
        (Fraction(s), Fraction(s + s_width)),
        tuple(map(Fraction, friction)),
        lag,
        t,
    )
    bernstein = [math.comb(3, i) * y**i * (1 - y) ** (3 - i) for i in range(4)]
    weights = [a * b for a in (1.0 - x, x) for b in bernstein]
    here = AxisRates(
        k + x * k_width, s + y * s_width, friction[0] + x * (friction[1] - friction[0])
    )
    plant, o = linear_axis(here, lag, t).system, int(lag > 0.0)
    true = [
        plant.a[o, o],
        plant.b[o, 0],
        plant.b[o, 2],
        plant.a[o + 1, o],
        plant.b[o + 1, 0],
        plant.b[o + 1, 2],
    ]
    for index, value in enumerate(true):
        points = [_coefficients(axis)[index] for axis in found]
        centre = sum(w * p.centre for w, p in zip(weights, points, strict=True)) / ONE
        room = max(p.radius for p in points) / ONE
        assert abs(value - centre) <= room + 1e-12 * (
            1.0 + abs(value)
        )  # of the floating-point reference
        assert room <= 1e-3 * max(1e-9, max(abs(p.centre) for p in points) / ONE)


def test_a_lag_that_is_no_lag_is_refused() -> None:
    one = (Fraction(1), Fraction(2))
    with pytest.raises(
        NoSolutionError, match=f"loop_time_constant_s is below 1/{LARGEST} of the sample period"
    ):
        corners(one, one, one, 1e-5, 1e-3)
    with pytest.raises(NoSolutionError, match="inertia/viscous is below"):
        corners(one, (Fraction(0), Fraction(10**6)), one, 0.0, 1e-3)
