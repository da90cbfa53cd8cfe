"""Taylor forms hold the exact value, in fractions, whatever the roundings of their arithmetic."""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.verify.taylor_forms import (
    below_level,
    corner_above,
    inverse,
    minus,
    plus,
    power,
    scaled,
    shifted,
    times,
)

Exact = tuple[Fraction, Fraction]  # real and imaginary part
ENDS = tuple(itertools.product((-1, 1), repeat=3))


def _exact(z: complex) -> Exact:
    return Fraction(z.real), Fraction(z.imag)


def _add(x: Exact, y: Exact) -> Exact:
    return x[0] + y[0], x[1] + y[1]


def _multiply(x: Exact, y: Exact) -> Exact:
    return x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]


def _square(x: Exact) -> Fraction:
    return x[0] ** 2 + x[1] ** 2


def _invert(x: Exact) -> Exact:
    return x[0] / _square(x), -x[1] / _square(x)


def _at(form: Any, e: tuple[int, ...]) -> Exact:
    value = _exact(form[0])
    for part, weight in zip(form[1:4], e, strict=True):
        value = _add(value, (weight * Fraction(part.real), weight * Fraction(part.imag)))
    return value


def _holds(form: Any, e: tuple[int, ...], value: Exact) -> bool:
    at = _at(form, e)
    return _square((at[0] - value[0], at[1] - value[1])) <= Fraction(form[4]) ** 2


def _form(random: np.random.Generator, spread: float) -> tuple[Any, Any]:
    """A form, and a function that it holds: with an error of the full radius at each corner."""
    size = 10.0 ** random.uniform(-8, 8)
    parts = [complex(*random.normal(size=2)) * size * w for w in (1.0, spread, spread, spread)]
    radius = float(abs(random.normal()) * size * spread * 10.0 ** random.uniform(-16, 0))
    form = (*parts, radius)
    angles = random.uniform(0, 2 * np.pi, len(ENDS))

    def function(e: tuple[int, ...]) -> Exact:
        angle = angles[ENDS.index(e)]
        error = 0.999999 * radius * complex(np.cos(angle), np.sin(angle))
        return _add(_at(form, e), _exact(error))

    return form, function


@given(seed=st.integers(0, 10**6), spread=st.sampled_from([0.0, 1e-17, 1e-9, 1e-3, 0.1]))
def test_sums_products_powers_and_inverses_hold_the_exact_value(seed: int, spread: float) -> None:
    random = np.random.default_rng(seed)
    (x, f), (y, g) = _form(random, spread), _form(random, spread)
    number = float(random.normal())
    third = 1.0 / 3.0
    for e in ENDS:
        a, b = f(e), g(e)
        assert _holds(plus(x, y), e, _add(a, b))
        assert _holds(minus(x, y), e, (a[0] - b[0], a[1] - b[1]))
        assert _holds(times(x, y), e, _multiply(a, b))
        assert _holds(scaled(x, number), e, _multiply(a, (Fraction(number), Fraction(0))))
        assert _holds(scaled(x, third), e, (a[0] / 3, a[1] / 3))
        assert _holds(power(x, 3), e, _multiply(a, _multiply(a, a)))
        over = inverse(x)
        if np.isfinite(over[4]):
            assert _holds(over, e, _invert(a))
    if spread <= 1e-3 and abs(x[0]) > 10 * sum(map(abs, x[1:4])) + 10 * x[4]:
        assert np.isfinite(inverse(x)[4])


def test_cancellation_is_held() -> None:
    x, y = (1.0 + 1e-16j, 0j, 0j, 0j, 0.0), (0.1 + 0j, 0j, 0j, 0j, 0.0)
    ten = power(plus(x, y), 9)
    difference = minus(times(ten, plus(x, y)), power(plus(x, y), 10))
    assert abs(difference[0]) <= difference[4] < 1e-13
    tenth = _exact(0.1)
    true, one = (Fraction(1), Fraction(0)), _add(_exact(x[0]), tenth)
    for _ in range(9):
        true = _multiply(true, one)
    assert _holds(ten, (1, 1, 1), true)


def test_what_may_be_zero_has_no_inverse() -> None:
    for parts in ((1.0, 1.0, 0.0, 0.0), (1.0, 0.5, 0.25, 0.25), (0.0, 0.0, 0.0, 0.0)):
        assert inverse((*map(complex, parts), 0.0))[4] == np.inf
    assert inverse((1.0 + 0j, 0.5j, 0j, 0j, 0.5))[4] == np.inf
    assert inverse((1.0 + 0j, 0j, 0j, 0j, np.nan))[4] == np.inf


@given(seed=st.integers(0, 10**6), order=st.integers(0, 14))
def test_a_polynomial_on_an_interval_is_held(seed: int, order: int) -> None:
    random = np.random.default_rng(seed)
    real = random.normal(size=order + 1) * 10.0 ** random.uniform(-9, 3, order + 1)
    coefficients = np.array([x * (1, 1j, -1, -1j)[j % 4] for j, x in enumerate(real)], complex)
    middle, half = float(random.uniform(0, 1)), float(10.0 ** random.uniform(-12, -0.5))
    c, t, r = shifted(coefficients, middle, half, np.zeros(order + 1, complex))
    for e in (-1, Fraction(-1, 3), 0, Fraction(2, 7), 1):
        at = Fraction(middle) + e * Fraction(half)
        value: Exact = (Fraction(0), Fraction(0))
        for coefficient in coefficients[::-1]:
            value = _add(_multiply(value, (at, Fraction(0))), _exact(coefficient))
        model = _add(_exact(c), (e * Fraction(t.real), e * Fraction(t.imag)))
        assert _square((model[0] - value[0], model[1] - value[1])) <= Fraction(r) ** 2


def _exactly_below(matrix: Any, level: float) -> bool:
    """Return True if level^2 - T* T is positive definite, by elimination in fractions."""
    rows = [[_exact(value) for value in row] for row in matrix]
    n = len(rows[0])
    gram = [[(Fraction(0), Fraction(0))] * n for _ in range(n)]
    for i, j in itertools.product(range(n), repeat=2):
        total = (Fraction(level) ** 2 if i == j else Fraction(0), Fraction(0))
        for row in rows:
            product = _multiply((row[i][0], -row[i][1]), row[j])
            total = (total[0] - product[0], total[1] - product[1])
        gram[i][j] = total
    for k in range(n):
        if gram[k][k][0] <= 0:
            return False
        for i in range(k + 1, n):
            factor = _multiply(gram[i][k], _invert(gram[k][k]))
            for j in range(k, n):
                product = _multiply(factor, gram[k][j])
                gram[i][j] = (gram[i][j][0] - product[0], gram[i][j][1] - product[1])
    return True


@given(seed=st.integers(0, 10**6), distance=st.sampled_from([0.0, 1e-16, 3e-16, 1e-15, 1e-12]))
def test_no_matrix_above_a_level_passes(seed: int, distance: float) -> None:
    """At distances of some roundings the answer may be no, but a yes is exactly true."""
    random = np.random.default_rng(seed)
    z, w = random.integers(1, 5), random.integers(1, 4)
    parts = np.zeros((4, z, w), complex)
    scale = 10.0 ** random.uniform(-3, 3)
    parts[0] = scale * (random.normal(size=(z, w)) + 1j * random.normal(size=(z, w)))
    norm = float(np.linalg.norm(parts[0], 2))
    gram = np.zeros((w, w), complex)
    for level in (norm * (1.0 - distance), norm * (1.0 + distance)):
        if below_level(parts, (0.0, 0.0, 0.0), level, gram):
            assert _exactly_below(parts[0], level)
        if corner_above(parts, 0.0, level, gram) < 0:
            assert _exactly_below(parts[0], level)
    assert below_level(parts, (0.0, 0.0, 0.0), norm * (1.0 + 1e-9), gram)


@given(seed=st.integers(0, 10**6))
def test_a_family_is_below_a_level_only_if_its_members_are(seed: int) -> None:
    random = np.random.default_rng(seed)
    parts = random.normal(size=(4, 4, 3)) + 1j * random.normal(size=(4, 4, 3))
    parts[1:] *= 0.2
    worst = max(np.linalg.norm(parts[0] + np.tensordot(e, parts[1:], 1), 2) for e in np.array(ENDS))
    gram = np.zeros((3, 3), complex)
    assert corner_above(parts, 0.0, 1.000001 * worst, gram) < 0
    assert corner_above(parts, 0.01 * worst, 1.010001 * worst, gram) < 0
    assert corner_above(parts, 0.01 * worst, 1.009 * worst, gram) >= 0
    corner = corner_above(parts, 0.0, 0.999999 * worst, gram)
    at = [1.0 if corner >> bit & 1 else -1.0 for bit in range(3)]
    assert np.linalg.norm(parts[0] + np.tensordot(at, parts[1:], 1), 2) > 0.999 * worst


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_what_is_no_number_proves_nothing(wrong: float) -> None:
    parts, gram = np.zeros((4, 2, 2), complex), np.zeros((2, 2), complex)
    assert corner_above(parts, 0.0, 1.0, gram) < 0
    assert corner_above(parts, wrong, 1.0, gram) >= 0
    parts[0, 1, 0] = wrong
    assert corner_above(parts, 0.0, 1.0, gram) >= 0
