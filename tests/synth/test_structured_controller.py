"""Properties of the parametrisation that hold for every parameter: integrator, pole bound, damping,
order; its derivatives are those of K."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from frictool.plant.lti import inverse_tustin
from frictool.synth.structured_controller import LEAST_DAMPING, SLOWEST, StructuredController

PERIOD = 1e-3
structures = st.builds(
    StructuredController,
    order=st.integers(2, 6),
    integrator=st.booleans(),
    rolls_off=st.booleans(),
    bound=st.sampled_from([300.0, 2000.0]),
    around=st.sampled_from([30.0, 90.0]),
    gain=st.sampled_from([0.01, 20.0]),
    period=st.sampled_from([0.0, PERIOD]),
)
seeds = st.integers(0, 100_000)


def _parameters(structure: StructuredController, seed: int, *, slowest: float = 1e-3) -> np.ndarray:
    """Anywhere within the limits, the limits themselves included."""
    random = np.random.default_rng(seed)
    low, high = structure.limits()
    parameters = random.normal(size=structure.size)
    poles = slice(0, structure.free)
    least = np.maximum(low[poles], np.log(slowest))
    parameters[poles] = random.uniform(least, high[poles])
    at_limit = random.random(structure.free) < 0.2
    parameters[poles][at_limit] = high[poles][at_limit]
    return parameters


@given(structure=structures, seed=seeds)
def test_poles_are_where_they_must_be(structure: StructuredController, seed: int) -> None:
    parameters = _parameters(structure, seed, slowest=SLOWEST)
    k = structure.system(parameters)
    assert k.order == structure.order
    if structure.integrator:
        assert k.a[0, 0] == (1.0 if structure.period else 0.0)  # exactly
        assert not np.any(k.a[0, 1:])
        assert not np.any(k.a[1:, 0])
    whole = np.ones(1)
    for factor in structure.factors(parameters):
        poles = np.roots(factor) * structure.around
        assert np.all(
            np.abs(poles) <= structure.bound * (1.0 + 1e-6)
        )  # a double pole is known to the square root of the rounding
        assert np.all(-poles.real >= (LEAST_DAMPING - 1e-6) * np.abs(poles))
        whole = np.convolve(whole, factor)
    free = k if not structure.period else inverse_tustin(k)
    assert np.poly(free.a / structure.around)[: len(whole)] == pytest.approx(whole, rel=1e-6)


def test_every_pair_of_poles_in_the_region_is_reached() -> None:
    """Real ones that are apart, double ones and complex ones have parameters within the limits."""
    structure = StructuredController(2, False, True, 2000.0, 50.0, 1.0)
    for poles in (
        [-3.0, -1900.0],
        [-2000.0, -2000.0],
        [-80.0, -80.0],
        [-100.0 + 900.0j, -100.0 - 900.0j],
        [-1400.0 + 1400.0j, -1400.0 - 1400.0j],
    ):
        w, m = (
            np.sqrt(np.prod(poles).real),
            -np.sum(poles).real / 2.0 / np.sqrt(np.prod(poles).real),
        )
        u = np.log(w / 2000.0)
        y = np.log(m / LEAST_DAMPING) / np.log(np.cosh(u) / LEAST_DAMPING)
        low, high = structure.limits()
        assert low[0] <= u <= high[0] + 1e-12
        assert 0.0 <= y <= 1.0 + 1e-12
        found = np.roots(structure.factors(np.array([u, y, 1.0, 1.0]))[0]) * 50.0
        assert np.sort_complex(found) == pytest.approx(np.sort_complex(np.array(poles)), rel=1e-6)


def test_no_ringing_pole_where_the_bound_is_the_bilinear_one() -> None:
    """|s| <= 2/T maps onto Re z >= 0."""
    structure = StructuredController(3, False, True, 2.0 / PERIOD, 50.0, 1.0, PERIOD)
    for seed in range(50):
        assert np.all(
            np.linalg.eigvals(structure.system(_parameters(structure, seed)).a).real > -1e-4
        )


@settings(max_examples=60)
@given(structure=structures, seed=seeds)
@example(StructuredController(6, False, False, 2000.0, 30.0, 20.0, PERIOD), 4041)
def test_the_state_space_is_the_formula(structure: StructuredController, seed: int) -> None:
    parameters = _parameters(structure, seed)
    w = np.geomspace(0.1, 0.999 * np.pi / PERIOD, 40)
    formula, _ = structure.response(parameters, structure.points(w))
    assert structure.system(parameters).response(w)[:, 0, 0] == pytest.approx(
        formula, rel=1e-6, abs=1e-9 * np.max(np.abs(formula))
    )


@given(structure=structures, seed=seeds)
def test_roll_off(structure: StructuredController, seed: int) -> None:
    k = structure.system(_parameters(structure, seed))
    end = k.response(np.pi / PERIOD)[0, 0, 0] if structure.period else k.d[0, 0]
    largest = np.max(np.abs(k.response(np.geomspace(1.0, 3000.0, 50))))
    assert (abs(end) < 1e-9 * largest) == structure.rolls_off


@given(structure=structures, seed=seeds)
def test_derivatives_are_those_of_the_response(structure: StructuredController, seed: int) -> None:
    parameters = _parameters(structure, seed)
    s = structure.points(np.geomspace(1.0, 2000.0, 7))
    _, derivatives = structure.response(parameters, s)
    for j in range(structure.size):
        step = 1e-6 * np.eye(structure.size)[j]
        difference = (
            structure.response(parameters + step, s)[0]
            - structure.response(parameters - step, s)[0]
        ) / 2e-6
        scale = np.max(np.abs(derivatives[:, j])) + 1e-3 * np.max(
            np.abs(structure.response(parameters, s)[0])
        )
        assert np.max(np.abs(derivatives[:, j] - difference)) < 1e-5 * scale


@given(structure=structures, seed=seeds, place=st.floats(0.002, 1.0))
def test_growing_changes_nothing(structure: StructuredController, seed: int, place: float) -> None:
    parameters = _parameters(structure, seed)
    low, high = structure.limits()
    assume(np.all(parameters >= low) and np.all(parameters <= high))
    wider = structure.wider()
    grown = structure.grown(parameters, place * structure.bound)
    assert wider == replace(structure, order=structure.order + 1)
    low, high = wider.limits()
    assert np.all(grown >= low - 1e-12)
    assert np.all(grown <= high + 1e-12)
    s = structure.points(np.geomspace(0.1, 3000.0, 30))
    assert wider.response(grown, s)[0] == pytest.approx(
        structure.response(parameters, s)[0], rel=1e-9
    )
