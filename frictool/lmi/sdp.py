"""Linear matrix inequalities handed to Clarabel directly: minimise c'x subject to F_j(x) = F_j0 + sum x_k F_jk >= 0.

The constraints are given as functions of the decision vector, for many vectors at once; being affine, each is assembled exactly from
its values at zero and at the unit vectors. Nothing here knows what the inequalities mean.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]
Affine = Callable[[Matrix], Matrix]  # decision vectors (k, count) -> symmetric matrices (k, m, m)

TOLERANCE = 1e-7  # of a constraint's own scale


@dataclass(frozen=True)
class Solution:
    """The decision vector; `holds` is our own check of the constraints there, the solver's `status` is only told."""

    x: Vector
    status: str
    holds: bool


def symmetric(x: Matrix, size: int) -> Matrix:
    """The symmetric matrices (..., size, size) whose upper triangles, column by column, are `x` (..., size (size + 1)/2)."""
    out = np.zeros((*x.shape[:-1], size, size))
    rows, columns = upper_triangle(size)
    out[..., rows, columns] = x
    out[..., columns, rows] = x
    return out


def upper_triangle(size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the upper triangle, column by column."""
    columns = np.concatenate([np.full(c + 1, c) for c in range(size)])
    rows = np.concatenate([np.arange(c + 1) for c in range(size)])
    return rows, columns


def solve(objective: Vector, constraints: Sequence[Affine], *, iterations: int = 200) -> Solution:
    """Minimises objective @ x with every constraint positive semidefinite."""
    import clarabel

    count = objective.shape[0]
    rows, offsets, cones = [], [], []
    for constraint in constraints:
        base, *columns = constraint(np.vstack([np.zeros(count), np.eye(count)]))
        size = base.shape[0]
        upper = upper_triangle(size)
        weight = np.where(upper[0] == upper[1], 1.0, np.sqrt(2.0))
        rows.append((base - np.array(columns))[:, upper[0], upper[1]].T * weight[:, None])
        offsets.append(base[upper] * weight)
        cones.append(clarabel.PSDTriangleConeT(size))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = iterations
    settings.max_threads = 1  # the same bytes on every machine
    quadratic = sparse.csc_matrix((count, count))
    solver = clarabel.DefaultSolver(quadratic, objective, sparse.csc_matrix(np.vstack(rows)), np.concatenate(offsets), cones, settings)
    found = solver.solve()
    x = np.asarray(found.x, dtype=np.float64)
    return Solution(
        x, str(found.status), bool(np.all(np.isfinite(x))) and all(_positive(constraint(x[None])[0]) for constraint in constraints)
    )


def _positive(matrix: Matrix) -> bool:
    values = np.linalg.eigvalsh(matrix)
    return bool(values[0] >= -TOLERANCE * max(1.0, values[-1]))
