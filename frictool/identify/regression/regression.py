"""Linear least squares by QR, with intervals that hold when residuals within a cluster are
correlated.

Filtered and quantised signals leave residuals that are correlated over a window and over a stroke,
so that the textbook covariance is too small by orders of magnitude. Here each stroke is left out in
turn (the delete-one-cluster jackknife, CR3 of Bell and McCaffrey 2002), and Student's quantile is
taken at the number of clusters that effectively count for each parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import stdtrit

from frictool.identify.motion_record import Vector
from frictool.identify.regression.tsqr import Numbers, Tensor, merged, triangles

Matrix = NDArray[np.float64]
SINGULAR = 1e-10  # smallest over largest singular value of the scaled regressors


class SingularRegressors(ValueError):
    """The regressors do not determine the parameters; the message says how nearly."""


@dataclass(frozen=True)
class LeastSquaresSolution:
    """`value` (p,), `deviation` (p,) standard deviations, `freedom` (p,) degrees of freedom of
    each, and the condition number of the

    weighted regressors with unit columns (the square root of the ratio of eigenvalues that (4.14)
    uses).
    """

    value: Vector
    deviation: Vector
    freedom: Vector
    condition: float

    def half_width(self, confidence: float) -> Vector:
        """Half the width (p,) of the two-sided interval at `confidence`."""
        return np.asarray(self.deviation * stdtrit(self.freedom, 0.5 + 0.5 * confidence))


def solve(
    regressors: Matrix, target: Vector, weight: Vector, cluster: Numbers
) -> LeastSquaresSolution:
    """Minimises sum (weight (target - regressors value))^2 over n rows.

    regressors (n, p), target (n,), weight (n,), cluster (n,) numbers. Raises Singular where p
    parameters do not follow.
    """
    starts = np.concatenate(([0], np.flatnonzero(np.diff(cluster)) + 1))
    if target.size <= regressors.shape[1]:
        raise SingularRegressors("the samples used do not excite every parameter")
    return solve_triangles(triangles((*regressors.T, target), weight, starts), cluster[starts])


def solve_triangles(parts: Tensor, cluster: Numbers) -> LeastSquaresSolution:
    """The same from the triangles (g, p + 1, p + 1) of runs of weighted rows [regressors, target];
    cluster (g,) numbers.

    Raises Singular where p parameters do not follow.
    """
    value, scale, condition = least(parts)
    deviation, freedom = _jackknife(parts, value, scale, cluster)
    return LeastSquaresSolution(value, deviation / scale, freedom, condition)


def least(parts: Tensor) -> tuple[Vector, Vector, float]:
    """The least-squares value (p,), the norms (p,) of the columns, and the condition. Raises
    Singular."""
    whole = merged(parts)
    p = whole.shape[1] - 1
    scale = np.linalg.norm(whole[:, :p], axis=0)
    if whole.shape[0] < p or not np.all(scale > 0.0):
        raise SingularRegressors("the samples used do not excite every parameter")
    r = whole[:p, :p] / scale
    singular = np.linalg.svd(r, compute_uv=False)
    if singular[-1] < SINGULAR * singular[0]:
        raise SingularRegressors(
            f"the regressors are dependent (condition {singular[0] / max(singular[-1], 1e-300):.2g})"
        )
    return (
        np.asarray(solve_triangular(r, whole[:p, p])) / scale,
        scale,
        float(singular[0] / singular[-1]),
    )


def residual_norm(parts: Tensor, value: Vector) -> float:
    """Norm of target - regressors value over the rows of the triangles (g, p + 1, p + 1)."""
    return float(np.linalg.norm(parts[:, :, -1] - parts[:, :, :-1] @ value))


def _jackknife(
    parts: Tensor, value: Vector, scale: Vector, cluster: Numbers
) -> tuple[Vector, Vector]:
    """Standard deviations of value times scale, and degrees of freedom, each (p,), with one cluster
    left out at a time."""
    rows = parts[:, :, :-1] / scale
    residual = parts[:, :, -1] - parts[:, :, :-1] @ value
    place, size = np.unique(cluster, return_inverse=True)[1], scale.size
    count = int(place.max()) + 1
    if count < 2:
        return np.full(size, np.inf), np.ones(size)
    products, scores = np.zeros((count, size, size)), np.zeros((count, size))
    np.add.at(products, place, np.swapaxes(rows, 1, 2) @ rows)
    np.add.at(scores, place, np.einsum("gki,gk->gi", rows, residual))
    whole = products.sum(axis=0)
    remaining = whole - products
    usable = np.linalg.eigvalsh(remaining)[:, 0] > SINGULAR * np.trace(whole)
    if not usable.all():  # one stroke alone carries a parameter: no spread can be told
        return np.full(size, np.inf), np.ones(size)
    shift = np.linalg.solve(remaining, scores[:, :, None])[:, :, 0]
    variance = (count - 1) / count * np.sum((shift - shift.mean(axis=0)) ** 2, axis=0)
    # how much each cluster would count if all residuals had one variance: Satterthwaite's degrees
    # of freedom
    inverse = np.linalg.inv(remaining)
    share = np.einsum("gij,gjk,gki->gi", inverse, products, inverse)
    freedom = np.maximum(np.sum(share, axis=0) ** 2 / np.sum(share**2, axis=0) - 1.0, 1.0)
    return np.sqrt(variance), np.asarray(freedom)
