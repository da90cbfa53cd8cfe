"""Optimal division of the duration of a test among experiments, by a convex program.

    minimise    max_i  e_i' (sum x_k R_k)^-1 e_i / limit_i
    subject to  sum x_k = 1,  x_k >= 0,  sum x_k cost_k <= 0

x_k is the share of experiment k, R_k its information matrix per second, and e_i the i-th unit
vector; e_i' (...)^-1 e_i is the variance of parameter i. The program is stated with cvxpy and
solved by clarabel. Sources: Pukelsheim 2006, chapter 6; Boyd and Vandenberghe 2004, 7.5.
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np

from frictool.typing import Matrix, Vector

SINGULAR = 1e12  # condition number above which the information of all experiments is singular


def optimal_shares(rate: Matrix, limit: Vector, cost: Vector) -> Vector | None:
    """Return the shares of the experiments that minimise the largest quotient variance/limit.

    Parameters
    ----------
    rate
        Information per second of each experiment, (k, p, p).
    limit
        Largest variance of each parameter, (p,); inf if a parameter has no limit.
    cost
        Cost of each experiment per second, (k,). The mean cost of the result is at most 0; a cost
        of -inf removes this constraint.

    Returns
    -------
    Vector or None
        Shares (k,), which are >= 0 and have the sum 1; None if all experiments together do not
        determine the parameters, or if the solver finds no solution.
    """
    import cvxpy as cp

    known = np.flatnonzero(np.isfinite(limit))
    mixture = np.mean(rate, axis=0)
    power = np.diag(mixture)
    if not np.all(power > 0.0):
        return None
    scale = 1.0 / np.sqrt(power)
    scaled = rate * np.outer(scale, scale)
    mixture = mixture * np.outer(scale, scale)
    if np.linalg.cond(mixture) > SINGULAR:
        return None
    weight = scale[known] ** 2 / limit[known]
    weight /= float((weight * np.diag(np.linalg.inv(mixture))[known]).max())
    share: Any = cp.Variable(rate.shape[0], nonneg=True)
    size = rate.shape[1]
    matrix = cp.reshape(scaled.reshape(rate.shape[0], -1).T @ share, (size, size), order="F")
    ratios = [
        float(part) * cp.matrix_frac(np.eye(size)[row], matrix)
        for row, part in zip(known, weight, strict=True)
    ]
    rules: list[Any] = [cp.sum(share) == 1.0]
    if math.isfinite(float(cost.min())):
        rules.append(share @ cost <= 0.0)
    problem = cp.Problem(cp.Minimize(cp.max(cp.hstack(ratios))), rules)
    try:
        with warnings.catch_warnings():
            # warnings of reduced accuracy; the caller computes the variances of the shares
            warnings.simplefilter("ignore", UserWarning)
            problem.solve(solver=cp.CLARABEL)
    except cp.SolverError:
        return None
    if share.value is None:
        return None
    return np.maximum(np.asarray(share.value, dtype=np.float64), 0.0)
