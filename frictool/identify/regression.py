"""Linear least squares by QR, with intervals that hold when residuals within a cluster are correlated.

Filtered and quantised signals leave residuals that are correlated over a window and over a stroke, so that the textbook covariance
is too small by orders of magnitude. Here each stroke is left out in turn (the delete-one-cluster jackknife, CR3 of Bell and
McCaffrey 2002), and Student's quantile is taken at the number of clusters that effectively count for each parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular
from scipy.special import stdtrit

from frictool.identify.record import Vector

Matrix = NDArray[np.float64]
SINGULAR = 1e-10  # smallest over largest singular value of the scaled regressors


class Singular(ValueError):
    """The regressors do not determine the parameters; the message says how nearly."""


@dataclass(frozen=True)
class Solution:
    """`value` (p,), `deviation` (p,) standard deviations, `freedom` (p,) degrees of freedom of each, and the condition number of the

    weighted regressors with unit columns (the square root of the ratio of eigenvalues that (4.14) uses).
    """

    value: Vector
    deviation: Vector
    freedom: Vector
    condition: float

    def half_width(self, confidence: float) -> Vector:
        """Half the width (p,) of the two-sided interval at `confidence`."""
        return np.asarray(self.deviation * stdtrit(self.freedom, 0.5 + 0.5 * confidence))


def solve(regressors: Matrix, target: Vector, weight: Vector, cluster: NDArray[np.int64]) -> Solution:
    """Minimises sum (weight (target - regressors value))^2 over n rows.

    regressors (n, p), target (n,), weight (n,), cluster (n,) numbers. Raises Singular where p parameters do not follow.
    """
    rows, right = regressors * weight[:, None], target * weight
    scale = np.linalg.norm(rows, axis=0)
    if rows.shape[0] <= rows.shape[1] or not np.all(scale > 0.0):
        raise Singular("the samples used do not excite every parameter")
    rows = rows / scale
    q, r = qr(rows, mode="economic", check_finite=False)
    singular = np.linalg.svd(r, compute_uv=False)
    if singular[-1] < SINGULAR * singular[0]:
        raise Singular(f"the regressors are dependent (condition {singular[0] / max(singular[-1], 1e-300):.2g})")
    value = solve_triangular(r, q.T @ right)
    deviation, freedom = _jackknife(rows, right - rows @ value, r, cluster)
    return Solution(value / scale, deviation / scale, freedom, float(singular[0] / singular[-1]))


def _jackknife(rows: Matrix, residual: Vector, r: Matrix, cluster: NDArray[np.int64]) -> tuple[Vector, Vector]:
    """Standard deviations and degrees of freedom, each (p,), with one cluster left out at a time."""
    if np.any(np.diff(cluster) < 0):
        order = np.argsort(cluster, kind="stable")
        rows, residual, cluster = rows[order], residual[order], cluster[order]
    starts = np.concatenate(([0], np.flatnonzero(np.diff(cluster)) + 1))
    count, size = starts.size, rows.shape[1]
    if count < 2:
        return np.full(size, np.inf), np.ones(size)
    products = np.empty((count, size, size))
    for i in range(size):
        for j in range(i, size):
            products[:, i, j] = products[:, j, i] = np.add.reduceat(rows[:, i] * rows[:, j], starts)
    scores = np.add.reduceat(rows * residual[:, None], starts, axis=0)
    remaining = r.T @ r - products
    floor = SINGULAR * np.trace(r.T @ r)
    usable = np.linalg.eigvalsh(remaining)[:, 0] > floor
    if not usable.all():  # one stroke alone carries a parameter: no spread can be told
        return np.full(size, np.inf), np.ones(size)
    shift = np.linalg.solve(remaining, scores[:, :, None])[:, :, 0]
    variance = (count - 1) / count * np.sum((shift - shift.mean(axis=0)) ** 2, axis=0)
    # how much each cluster would count if all residuals had one variance: Satterthwaite's degrees of freedom
    inverse = np.linalg.inv(remaining)
    share = np.einsum("gij,gjk,gki->gi", inverse, products, inverse)
    freedom = np.maximum(np.sum(share, axis=0) ** 2 / np.sum(share**2, axis=0) - 1.0, 1.0)
    return np.sqrt(variance), np.asarray(freedom)
