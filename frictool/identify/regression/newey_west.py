"""Standard deviations for correlated residuals of one short record (Newey and West 1987).

A jackknife leaves out rows. In a single stroke, this may be impossible, because a few rows alone
may determine a parameter. Instead, the products of residuals up to `reach` rows apart are summed,
with weights that decrease linearly with the distance.
"""

from __future__ import annotations

import numpy as np

from frictool.identify.regression.regression import SINGULAR, SingularRegressors
from frictool.typing import Matrix, Vector


def newey_west(columns: Matrix, residual: Vector, reach: int) -> Vector:
    """Return the standard deviations (p,) of the parameters of a least-squares fit.

    - columns: regressors, (n, p)
    - residual: residuals of the fit, (n,)
    - reach: number of rows over which residuals are correlated

    Raises SingularRegressors if the regressors do not determine the parameters.
    """
    n, p = columns.shape
    scale = np.linalg.norm(columns, axis=0)
    if n <= p or not np.all(scale > 0.0):
        raise SingularRegressors("the data are too short, or do not excite every parameter")
    rows = columns / scale
    singular = np.linalg.svd(rows, compute_uv=False)
    if singular[-1] < SINGULAR * singular[0]:
        raise SingularRegressors(
            "the regressors are linearly dependent (condition number "
            f"{singular[0] / max(float(singular[-1]), 1e-300):.2g})"
        )
    scores = rows * residual[:, None]
    middle = scores.T @ scores
    for lag in range(1, min(reach, n - 1) + 1):
        product = scores[lag:].T @ scores[:-lag]
        middle += (1.0 - lag / (reach + 1)) * (product + product.T)
    inverse = np.linalg.inv(rows.T @ rows)
    return np.asarray(
        np.sqrt(np.maximum(np.diag(inverse @ middle @ inverse), 0.0) * n / (n - p)) / scale
    )
