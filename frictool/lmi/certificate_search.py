"""Search for Lyapunov matrices, linear in one parameter, for a whole cell of plants.

The loop G = [A B; C D] is linear in the first parameter between two ends, for each of several
control points in the second parameter. With S = diag(P, I), the matrix diag(P, g^2 I) - G' S G is a
cubic in the first parameter, positive definite if its four Bernstein coefficients are. They are
affine in P at the two ends. verify/certificate_proof.py proves the result.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from frictool.lmi.sdp import Affine, solve, symmetric
from frictool.typing import Matrix


def lyapunov_ends(
    low: Sequence[Matrix], high: Sequence[Matrix], n: int, below: float
) -> tuple[float, Matrix, Matrix]:
    """Return the smallest eigenvalue of the inequalities at g = `below`, and P (n, n) at both ends.

    P maximises the eigenvalue. It is negative if the inequalities have no solution, and -inf if the
    solver returns no finite point. `low` and `high` have [A B; C D] (n + outputs, n + inputs) at
    each control point, for the low and the high end of the first parameter.
    """
    half = n * (n + 1) // 2
    constraints = [
        _coefficient(a, b, n, below, index)
        for a, b in zip(low, high, strict=True)
        for index in range(4)
    ]
    objective = np.zeros(2 * half + 1)
    objective[-1] = -1.0
    solution = solve(objective, constraints)
    least = float(solution.x[-1]) if np.all(np.isfinite(solution.x)) else -np.inf
    return least, symmetric(solution.x[:half], n), symmetric(solution.x[half : 2 * half], n)


def _coefficient(low: Matrix, high: Matrix, n: int, below: float, index: int) -> Affine:
    """Return the Bernstein coefficient `index`, minus the last unknown times the identity."""
    half = n * (n + 1) // 2
    m = low.shape[1]
    level = np.diag(np.concatenate([np.zeros(n), np.full(m - n, below**2)]))

    def gained(first: Matrix, p: Any, second: Matrix) -> Any:
        return first[:n].T @ p @ second[:n] + first[n:].T @ second[n:]

    def positive(x: Matrix) -> Matrix:
        p = symmetric(x[:, :half], n)
        q = symmetric(x[:, half : 2 * half], n)
        if index == 0:
            kept = p
            taken = gained(low, p, low)
        elif index == 1:
            kept = (2.0 * p + q) / 3.0
            taken = (gained(low, q, low) + gained(low, p, high) + gained(high, p, low)) / 3.0
        elif index == 2:
            kept = (p + 2.0 * q) / 3.0
            taken = (gained(high, p, high) + gained(low, q, high) + gained(high, q, low)) / 3.0
        else:
            kept = q
            taken = gained(high, q, high)
        whole = level - taken - x[:, -1, None, None] * np.eye(m)
        whole[:, :n, :n] += kept
        return np.asarray(whole)

    return positive
