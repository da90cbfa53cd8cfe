"""Lyapunov matrices, linear in one parameter, of a bounded-real inequality that is to hold on a
whole cell of plants.

The loop G = [A B; C D] is linear between its two ends in that parameter, for each of several
control points in the other; with S = diag(P, I) the inequality diag(P, g^2 I) - G' S G > 0 is a
cubic in the first, positive where its four Bernstein coefficients are (verify/certificate_proof.py,
which proves what is found here). They are affine in P at the two ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictool.lmi.sdp import Affine, solve, symmetric

Matrix = NDArray[np.float64]


def lyapunov_ends(
    low: Sequence[Matrix], high: Sequence[Matrix], n: int, below: float
) -> tuple[float, Matrix, Matrix]:
    """P (n, n) at both ends, as far inside the inequalities at the bound `below` as they go, and
    their smallest eigenvalue there.

    It is negative where the inequalities have no solution, and -inf where the solver gives no
    finite point.

    low, high: [A B; C D] (n + outputs, n + inputs) at the control points, at either end.
    """
    half = n * (n + 1) // 2
    constraints = [
        _coefficient(a, b, n, below, index)
        for a, b in zip(low, high, strict=True)
        for index in range(4)
    ]
    objective = np.zeros(2 * half + 1)
    objective[-1] = -1.0
    found = solve(objective, constraints)
    least = float(found.x[-1]) if np.all(np.isfinite(found.x)) else -np.inf
    return least, symmetric(found.x[:half], n), symmetric(found.x[half : 2 * half], n)


def _coefficient(low: Matrix, high: Matrix, n: int, below: float, index: int) -> Affine:
    """One Bernstein coefficient, of the bounded-real inequality minus the last variable times the
    identity."""
    half, m = n * (n + 1) // 2, low.shape[1]
    level = np.diag(np.concatenate([np.zeros(n), np.full(m - n, below**2)]))

    def gained(first: Matrix, p: Any, second: Matrix) -> Any:
        return first[:n].T @ p @ second[:n] + first[n:].T @ second[n:]

    def positive(x: Matrix) -> Matrix:
        p, q = symmetric(x[:, :half], n), symmetric(x[:, half : 2 * half], n)
        if index == 0:
            kept, taken = p, gained(low, p, low)
        elif index == 1:
            kept, taken = (
                (2.0 * p + q) / 3.0,
                (gained(low, q, low) + gained(low, p, high) + gained(high, p, low)) / 3.0,
            )
        elif index == 2:
            kept, taken = (
                (p + 2.0 * q) / 3.0,
                (gained(high, p, high) + gained(low, q, high) + gained(high, q, low)) / 3.0,
            )
        else:
            kept, taken = q, gained(high, q, high)
        whole = level - taken - x[:, -1, None, None] * np.eye(m)
        whole[:, :n, :n] += kept
        return np.asarray(whole)

    return positive
