"""Recursive least squares by Givens rotations of a triangular matrix."""

from __future__ import annotations

import math

import numpy as np

from frictool.runtime.kernels import kernel
from frictool.typing import Matrix


@kernel
def givens_path(rows: Matrix, root: float, path: Matrix) -> None:
    """Compute the recursive least-squares solution after each row.

    - rows: [regressors, target], (n, p + 1)
    - root: square root of the forgetting factor of one row
    - path: result, solution after each row, (n, p); NaN until the rows determine all parameters
    """
    n, q = rows.shape
    p = q - 1
    triangle = np.zeros((p, q))
    row = np.empty(q)
    for k in range(n):
        for i in range(q):
            row[i] = rows[k, i]
        for i in range(p):
            for j in range(i, q):
                triangle[i, j] *= root
            if row[i] == 0.0:
                continue
            norm = math.hypot(triangle[i, i], row[i])
            cosine = triangle[i, i] / norm
            sine = row[i] / norm
            for j in range(i, q):
                kept = triangle[i, j]
                triangle[i, j] = cosine * kept + sine * row[j]
                row[j] = cosine * row[j] - sine * kept
        largest = 0.0
        for i in range(p):
            largest = max(largest, abs(triangle[i, i]))
        determined = largest > 0.0
        for i in range(p):
            determined = determined and abs(triangle[i, i]) > 1e-12 * largest
        for i in range(p - 1, -1, -1):
            value = triangle[i, p] if determined else math.nan
            for j in range(i + 1, p):
                value -= triangle[i, j] * path[k, j]
            path[k, i] = value / triangle[i, i] if determined else math.nan
