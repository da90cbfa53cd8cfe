"""Check of the solver of matrix inequalities on a problem with a known solution."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.doctor.installation_finding import InstallationFinding
from frictool.lmi.sdp import solve

A = np.array([[-1.0, 4.0], [0.0, -3.0]])  # x' = A x, stable
NEAR = 1e-5  # relative tolerance of the solution


def check_solver() -> InstallationFinding:
    """Compare a solution of the solver of matrix inequalities with the exact solution.

    The solver minimises the trace of P > 0 under A'P + P A + I <= 0. The exact solution solves the
    Lyapunov equation A'P + P A + I = 0.
    """
    solution = solve(np.array([1.0, 0.0, 1.0]), [_decrease, _symmetric])
    p = _symmetric(solution.x[None])[0]
    expected = np.trace(solve_lyapunov())
    apart = abs(float(np.trace(p)) - expected) / expected
    facts = {
        "status": solution.status,
        "holds": solution.holds,
        "apart": apart if math.isfinite(apart) else None,
    }
    if not solution.holds or not apart < NEAR:
        remedy = "pip install --force-reinstall clarabel scipy numpy"
        return InstallationFinding(
            "solver",
            "wrong",
            f"the solver ended with {solution.status}; the relative error is {apart:.3g}",
            remedy,
            facts,
        )
    return InstallationFinding(
        "solver",
        "ok",
        f"a matrix inequality is solved; the relative error of the result is {apart:.1e}",
        facts=facts,
    )


def _symmetric(x: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack(
        [np.stack([x[:, 0], x[:, 1]], axis=-1), np.stack([x[:, 1], x[:, 2]], axis=-1)], axis=-2
    )


def _decrease(x: NDArray[np.float64]) -> NDArray[np.float64]:
    p = _symmetric(x)
    return np.asarray(-(A.T @ p + p @ A) - np.eye(2))


def solve_lyapunov() -> NDArray[np.float64]:
    """Return the solution P of A'P + P A + I = 0, with the constant A of this module."""
    n = len(A)
    whole = np.kron(A.T, np.eye(n)) + np.kron(np.eye(n), A.T)
    return np.asarray(np.linalg.solve(whole, -np.eye(n).ravel()).reshape(n, n))
