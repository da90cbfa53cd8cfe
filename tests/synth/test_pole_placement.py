"""Diophantine solutions by hand and by substitution, and closed loops whose poles are where they
were put."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import gain
from frictool.synth.pole_placement import PlacementVariable, place_poles, polynomial
from frictool.verify.margins import open_loop

PERIOD, LAG = 1e-3, 3e-3


def test_a_solution_known_by_hand() -> None:
    """A = x + 1, B = 1, R = x R': (x + 1) x + (s1 x + s0) = (x + 2)² is R' = 1, S = 3 x + 4."""
    r, s = place_poles(np.array([1.0, 1.0]), np.array([1.0]), np.array([1.0, 4.0, 4.0]), 1)
    assert r == pytest.approx([1.0])
    assert s == pytest.approx([3.0, 4.0])


def test_another_one_with_a_zero() -> None:
    """A = x², B = x + 1, m = 2: x³ (x + r0) + (x + 1)(s2 x² + s1 x + s0) = (x + 1)^4: s0 = 1, s1 =
    3, s2 = 3, r0 = 1."""
    r, s = place_poles(
        np.array([1.0, 0.0, 0.0]), np.array([1.0, 1.0]), np.array([1.0, 4.0, 6.0, 4.0, 1.0]), 2
    )
    assert r == pytest.approx([1.0, 1.0])
    assert s == pytest.approx([3.0, 3.0, 1.0])


@given(seed=st.integers(0, 10_000), n=st.integers(1, 5), more=st.integers(0, 3))
def test_substitution(seed: int, n: int, more: int) -> None:
    random, order = np.random.default_rng(seed), n + more
    a, b = (
        np.append(1.0, random.normal(size=n)),
        np.append(random.normal(size=n - 1), 1.0 + random.random()),
    )
    p = np.append(1.0, random.normal(size=n + order))
    r, s = place_poles(a, b, p, order)
    whole = np.polyadd(np.polymul(np.polymul(a, [1.0, 0.0]), r), np.polymul(b, s))
    scale = max(np.max(np.abs(r)), np.max(np.abs(s)), 1.0)
    assert whole == pytest.approx(p, abs=1e-9 * scale)


def test_a_common_root_is_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        place_poles(np.array([1.0, 1.0]), np.array([0.0]), np.array([1.0, 4.0, 4.0]), 1)
    with pytest.raises(ValueError, match="below the plant's 2"):
        place_poles(np.array([1.0, 0.0, 1.0]), np.array([1.0]), np.ones(4), 1)


@given(
    drive=st.floats(500.0, 1500.0),
    viscous=st.floats(0.0, 60.0),
    frequency=st.floats(10.0, 60.0),
    damping=st.floats(0.5, 0.95),
    ratio=st.floats(3.0, 12.0),
    delay=st.integers(0, 2),
)
def test_the_sampled_loop_has_the_poles_that_were_asked_for(
    drive: float, viscous: float, frequency: float, damping: float, ratio: float, delay: int
) -> None:
    """Rebuilt from the controller's state space with the axis itself; the characteristic
    polynomials agree in x."""
    rates = AxisRates(drive, viscous, 0.0)
    scale = PlacementVariable(50.0, PERIOD)
    a, b = scale.polynomials(open_loop(gain(1.0, PERIOD), rates, LAG, delay))
    pair = frequency * complex(-damping, np.sqrt(1.0 - damping**2))
    poles = [
        scale.pole(s)
        for s in (pair, pair.conjugate(), *[-frequency * ratio] * (len(a) - 1 + 5 - 2 - delay))
    ]
    wanted = polynomial([*poles, *[-1.0 / scale.step] * delay])
    r, s = place_poles(a, b, wanted, 5)
    k = scale.system(s, r)
    assert k.order == 5
    assert k.a[0, 0] == 1.0
    loop = open_loop(k, rates, LAG, delay)
    closed = (loop.a - loop.b @ loop.c - np.eye(loop.order)) / scale.step
    assert np.real(np.poly(closed)) == pytest.approx(
        wanted, rel=1e-5, abs=1e-7 * np.max(np.abs(wanted))
    )


def test_poles_in_the_scaled_variable() -> None:
    """x = (z - 1)/(w0 T) of z = exp(s T), and s/w0 without a period; an integrator is at 0 in
    both."""
    assert PlacementVariable(50.0).pole(-100.0 + 50.0j) == -2.0 + 1.0j
    assert PlacementVariable(50.0, PERIOD).pole(-100.0) == pytest.approx(
        (np.exp(-0.1) - 1.0) / 0.05
    )
    assert PlacementVariable(50.0, PERIOD).pole(0.0) == 0.0
