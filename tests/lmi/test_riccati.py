"""One plant by Riccati equations: the answer of the inequalities, without their solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.lmi import hinf_synthesis
from frictool.lmi.bounded_real import BoundedRealInequalities
from frictool.lmi.hinf_synthesis import controller, minimise
from frictool.lmi.riccati_synthesis import PRECISION, lyapunov_blocks, smallest_gamma
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.verify.hinf_norm import norm
from studies.rigs.mixed_sensitivity import mixed_sensitivity
from studies.rigs.published_plants import position
from tests.support.synthesis_plants import random_plant


def _without_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    def solve(*_: object) -> None:
        raise AssertionError("the solver was called")

    monkeypatch.setattr(hinf_synthesis, "solve", solve)


def _by_solver(monkeypatch: pytest.MonkeyPatch, plant: GeneralisedPlant) -> float:
    with monkeypatch.context() as patch:
        patch.setattr(hinf_synthesis, "smallest_gamma", lambda _: None)
        return minimise([plant], 1.05).optimum


@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_gamma_is_that_of_the_inequalities(
    seed: int, sampled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant = random_plant(seed, 4, sampled=sampled)
    theirs = _by_solver(monkeypatch, plant)
    _without_solver(monkeypatch)
    assert minimise([plant], 1.05).optimum == pytest.approx(theirs, rel=1e-3)


@pytest.mark.parametrize("order", [12, 24])
def test_a_large_plant_needs_no_solver(order: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """At order 24 SLICOT reports a gamma that its controller does not keep."""
    _without_solver(monkeypatch)
    plant = mixed_sensitivity(order)
    found = minimise([plant], 1.05)
    reached = norm(plant.closed(controller(plant, found)))[0]
    assert found.optimum * (1.0 - 1e-4) <= reached <= found.gamma


@given(seed=st.integers(0, 10**6), n=st.integers(1, 6), sampled=st.booleans())
@settings(max_examples=25, deadline=None, derandomize=True)
def test_the_blocks_are_strict_above_gamma_and_there_are_none_below(
    seed: int, n: int, sampled: bool
) -> None:
    """The blocks hold in the inequalities of the plant's own domain."""
    plant = random_plant(seed, n, sampled=sampled)
    gamma = smallest_gamma(plant)
    assert gamma is not None
    blocks = lyapunov_blocks(plant, 1.05 * gamma, 1e-3)
    assert blocks is not None
    assert BoundedRealInequalities([plant]).hold(*blocks, 1.05 * gamma)
    assert lyapunov_blocks(plant, (1.0 - 3.0 * PRECISION) * gamma, 1e-9) is None


def test_several_commands_and_a_direct_term() -> None:
    random = np.random.default_rng(3)
    p = random_plant(3, 4, sampled=False)
    plant = replace(
        p,
        b2=np.hstack([p.b2, random.normal(size=(4, 1))]),
        d12=np.hstack([p.d12, random.normal(size=p.d12.shape)]),
        d11=0.3 * random.normal(size=p.d11.shape),
    )
    gamma = smallest_gamma(plant)
    assert gamma is not None
    found = minimise([plant], 1.05)
    assert found.optimum == pytest.approx(gamma, rel=3.0 * PRECISION)
    assert norm(plant.closed(controller(plant, found)))[0] <= found.gamma


def test_plants_for_which_the_equations_do_not_hold_are_left_to_the_solver() -> None:
    """D12 = 0 in the position loop; an undisturbed free integrator, a zero at frequency 0."""
    assert smallest_gamma(position()[0]) is None
    assert minimise(position()[:1], 1.05).optimum > 0.0
    p = random_plant(1, 2, sampled=False)
    free = replace(
        p,
        a=np.array([[0.0, 1.0], [0.0, -1.0]]),
        b2=np.array([[0.0], [1.0]]),
        c1=p.c1 @ np.diag([0.0, 1.0]),
        c2=np.array([[1.0, 0.0]]),
    )
    assert smallest_gamma(free) is None
    found = minimise([free], 1.05)
    assert norm(free.closed(controller(free, found)))[0] <= found.gamma


def test_blocks_that_fail_their_check_are_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the equations give is trusted no more than what the solver gives."""
    plant = random_plant(2, 3, sampled=False)
    expected = _by_solver(monkeypatch, plant)
    monkeypatch.setattr(hinf_synthesis, "lyapunov_blocks", lambda *_: (np.eye(3), 1e-3 * np.eye(3)))
    assert minimise([plant], 1.05).optimum == expected
