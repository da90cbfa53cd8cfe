"""The stored forms of a controller are one controller; an integrator stays exact in each of them,
in whatever coordinates it came."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from frictool.adapters.state_space import read_state_space
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, parallel_sum
from frictool.synth.realisation import split_integrator, stored_forms

PERIOD = 1e-3


def _stable(random: np.random.Generator, n: int, direct: float) -> Lti:
    a = random.normal(size=(n, n))
    a *= random.uniform(0.2, 0.95) / np.max(np.abs(np.linalg.eigvals(a)))
    return Lti(
        a, random.normal(size=(n, 1)), random.normal(size=(1, n)), np.array([[direct]]), PERIOD
    )


def _integrator(slope: float) -> Lti:
    return Lti(np.ones((1, 1)), np.ones((1, 1)), np.array([[slope]]), np.zeros((1, 1)), PERIOD)


def _mixed(random: np.random.Generator, k: Lti) -> Lti:
    """The same system in coordinates that hide the integrator."""
    orthogonal, _ = np.linalg.qr(random.normal(size=(k.order, k.order)))
    return k.transformed(orthogonal * random.uniform(0.5, 2.0, k.order))


@given(
    seed=st.integers(0, 100_000),
    n=st.integers(1, 5),
    slope=st.floats(1e-3, 1.0) | st.floats(-1.0, -1e-3),
    direct=st.sampled_from([0.0, 1.0, -3.0]),
)
def test_every_form_is_the_controller_and_integrates_exactly(
    seed: int, n: int, slope: float, direct: float
) -> None:
    random = np.random.default_rng(seed)
    k = _mixed(random, parallel_sum(_integrator(slope), _stable(random, n, direct)))
    stored = stored_forms(k)
    assert stored.discrete.a[0][0] == 1.0
    assert not any(stored.discrete.a[0][1:])
    assert not any(stored.continuous.a[0])
    w = np.geomspace(1.0, 0.999 * np.pi / PERIOD, 60)
    weight = np.abs(np.exp(1j * w * PERIOD) - 1.0)
    expected = weight * k.response(w)[:, 0, 0]
    largest = np.max(np.abs(expected))
    _, from_sections = signal.sosfreqz(np.array(stored.sos), worN=w * PERIOD)
    from_continuous = read_state_space(stored.continuous, 0.0).response(
        2.0 / PERIOD * np.tan(0.5 * w * PERIOD)
    )[:, 0, 0]
    for form in (
        read_state_space(stored.discrete, PERIOD).response(w)[:, 0, 0],
        from_sections,
        from_continuous,
    ):
        assert np.max(np.abs(weight * form - expected)) < 1e-6 * largest


@given(seed=st.integers(0, 100_000), n=st.integers(1, 5), slope=st.floats(1e-3, 1.0))
def test_anti_windup_forgets(seed: int, n: int, slope: float) -> None:
    """While limited the state follows x+ = (a - l c) x + ..., which is stable although the
    controller itself integrates."""
    random = np.random.default_rng(seed)
    stored = stored_forms(parallel_sum(_integrator(slope), _stable(random, n, 1.0)))
    k = read_state_space(stored.discrete, PERIOD)
    gain = np.array(stored.anti_windup)[:, None]
    assert np.max(np.abs(np.linalg.eigvals(k.a - gain @ k.c))) < 1.0


def test_the_integrator_has_a_section_of_its_own() -> None:
    """1/(z - 1) + 1/(z - 0.5) + 1 = z (z - 0.5) / ((z - 1)(z - 0.5)) + ...: real zeros, so that a
    section of first order is proper."""
    k = parallel_sum(
        _integrator(1.0),
        Lti(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1)), np.ones((1, 1)), PERIOD),
    )
    assert stored_forms(k).sos[0][3:] == (1.0, -1.0, 0.0)


def test_a_pure_integrator_and_a_gain() -> None:
    k = Lti(np.ones((1, 1)), np.ones((1, 1)), np.array([[0.2]]), np.array([[3.0]]), PERIOD)
    (section,) = stored_forms(k).sos
    assert section == pytest.approx((3.0, -2.8, 0.0, 1.0, -1.0, 0.0), rel=1e-12)


def test_an_integrator_that_nothing_enters_is_left_out() -> None:
    k = parallel_sum(
        Lti(np.ones((1, 1)), np.zeros((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), PERIOD),
        _stable(np.random.default_rng(1), 2, 0.0),
    )
    integrator, rest = split_integrator(k)
    assert integrator is None
    assert rest.order == 2


def test_two_integrators_and_unstable_poles_are_refused() -> None:
    with pytest.raises(NoSolutionError, match="2 integrators; one is allowed"):
        stored_forms(
            parallel_sum(
                _integrator(1.0),
                parallel_sum(_integrator(2.0), _stable(np.random.default_rng(0), 1, 0.0)),
            )
        )
    with pytest.raises(NoSolutionError, match=r"modulus 1\.0001"):
        stored_forms(
            Lti(np.array([[1.0001]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), PERIOD)
        )
