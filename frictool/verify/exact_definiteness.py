"""Positive definiteness of integer matrices, decided in integers.

In fraction-free elimination (Bareiss, 1968) the k-th pivot is the k-th leading minor, an integer,
and every division is exact. A symmetric matrix is positive definite if and only if all leading
minors are positive (Sylvester).
"""

from __future__ import annotations

from typing import Any

import numpy as np

Integers = Any  # arrays of Python integers (dtype object)
KEPT = 56  # bits of a matrix's largest entry that a rounded matrix keeps


def first_failing_minor(matrix: Integers) -> int | None:
    """Return the size of the first leading minor that is not positive; None if positive definite.

    `matrix` is a symmetric integer matrix (n, n). Raises ValueError if it is not symmetric, since
    its minors would then prove nothing.
    """
    if matrix.shape != matrix.T.shape or not np.all(matrix == matrix.T):
        raise ValueError("the matrix is not symmetric")
    rows = [[int(value) for value in row] for row in matrix]
    previous = 1
    for k in range(len(rows)):
        pivot = rows[k][k]
        base = rows[k]
        if pivot <= 0:
            return k + 1
        for i in range(k + 1, len(rows)):
            factor = rows[i][k]
            row = rows[i]
            for j in range(i, len(rows)):
                row[j] = (row[j] * pivot - factor * base[j]) // previous
            for j in range(k + 1, i):
                row[j] = rows[j][i]
        previous = pivot
    return None


def rounded_below(matrix: Integers) -> Integers:
    """Return a matrix of short integers that, times a power of two, is below `matrix`.

    Both are symmetric; the difference is positive semidefinite. Each entry is cut by less than one
    unit, and a symmetric matrix of entries in [0, 1) is at most n times the identity (Gershgorin).
    """
    spare = max(int(abs(value)).bit_length() for value in matrix.ravel()) - KEPT
    if spare <= 0:
        return matrix
    return np.asarray(
        (matrix >> spare) - len(matrix) * np.identity(len(matrix), dtype=object), dtype=object
    )


def inverse_of_upper(factor: Integers, one: int) -> Integers:
    """Return the rounded inverse, times `one`, of the upper triangular matrix `factor`/one.

    Raises ZeroDivisionError if a diagonal entry is zero.
    """
    n = len(factor)
    inverse = np.zeros((n, n), dtype=object)
    for column in range(n):
        for row in range(column, -1, -1):
            known = sum(
                (factor[row, k] * inverse[k, column] for k in range(row + 1, column + 1)), start=0
            )
            inverse[row, column] = ((one * one if row == column else 0) - known) // factor[row, row]
    return inverse
