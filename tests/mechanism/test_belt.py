"""The belt of thesis 2.1.5: its transfer as it follows from the free bodies, and the limits (2.8),
(2.9)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.plant.mechanism.linearisation import linearise
from frictool.typing import ComplexVector
from tests.support.belt_reference import Belt, belt
from tests.support.mechanism_motion import moved

INERTIA = st.floats(1e-5, 1e-1)


def response(assembled, s: ComplexVector) -> ComplexVector:
    """theta_B/u of the linearised mechanism."""
    found = linearise(assembled).transfer("torque", "out")
    return np.array(
        [
            (found.c @ np.linalg.solve(one * np.eye(len(found.a)) - found.a, found.b))[0, 0]
            for one in s
        ]
    )


def resonance(one: Belt) -> float:
    """rad/s"""
    return math.sqrt(
        one.stiffness * (one.inertia_a + one.inertia_b) / (one.inertia_a * one.inertia_b)
    )


@given(INERTIA, INERTIA, st.floats(1.0, 1e5), st.floats(1e-3, 1.0))
def test_the_transfer_follows_from_the_free_bodies(
    a: float, b: float, k: float, damping: float
) -> None:
    by_hand = Belt(a, b, k, damping * math.sqrt(k * a * b / (a + b)))
    s = 1j * resonance(by_hand) * np.geomspace(0.01, 10.0, 15)
    np.testing.assert_allclose(
        response(belt(a, b, k, by_hand.damping), s), by_hand.transfer(s), rtol=1e-7
    )


@given(INERTIA, INERTIA, st.floats(1.0, 1e5))
def test_without_damping_it_is_2_8(a: float, b: float, k: float) -> None:
    by_hand = Belt(a, b, k, 0.0)
    s = 1j * resonance(by_hand) * np.array([0.01, 0.1, 0.5, 0.9, 1.1, 2.0, 10.0])
    np.testing.assert_allclose(response(belt(a, b, k, 0.0), s), by_hand.undamped(s), rtol=1e-6)


@given(INERTIA, INERTIA, st.floats(0.01, 0.1))
def test_a_stiff_belt_is_2_9_to_the_square_of_the_frequency_over_its_resonance(
    a: float, b: float, share: float
) -> None:
    by_hand = Belt(a, b, 1e4, 0.0)
    s = np.array([1j * share * resonance(by_hand)])
    error = response(belt(a, b, 1e4, 0.0), s) / by_hand.rigid(s) - 1.0
    np.testing.assert_allclose(error.real, share**2 / (1.0 - share**2), rtol=1e-4)


@given(INERTIA, INERTIA, st.floats(1e3, 1e6), st.floats(0.005, 0.1), st.floats(0.005, 0.1))
def test_radii_and_stiffness_along_the_belt_come_in_as_the_lever_has_it(
    a: float, b: float, k: float, first: float, second: float
) -> None:
    """Seen from B, A has inertia (r_B/r_A)^2 J_A and the torque is r_B/r_A u; the belt has k
    r_B^2."""
    c = 0.1 * math.sqrt(k * a * b / (a * second**2 + b * first**2))
    lever = second / first
    by_hand = Belt(a * lever**2, b, k * second**2, c * second**2)
    s = 1j * resonance(by_hand) * np.geomspace(0.01, 30.0, 9)
    np.testing.assert_allclose(
        response(belt(a, b, k, c, first, second), s), lever * by_hand.transfer(s), rtol=1e-6
    )


@given(INERTIA, INERTIA, st.floats(1.0, 1e5), st.just(0.0) | st.floats(1e-3, 0.9))
@settings(max_examples=20)
def test_the_engine_answers_a_step_as_the_belt_does(
    a: float, b: float, k: float, damping: float
) -> None:
    """From well within the oscillation's period to some of them."""
    fast = resonance(Belt(a, b, k, 0.0))
    by_hand = Belt(a, b, k, 2.0 * damping * k / fast)
    found = moved(belt(a, b, k, by_hand.damping), [[1.0]] * 60, 0.3 / fast)
    np.testing.assert_allclose(
        found.position("b"), by_hand.step(found.time), atol=1e-7 * by_hand.step(found.time).max()
    )


@pytest.mark.parametrize("share", [0.2, 0.8, 1.0, 1.3, 4.0])
def test_a_torque_that_swings_is_answered_with_the_transfers_gain_and_phase(share: float) -> None:
    """128 samples a period, held: their fundamental. Whatever starts at rest beside the steady
    swing, the damping takes away."""
    by_hand = Belt(1e-3, 2e-3, 500.0, 0.2)
    swing, samples, periods = share * resonance(by_hand), 128, 60
    period = 2.0 * math.pi / swing / samples
    found = moved(
        belt(1e-3, 2e-3, 500.0, 0.2),
        [[math.sin(2.0 * math.pi * n / samples)] for n in range(samples * periods)],
        period,
    )
    # of the two angles' difference, which has no drift: theta_A - theta_B = theta_B/u J_B s^2/(K_v
    # s + K_r)
    stretch = found.position("a") - found.position("b")
    last = slice(-10 * samples, None)
    fundamental = 2.0 * np.mean(stretch[last] * np.exp(-1j * swing * found.time[last]))
    held = np.sinc(1.0 / samples) * np.exp(
        -1j * math.pi / samples
    )  # what holding the samples does to their fundamental
    s = np.array([1j * swing])
    expected = (
        (
            by_hand.transfer(s)
            * by_hand.inertia_b
            * s**2
            / (by_hand.damping * s + by_hand.stiffness)
        )[0]
        * held
        / 1j
    )
    assert abs(fundamental / expected - 1.0) < 2e-4


def test_as_printed_2_7_is_not_what_2_6_says() -> None:
    """It has no double integrator: at low frequency two pulleys would not turn as one inertia
    (2.9)."""
    one = Belt(1e-3, 2e-3, 100.0, 0.05)
    s = np.array([1e-3j])
    a, b, k, c = one.inertia_a, one.inertia_b, one.stiffness, one.damping
    printed = (
        c
        / (a * b)
        * (s + k / c)
        / (s**4 + (c / a + c / b) * s**3 + (c**2 / (a * b) + k / a + k / b) * s**2 + c**2 / (a * b))
    )
    assert abs(one.transfer(s) / one.rigid(s) - 1.0)[0] < 1e-6
    assert abs(printed / one.rigid(s) - 1.0)[0] > 0.99
