"""The H-infinity norm against closed forms and slow scans, in both domains."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.plant.lti import Lti, gain, tustin
from frictool.verify.hinf_norm import gains, norm


def gain_at(system: Lti, angle: float) -> float:
    """Largest singular value of c (z - a)^-1 b + d at z = exp(j angle)."""
    return float(gains_at(system, np.array([angle]))[0])


def gains_at(system: Lti, angles: np.ndarray) -> np.ndarray:
    """`gain_at` for each angle."""
    z = np.exp(1j * angles)[:, None, None]
    responses = system.c @ np.linalg.solve(z * np.eye(system.order) - system.a, system.b)
    return np.linalg.norm(responses + system.d, 2, axis=(1, 2))


@given(pole=st.floats(-0.999, 0.999), gain=st.floats(0.01, 100))
@settings(deadline=None)
def test_first_order_closed_form(pole: float, gain: float) -> None:
    a, b, c, d = np.array([[pole]]), np.array([[gain]]), np.array([[1.0]]), np.zeros((1, 1))
    peak, _ = norm(Lti(a, b, c, d, 1.0))
    assert peak == pytest.approx(gain / (1.0 - abs(pole)), rel=2e-6)


@given(seed=st.integers(0, 10_000), n=st.integers(1, 6), m=st.integers(1, 3), p=st.integers(1, 3))
def test_random_systems_against_a_dense_scan(seed: int, n: int, m: int, p: int) -> None:
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n))
    a *= random.uniform(0.3, 0.98) / np.max(np.abs(np.linalg.eigvals(a)))
    b, c, d = random.normal(size=(n, m)), random.normal(size=(p, n)), random.normal(size=(p, m))
    system = Lti(a, b, c, d, 1.0)
    peak, angle = norm(system)
    scan = gains_at(system, np.linspace(0.0, np.pi, 2000)).max()
    assert peak >= scan * (1.0 - 2e-6)
    assert gain_at(system, angle) == pytest.approx(peak, rel=1e-12)


@given(damping=st.floats(1e-4, 0.5), natural=st.floats(1e-3, 1e5), steady=st.floats(1e-3, 1e3))
@settings(deadline=None)
def test_resonance_closed_form(damping: float, natural: float, steady: float) -> None:
    """steady/(s²/w² + 2 z s/w + 1) peaks at w sqrt(1 - 2 z²) with steady/(2 z sqrt(1 - z²))."""
    a = np.array([[0.0, natural], [-natural, -2.0 * damping * natural]])
    peak, at = norm(
        Lti(a, np.array([[0.0], [natural]]), np.array([[steady, 0.0]]), np.zeros((1, 1)), 0.0)
    )
    assert peak == pytest.approx(steady / (2.0 * damping * np.sqrt(1.0 - damping**2)), rel=2e-6)
    assert at == pytest.approx(natural * np.sqrt(1.0 - 2.0 * damping**2), abs=2e-2 * natural)


@given(
    seed=st.integers(0, 10_000),
    n=st.integers(1, 6),
    m=st.integers(1, 3),
    p=st.integers(1, 3),
    spread=st.floats(0.0, 4.0),
)
def test_random_continuous_systems_against_a_dense_scan(
    seed: int, n: int, m: int, p: int, spread: float
) -> None:
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n)) * 10.0 ** random.uniform(-spread, 0.0, size=(n, 1))
    a -= (np.max(np.linalg.eigvals(a).real) + 10.0 ** random.uniform(-3, 0)) * np.eye(n)
    system = Lti(
        a, random.normal(size=(n, m)), random.normal(size=(p, n)), random.normal(size=(p, m)), 0.0
    )
    peak, at = norm(system)
    scan = np.max(gains(system, np.concatenate([[0.0, np.inf], np.geomspace(1e-5, 1e4, 4000)])))
    assert peak >= scan * (1.0 - 2e-6)
    assert gains(system, at)[0] == pytest.approx(peak, rel=1e-12)


@given(seed=st.integers(0, 10_000), n=st.integers(1, 5))
def test_the_bilinear_image_keeps_the_norm(seed: int, n: int) -> None:
    """Tustin maps the imaginary axis onto the unit circle: both domains agree, and tan(w T/2) 2/T
    tells where."""
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n))
    a -= (np.max(np.linalg.eigvals(a).real) + random.uniform(0.05, 1.0)) * np.eye(n)
    system = Lti(a, random.normal(size=(n, 1)), random.normal(size=(1, n)), np.zeros((1, 1)), 0.0)
    assert norm(tustin(system, 0.1))[0] == pytest.approx(norm(system)[0], rel=3e-6)


def test_a_gain_is_its_own_norm() -> None:
    assert norm(gain([[3.0, 4.0]], 0.0))[0] == pytest.approx(5.0)
    assert norm(gain(0.0, 1e-3))[0] == 0.0


def test_largest_at_infinity() -> None:
    high_pass = Lti(
        np.array([[-1.0]]), np.array([[1.0]]), np.array([[-2.0]]), np.array([[2.0]]), 0.0
    )
    peak, at = norm(high_pass)
    assert peak == pytest.approx(2.0)
    assert np.isinf(at)


@pytest.mark.parametrize(("pole", "period"), [(1.01, 1.0), (1.0, 1e-3), (0.1, 0.0), (0.0, 0.0)])
def test_an_unstable_system_has_no_norm(pole: float, period: float) -> None:
    peak, at = norm(Lti(np.array([[pole]]), np.eye(1), np.eye(1), np.zeros((1, 1)), period))
    assert np.isinf(peak)
    assert np.isnan(at)
