"""Inequalities (5.61)-(5.63) as printed in the thesis, in cvxpy: a readable and slow reference.

Nothing is eliminated, scaled or balanced, and the solver's result is not verified. Each plant has
separate A^, B^, C^, D^; X and Y are common. The discrete form is the same with the discrete
bounded-real lemma. (5.61) as one matrix that must be positive, with ()' for the transpose of the
terms before it:

    continuous   -[A X + B2 C^ + ()'      *                     *          *       ]
                  [A^ + (A + B2 D^ C2)'   Y A + B^ C2 + ()'     *          *       ]
                  [(B1 + B2 D^ D21)'      (Y B1 + B^ D21)'      -gamma I   *       ]
                  [C1 X + D12 C^          C1 + D12 D^ C2        D11 + D12 D^ D21   -gamma I]
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np

from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.typing import Matrix


@dataclass(frozen=True)
class Plain:
    """Solution of the inequalities, with the status of the solver."""

    status: str
    gamma: float
    x: Matrix
    y: Matrix
    hats: tuple[tuple[Matrix, Matrix, Matrix, Matrix], ...]  # A^, B^, C^, D^ of each plant

    def controllers(self, plants: Sequence[GeneralisedPlant]) -> tuple[Lti, ...]:
        """Return the controllers (5.63); a singular value decomposition gives M N' = I - X Y."""
        left, values, right = np.linalg.svd(np.eye(len(self.x)) - self.x @ self.y)
        m, n = left * np.sqrt(values), right.T * np.sqrt(values)
        found = []
        for p, (a_hat, b_hat, c_hat, d) in zip(plants, self.hats, strict=True):
            c = (c_hat - d @ p.c2 @ self.x) @ np.linalg.inv(m).T
            b = np.linalg.inv(n) @ (b_hat - self.y @ p.b2 @ d)
            inner = (
                a_hat
                - self.y @ (p.a + p.b2 @ d @ p.c2) @ self.x
                - n @ b @ p.c2 @ self.x
                - self.y @ p.b2 @ c @ m.T
            )
            found.append(Lti(np.linalg.inv(n) @ inner @ np.linalg.inv(m).T, b, c, d, p.period))
        return tuple(found)


def plain(plants: Sequence[GeneralisedPlant], solver: str = "CLARABEL", **options: Any) -> Plain:
    """Return the solution with the smallest gamma, by a solver of cvxpy."""
    n = len(plants[0].a)
    x, y, gamma = (
        cp.Variable((n, n), symmetric=True),
        cp.Variable((n, n), symmetric=True),
        cp.Variable(),
    )
    lyapunov = cp.bmat([[x, np.eye(n)], [np.eye(n), y]])
    constraints, hats = [lyapunov >> 0], []
    for p in plants:
        n_u, n_y = p.b2.shape[1], len(p.c2)
        hat = (
            cp.Variable((n, n)),
            cp.Variable((n, n_y)),
            cp.Variable((n_u, n)),
            cp.Variable((n_u, n_y)),
        )
        hats.append(hat)
        inequality = (
            _discrete(p, x, y, hat, gamma, lyapunov)
            if p.period
            else _continuous(p, x, y, hat, gamma)
        )
        constraints.append(0.5 * (inequality + inequality.T) >> 0)
    problem = cp.Problem(cp.Minimize(gamma), constraints)
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", UserWarning
        )  # "may be inaccurate", as the status also states
        problem.solve(solver=solver, **options)
    values = tuple(tuple(block.value for block in hat) for hat in hats)
    return Plain(problem.status, float(gamma.value), x.value, y.value, values)


def _blocks(p: GeneralisedPlant, x: Any, y: Any, hat: tuple[Any, ...]) -> tuple[Any, Any, Any, Any]:
    """Return A, B, C, D of the closed loop after the change of variables."""
    a_hat, b_hat, c_hat, d = hat
    moved = cp.bmat(
        [[p.a @ x + p.b2 @ c_hat, p.a + p.b2 @ d @ p.c2], [a_hat, y @ p.a + b_hat @ p.c2]]
    )
    entering = cp.vstack([p.b1 + p.b2 @ d @ p.d21, y @ p.b1 + b_hat @ p.d21])
    seen = cp.hstack([p.c1 @ x + p.d12 @ c_hat, p.c1 + p.d12 @ d @ p.c2])
    return moved, entering, seen, p.d11 + p.d12 @ d @ p.d21


def _continuous(p: GeneralisedPlant, x: Any, y: Any, hat: tuple[Any, ...], gamma: Any) -> Any:
    a, b, c, d = _blocks(p, x, y, hat)
    n_z, n_w = p.d11.shape
    return -cp.bmat(
        [[a + a.T, b, c.T], [b.T, -gamma * np.eye(n_w), d.T], [c, d, -gamma * np.eye(n_z)]]
    )


def _discrete(
    p: GeneralisedPlant, x: Any, y: Any, hat: tuple[Any, ...], gamma: Any, lyapunov: Any
) -> Any:
    a, b, c, d = _blocks(p, x, y, hat)
    (n_z, n_w), n = p.d11.shape, 2 * len(p.a)
    zero = np.zeros
    return cp.bmat(
        [
            [lyapunov, a, b, zero((n, n_z))],
            [a.T, lyapunov, zero((n, n_w)), c.T],
            [b.T, zero((n_w, n)), gamma * np.eye(n_w), d.T],
            [zero((n_z, n)), c, d, gamma * np.eye(n_z)],
        ]
    )
