"""The solver's layer: the two ways to give a constraint are one, and a known optimum is found."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.lmi.bounded_real import BoundedRealInequalities
from frictool.lmi.sdp import AffineConstraint, assemble, solve, symmetric, upper_triangle
from tests.support.synthesis_plants import random_plant


def _largest_eigenvalue(m: np.ndarray) -> AffineConstraint:
    """x I - m >= 0."""
    rows, columns = upper_triangle(len(m))
    return AffineConstraint(-m, (rows == columns).astype(float)[:, None])


@pytest.mark.parametrize("size", [1, 2, 7])
def test_largest_eigenvalue_as_a_linear_matrix_inequality(size: int) -> None:
    m = np.random.default_rng(size).normal(size=(size, size))
    m += m.T
    found = solve(np.ones(1), [_largest_eigenvalue(m)])
    assert found.holds
    assert found.x[0] == pytest.approx(np.linalg.eigvalsh(m)[-1], rel=1e-6)


def test_a_function_is_assembled_exactly() -> None:
    random = np.random.default_rng(1)
    left = random.normal(size=(4, 3))

    def affine(x: np.ndarray) -> np.ndarray:
        return np.asarray(np.eye(4) + left @ symmetric(x, 3) @ left.T)

    one, x = assemble(affine, 6), random.normal(size=6)
    np.testing.assert_allclose(one.at(x), affine(x[None])[0], atol=1e-12)


def test_what_the_solver_cannot_hold_is_told() -> None:
    """x >= 1 and x <= 0: whatever the status, the point does not hold."""
    one = np.ones((1, 1))
    assert not solve(
        np.ones(1), [AffineConstraint(-one, one), AffineConstraint(0.0 * one, -one)]
    ).holds


@pytest.mark.parametrize("sampled", [False, True])
def test_the_assembled_inequalities_are_those_evaluated_from_the_plants(sampled: bool) -> None:
    """The cone program, reduced and divided by gamma, is the Schur complement of the inequality
    that judges its solution; both are built apart."""
    random, gamma, n_w = np.random.default_rng(2), 1.7, 4
    problem = BoundedRealInequalities([random_plant(3, sampled=sampled)])
    given = random.normal(size=2 * problem.half + 2)
    given[-2:] = 1.0 / gamma, 1.0 / gamma**2
    r, s = problem.blocks(given, gamma)
    coupling, *free, cone = problem.free()
    sides = [problem.sides_r[0].at(r, gamma), problem.sides_s[0].at(s, gamma)]
    for constraint, fixed, judged in zip(free, problem.at(gamma, 1.0, 0.0)[1:], sides, strict=True):
        corner, side, last = judged[:-n_w, :-n_w], judged[:-n_w, -n_w:], judged[-n_w:, -n_w:]
        schur = (corner - side @ np.linalg.solve(last, side.T)) / gamma
        np.testing.assert_allclose(constraint.at(given), schur, atol=1e-10)
        np.testing.assert_allclose(fixed.at(given[:-2]), schur, atol=1e-10)
    identity = np.eye(problem.n)
    whole = np.block([[r, identity], [identity, s]]) / gamma
    np.testing.assert_allclose(coupling.at(given), whole, atol=1e-12)
    np.testing.assert_allclose(problem.at(gamma, 1.0, 0.0)[0].at(given[:-2]), whole, atol=1e-12)
    np.testing.assert_allclose(problem.at(gamma, None, 0.0)[0].at(given[:-1]), whole, atol=1e-12)
    np.testing.assert_allclose(
        cone.at(given), [[1.0 / gamma**2, 1.0 / gamma], [1.0 / gamma, 1.0]], atol=1e-12
    )


def test_a_solver_that_panics_is_a_point_that_does_not_hold(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Clarabel's eigenvalue routine may give up; what Python then sees is no Exception, and must
    not end the process."""
    import clarabel

    class PanicException(BaseException):
        pass

    class Panicking:
        def __init__(self, *_: object) -> None: ...

        def solve(self) -> None:
            raise PanicException("Eigval error")

    monkeypatch.setattr(clarabel, "DefaultSolver", Panicking)
    found = solve(np.ones(1), [_largest_eigenvalue(np.eye(2))])
    assert not found.holds
    assert np.all(np.isnan(found.x))
