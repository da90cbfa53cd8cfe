"""The H-infinity norm against closed forms and a slow scan of the unit circle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.verify.norms import gain_at, peak_gain


@given(pole=st.floats(-0.999, 0.999), gain=st.floats(0.01, 100))
@settings(deadline=None)
def test_first_order_closed_form(pole: float, gain: float) -> None:
    a, b, c, d = np.array([[pole]]), np.array([[gain]]), np.array([[1.0]]), np.zeros((1, 1))
    peak, _ = peak_gain(a, b, c, d)
    assert peak == pytest.approx(gain / (1.0 - abs(pole)), rel=2e-6)


@given(seed=st.integers(0, 10_000), n=st.integers(1, 6), m=st.integers(1, 3), p=st.integers(1, 3))
@settings(max_examples=60, deadline=None)
def test_random_systems_against_a_dense_scan(seed: int, n: int, m: int, p: int) -> None:
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n))
    a *= random.uniform(0.3, 0.98) / np.max(np.abs(np.linalg.eigvals(a)))
    b, c, d = random.normal(size=(n, m)), random.normal(size=(p, n)), random.normal(size=(p, m))
    peak, angle = peak_gain(a, b, c, d)
    scan = max(gain_at(a, b, c, d, x) for x in np.linspace(0.0, np.pi, 2000))
    assert peak >= scan * (1.0 - 2e-6)
    assert gain_at(a, b, c, d, angle) == pytest.approx(peak, rel=1e-12)


def test_an_unstable_system_has_no_norm() -> None:
    peak, _ = peak_gain(np.array([[1.01]]), np.eye(1), np.eye(1), np.zeros((1, 1)))
    assert np.isinf(peak)
