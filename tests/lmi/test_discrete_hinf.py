"""The eliminated, balanced inequalities against the plain full form through cvxpy, and their controllers against the true norm."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
import pytest

from frictool.errors import NoSolutionError
from frictool.lmi.discrete_hinf import controller, minimise
from frictool.plant.generalised import FirstOrder, GeneralisedPlant, Weights, generalised_plant, template
from frictool.plant.polytope import polytope
from frictool.verify.speed_loop import performance
from tests.synth.example import clutch_model


def _random_plant(seed: int, n: int = 3) -> GeneralisedPlant:
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n))
    a *= 1.1 / np.max(np.abs(np.linalg.eigvals(a)))  # unstable in open loop
    b1 = np.hstack([0.5 * np.eye(n), np.zeros((n, 1))])
    c1 = np.vstack([0.5 * np.eye(n), np.zeros((1, n))])
    d12, d21 = np.vstack([np.zeros((n, 1)), [[0.5]]]), np.hstack([np.zeros((1, n)), [[0.5]]])
    return GeneralisedPlant(a, b1, random.normal(size=(n, 1)), c1, random.normal(size=(1, n)), np.zeros((n + 1, n + 1)), d12, d21, 1.0)


def _reference_gamma(p: GeneralisedPlant) -> float:
    """The full inequality (5.61) in discrete time, as it reads, with cvxpy."""
    n, n_w, n_z = p.a.shape[0], p.b1.shape[1], p.c1.shape[0]
    x, y = cp.Variable((n, n), symmetric=True), cp.Variable((n, n), symmetric=True)
    ah, bh, ch, dh = cp.Variable((n, n)), cp.Variable((n, 1)), cp.Variable((1, n)), cp.Variable((1, 1))
    gamma = cp.Variable()
    identity = np.eye(n)
    lyapunov = cp.bmat([[x, identity], [identity, y]])
    moved = cp.bmat([[p.a @ x + p.b2 @ ch, p.a + p.b2 @ dh @ p.c2], [ah, y @ p.a + bh @ p.c2]])
    entering = cp.vstack([p.b1 + p.b2 @ dh @ p.d21, y @ p.b1 + bh @ p.d21])
    seen = cp.hstack([p.c1 @ x + p.d12 @ ch, p.c1 + p.d12 @ dh @ p.c2])
    through = p.d11 + p.d12 @ dh @ p.d21
    zero = np.zeros
    whole = cp.bmat(
        [
            [lyapunov, moved, entering, zero((2 * n, n_z))],
            [moved.T, lyapunov, zero((2 * n, n_w)), seen.T],
            [entering.T, zero((n_w, 2 * n)), gamma * np.eye(n_w), through.T],
            [zero((n_z, 2 * n)), seen, through, gamma * np.eye(n_z)],
        ]
    )
    problem = cp.Problem(cp.Minimize(gamma), [0.5 * (whole + whole.T) >> 0])
    problem.solve(solver=cp.CLARABEL)
    return float(gamma.value)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_optimum_is_that_of_the_plain_form(seed: int) -> None:
    plant = _random_plant(seed)
    found = minimise([plant], 1.02)
    assert found.optimum == pytest.approx(_reference_gamma(plant), rel=2e-3)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("recentring", [1.02, 1.1])
def test_the_controller_keeps_the_gamma_that_it_was_asked_for(seed: int, recentring: float) -> None:
    plant = _random_plant(seed)
    found = minimise([plant], recentring)
    assert performance(controller(plant, found), plant) <= found.gamma * (1.0 + 1e-6)


def test_each_vertex_controller_of_the_clutch_keeps_gamma_at_its_vertex() -> None:
    weights = Weights(template(40.0, 0.5, 2 / 63), 0.03, 0.5, 0.5, FirstOrder(0.01))
    box = polytope(clutch_model())
    plants = [generalised_plant("speed", point.rates, 0.003, weights, 1e-3, 1) for point in (box.centre, *box.vertices[::5])]
    found = minimise(plants, 1.1)
    assert found.gamma == pytest.approx(1.1 * found.optimum)
    for plant in plants:
        assert performance(controller(plant, found), plant) <= found.gamma * (1.0 + 1e-6)


def test_a_plant_that_cannot_be_stabilised_has_no_solution() -> None:
    p = _random_plant(1)
    a = np.diag([1.5, 0.5, 0.2])  # the unstable state is neither driven nor seen
    blind = GeneralisedPlant(a, p.b1, p.b2 * [[0], [1], [1]], p.c1, p.c2 * [[0, 1, 1]], p.d11, p.d12, p.d21, 1.0)
    with pytest.raises(NoSolutionError) as caught:
        controller(blind, minimise([blind], 1.1))
    assert caught.value.exit_code == 4


def test_input_matrices_that_vary_over_the_polytope_are_refused() -> None:
    with pytest.raises(ValueError, match="same at every vertex"):
        minimise([_random_plant(1), _random_plant(2)], 1.1)
