"""Semidefinite programs for Clarabel: minimise c'x subject to F_j(x) = F_j0 + sum x_k F_jk >= 0.

A constraint is written in one of two ways: as F_j0 with the upper triangles of all F_jk, or as a
function F_j that takes an array of decision vectors. Since F_j is affine, its values at zero and at
the unit vectors determine F_j0 and F_jk exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.typing import Matrix, Vector

Affine = Callable[[Matrix], Matrix]  # decision vectors (k, count) -> symmetric matrices (k, m, m)

TOLERANCE = 1e-7  # tolerance relative to the scale of a constraint


@dataclass(frozen=True)
class AffineConstraint:
    """Constraint fixed (m, m) + sum x_k F_k >= 0.

    Column k of `columns` (m (m + 1)/2, count) contains the upper triangle of F_k, column by column.
    """

    fixed: Matrix
    columns: Matrix

    def at(self, x: Vector) -> Matrix:
        """Return the matrix fixed + sum x_k F_k at the decision vector `x`."""
        return np.asarray(self.fixed + symmetric(self.columns @ x, len(self.fixed)))


@dataclass(frozen=True)
class SdpSolution:
    """Result `x` of a solver for a semidefinite program.

    - holds: True if x satisfies the constraints in a check that does not use the solver
    - status: status that the solver reports, as text
    """

    x: Vector
    status: str
    holds: bool


def symmetric(x: Matrix, size: int) -> Matrix:
    """Return the symmetric matrices (..., size, size) whose upper triangles are `x`.

    `x` (..., size (size + 1)/2) contains the triangles column by column.
    """
    out = np.zeros((*x.shape[:-1], size, size))
    rows, columns = upper_triangle(size)
    out[..., rows, columns] = x
    out[..., columns, rows] = x
    return out


@lru_cache(maxsize=256)
def upper_triangle(size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return row and column indices of the upper triangle of a matrix, column by column."""
    columns = np.concatenate([np.full(c + 1, c) for c in range(size)])
    rows = np.concatenate([np.arange(c + 1) for c in range(size)])
    return rows, columns


def assemble(constraint: Affine, count: int) -> AffineConstraint:
    """Return an affine matrix function of `count` unknowns as an AffineConstraint."""
    base, *moved = constraint(np.vstack([np.zeros(count), np.eye(count)]))
    rows, columns = upper_triangle(len(base))
    return AffineConstraint(base, (np.array(moved) - base)[:, rows, columns].T)


def solve(
    objective: Vector, constraints: Sequence[Affine | AffineConstraint], *, iterations: int = 200
) -> SdpSolution:
    """Minimise objective @ x subject to all `constraints` being positive semidefinite."""
    import clarabel

    count = objective.shape[0]
    affine = [
        constraint if isinstance(constraint, AffineConstraint) else assemble(constraint, count)
        for constraint in constraints
    ]
    rows, offsets, cones = [], [], []
    for constraint in affine:
        upper = upper_triangle(len(constraint.fixed))
        weight = np.where(upper[0] == upper[1], 1.0, np.sqrt(2.0))
        rows.append(-constraint.columns * weight[:, None])
        offsets.append(constraint.fixed[upper] * weight)
        cones.append(clarabel.PSDTriangleConeT(len(constraint.fixed)))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = iterations
    settings.max_threads = 1  # makes the result identical on every machine
    quadratic = scipy.sparse.csc_matrix((count, count))
    solver = clarabel.DefaultSolver(
        quadratic,
        objective,
        scipy.sparse.csc_matrix(np.vstack(rows)),
        np.concatenate(offsets),
        cones,
        settings,
    )
    try:
        solution = solver.solve()
    except BaseException as error:
        if (
            type(error).__name__ != "PanicException"
        ):  # pyo3's PanicException is not an Exception; an eigenvalue routine has failed
            raise
        return SdpSolution(np.full(count, np.nan), "Panicked", False)
    x = np.asarray(solution.x, dtype=np.float64)
    return SdpSolution(
        x,
        str(solution.status),
        bool(np.all(np.isfinite(x))) and all(_positive(constraint.at(x)) for constraint in affine),
    )


def _positive(matrix: Matrix) -> bool:
    values = np.linalg.eigvalsh(matrix)
    return bool(values[0] >= -TOLERANCE * max(1.0, values[-1]))
