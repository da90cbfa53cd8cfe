"""Roots of functions with known values."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from frictool.plant.root_search import sign_change


@given(st.floats(1e-6, 1e6), st.floats(0.1, 9.0), st.sampled_from([-1.0, 1.0]))
def test_a_root_of_a_power_is_exact_to_its_tolerance(
    root: float, exponent: float, sign: float
) -> None:
    found = sign_change(lambda x: sign * ((x / root) ** exponent - 1.0), 0.0, 1e7)
    assert found == pytest.approx(root, rel=1e-12)


@given(st.floats(0.1, 3.0))
def test_a_root_agrees_with_brentq(level: float) -> None:
    def value(x: float) -> float:
        return math.sinh(x) - level

    assert sign_change(value, 0.0, 5.0) == pytest.approx(brentq(value, 0.0, 5.0), rel=1e-11)


def test_an_end_is_returned_if_the_function_is_zero_there_or_nowhere() -> None:
    assert sign_change(lambda x: x, 0.0, 1.0) == 0.0
    assert sign_change(lambda x: x - 1.0, 0.0, 1.0) == 1.0
    assert sign_change(lambda x: x + 1.0, 0.0, 1.0) == 1.0
