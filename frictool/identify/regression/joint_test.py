"""Joint test of several parameters of a regression: Hotelling's T^2 with the cluster jackknife.

    F = (v - k + 1)/(v k) b^T V^-1 b  ~  F(k, v - k + 1)

b (k,) contains the tested parameters. V is the covariance of b by a jackknife that leaves out one
cluster at a time (CR3 of Bell and McCaffrey, 2002). v is the number of clusters minus one.
Residuals may be correlated within a cluster.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from frictool.identify.regression.regression import SINGULAR, SingularRegressors, least
from frictool.identify.regression.tsqr import Tensor
from frictool.typing import IntVector


def joint_probability(parts: Tensor, cluster: IntVector, tested: Sequence[int]) -> float:
    """Return the p-value of the null hypothesis that all tested parameters are 0.

    Parameters
    ----------
    parts
        Triangular matrices (g, p + 1, p + 1) of g groups of rows, with p columns of regressors and
        one of the target.
    cluster
        Number (g,) of the cluster of each group.
    tested
        Indices of the k tested regressors.

    Returns
    -------
    float
        p-value; 1 if there are too few clusters, or if one cluster alone determines a parameter.
    """
    try:
        value, scale, _ = least(parts)
    except SingularRegressors:
        return 1.0
    rows = parts[:, :, :-1] / scale
    scaled = value * scale
    residual = parts[:, :, -1] - rows @ scaled
    index = np.unique(cluster, return_inverse=True)[1]
    count = int(index.max()) + 1
    freedom = count - 1
    k = len(tested)
    if freedom <= k:
        return 1.0
    products = np.zeros((count, scale.size, scale.size))
    scores = np.zeros((count, scale.size))
    np.add.at(products, index, np.swapaxes(rows, 1, 2) @ rows)
    np.add.at(scores, index, np.einsum("gki,gk->gi", rows, residual))
    whole = products.sum(axis=0)
    remaining = whole - products
    if not np.all(np.linalg.eigvalsh(remaining)[:, 0] > SINGULAR * np.trace(whole)):
        return 1.0
    shift = np.linalg.solve(remaining, scores[:, :, None])[:, list(tested), 0]
    shift -= shift.mean(axis=0)
    covariance = freedom / count * shift.T @ shift
    b = scaled[list(tested)]
    square = float(b @ np.linalg.lstsq(covariance, b, rcond=None)[0])
    statistic = square * (freedom - k + 1) / (freedom * k)
    return float(scipy.special.fdtrc(k, freedom - k + 1, max(statistic, 0.0)))
