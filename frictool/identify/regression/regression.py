"""Linear least squares by QR, with confidence intervals of the parameters.

The intervals allow for residuals that are correlated within clusters of rows. Filtered and
quantised signals cause residuals that are correlated over a smoothing window and over a stroke. The
usual covariance is then too small by orders of magnitude. Here the covariance comes from a
jackknife that leaves out one cluster (usually a stroke) at a time: CR3 of Bell and McCaffrey
(2002). Student's quantile has the effective degrees of freedom of each parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from frictool.identify.fit_result import UnusableLogs
from frictool.identify.regression.tsqr import Tensor, merged, triangles
from frictool.typing import IntVector, Matrix, Vector

SINGULAR = 1e-10  # least ratio of the smallest to the largest singular value of the regressors


class SingularRegressors(UnusableLogs):
    """Error: the regressors do not determine the parameters."""


@dataclass(frozen=True)
class LeastSquaresSolution:
    """Solution of a least-squares problem with p parameters.

    - value, deviation, freedom: estimates, standard deviations and degrees of freedom, (p,)
    - condition: condition number of the weighted regressors, with columns scaled to unit length
    """

    value: Vector
    deviation: Vector
    freedom: Vector
    condition: float

    def half_width(self, confidence: float) -> Vector:
        """Return the half widths (p,) of the two-sided intervals at `confidence`."""
        return np.asarray(
            self.deviation * scipy.special.stdtrit(self.freedom, 0.5 + 0.5 * confidence)
        )


def solve(
    regressors: Matrix, target: Vector, weight: Vector, cluster: IntVector
) -> LeastSquaresSolution:
    """Return the weighted least-squares solution, with standard deviations by a jackknife.

    The field `value` minimises sum (weight (target - regressors @ value))^2 over n rows.

    - regressors: (n, p)
    - target, weight, cluster: target, weight and cluster number of each row, (n,)

    Raises SingularRegressors if the regressors do not determine the parameters.
    """
    starts = np.concatenate(([0], np.flatnonzero(np.diff(cluster)) + 1))
    if target.size <= regressors.shape[1]:
        raise SingularRegressors("the data are too short, or do not excite every parameter")
    return solve_triangles(triangles((*regressors.T, target), weight, starts), cluster[starts])


def solve_triangles(parts: Tensor, cluster: IntVector) -> LeastSquaresSolution:
    """Return the solution of `solve` from triangular matrices of g groups of rows.

    - parts: triangular matrices of the weighted rows [regressors, target], (g, p + 1, p + 1)
    - cluster: cluster number of each group, (g,)

    Raises SingularRegressors if the regressors do not determine the parameters.
    """
    value, scale, condition = least(parts)
    deviation, freedom = _jackknife(parts, value, scale, cluster)
    return LeastSquaresSolution(value, deviation / scale, freedom, condition)


def least(parts: Tensor) -> tuple[Vector, Vector, float]:
    """Return the least-squares solution (p,), column norms (p,), and condition number.

    `parts` are triangular matrices of the weighted rows [regressors, target], (g, p + 1, p + 1).
    Raises SingularRegressors if the regressors do not determine the parameters.
    """
    whole = merged(parts)
    p = whole.shape[1] - 1
    if p == 0:
        raise SingularRegressors("all parameters are fixed, so that nothing is left to fit")
    scale = np.linalg.norm(whole[:, :p], axis=0)
    if whole.shape[0] < p or not np.all(scale > 0.0):
        raise SingularRegressors("the data are too short, or do not excite every parameter")
    r = whole[:p, :p] / scale
    singular = np.linalg.svd(r, compute_uv=False)
    if singular[-1] < SINGULAR * singular[0]:
        raise SingularRegressors(
            "the regressors are linearly dependent (condition number "
            f"{singular[0] / max(singular[-1], 1e-300):.2g})"
        )
    return (
        np.asarray(scipy.linalg.solve_triangular(r, whole[:p, p])) / scale,
        scale,
        float(singular[0] / singular[-1]),
    )


def residual_norm(parts: Tensor, value: Vector) -> float:
    """Return the Euclidean norm of the weighted residuals target - regressors @ value.

    `parts` are triangular matrices of the weighted rows [regressors, target], (g, p + 1, p + 1).
    """
    return float(np.linalg.norm(parts[:, :, -1] - parts[:, :, :-1] @ value))


def _jackknife(
    parts: Tensor, value: Vector, scale: Vector, cluster: IntVector
) -> tuple[Vector, Vector]:
    """Return standard deviations (p,) times `scale`, and degrees of freedom (p,)."""
    rows = parts[:, :, :-1] / scale
    residual = parts[:, :, -1] - parts[:, :, :-1] @ value
    index = np.unique(cluster, return_inverse=True)[1]
    size = scale.size
    count = int(index.max()) + 1
    if count < 2:
        return np.full(size, np.inf), np.ones(size)
    products = np.zeros((count, size, size))
    scores = np.zeros((count, size))
    np.add.at(products, index, np.swapaxes(rows, 1, 2) @ rows)
    np.add.at(scores, index, np.einsum("gki,gk->gi", rows, residual))
    whole = products.sum(axis=0)
    remaining = whole - products
    usable = np.linalg.eigvalsh(remaining)[:, 0] > SINGULAR * np.trace(whole)
    # one cluster alone determines a parameter, so that the scatter of this parameter is unknown
    if not usable.all():
        return np.full(size, np.inf), np.ones(size)
    shift = np.linalg.solve(remaining, scores[:, :, None])[:, :, 0]
    variance = (count - 1) / count * np.sum((shift - shift.mean(axis=0)) ** 2, axis=0)
    # influence of each cluster if all residuals had one variance: Satterthwaite's degrees of
    # freedom
    inverse = np.linalg.inv(remaining)
    share = np.einsum("gij,gjk,gki->gi", inverse, products, inverse)
    freedom = np.maximum(np.sum(share, axis=0) ** 2 / np.sum(share**2, axis=0) - 1.0, 1.0)
    return np.sqrt(variance), np.asarray(freedom)
