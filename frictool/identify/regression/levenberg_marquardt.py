"""Non-linear least squares with a known Jacobian, without scipy.optimize.

The import of scipy.optimize takes longer than a fit of a few unknowns.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from frictool.typing import Matrix, Vector

# damping relative to the diagonal of the normal equations
FIRST_DAMPING = 1e-3
LARGEST_DAMPING = 1e8
DAMPING_STEP = 10.0  # damping: factor after a refused step, divisor after an accepted step


class LeastSquares(NamedTuple):
    """Result of a fit: unknowns (n,), residuals (m,) at these unknowns, number of evaluations."""

    unknowns: Vector
    residual: Vector
    evaluations: int


def levenberg_marquardt(
    residual: Callable[[Vector], Vector],
    jacobian: Callable[[Vector], Matrix],
    start: Vector,
    tolerance: float,
    most_evaluations: int,
) -> LeastSquares:
    """Minimise the sum of squared residuals (D. Marquardt, SIAM J. Appl. Math. 11, 1963).

    Parameters
    ----------
    residual
        Function of the unknowns (n,) that returns the residuals (m,).
    jacobian
        Function of the unknowns that returns the derivatives of the residuals with respect to the
        unknowns, (m, n).
    start
        Start values of the unknowns, (n,).
    tolerance
        The search ends when a step reduces the sum of squares by less than this fraction, or when
        no step reduces it.
    most_evaluations
        Largest number of evaluations of `residual`.

    Returns
    -------
    LeastSquares
        The unknowns with the smallest sum of squares.
    """
    best = LeastSquares(start, residual(start), 1)
    cost = float(best.residual @ best.residual)
    slopes = jacobian(start)
    damping = FIRST_DAMPING
    for count in range(2, most_evaluations + 1):
        normal = slopes.T @ slopes
        diagonal = np.diag(normal)
        diagonal = np.maximum(diagonal, np.finfo(float).eps * diagonal.max())
        step = np.linalg.solve(normal + np.diag(damping * diagonal), -slopes.T @ best.residual)
        trial = best.unknowns + step
        left = residual(trial)
        reached = float(left @ left)
        if reached < cost:
            gain = cost - reached
            best = LeastSquares(trial, left, count)
            cost = reached
            if gain <= tolerance * cost:
                break
            slopes = jacobian(trial)
            damping /= DAMPING_STEP
        else:
            damping *= DAMPING_STEP
            if not damping < LARGEST_DAMPING:
                break
    return best
