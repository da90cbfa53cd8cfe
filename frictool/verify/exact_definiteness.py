"""Positive definiteness of integer matrices, decided in integers, and what the decision needs
beside it.

Fraction-free elimination (Bareiss, 1968): the k-th pivot is the k-th leading minor, an integer, and
every division comes out even. A symmetric matrix is positive definite exactly when all of them are
positive (Sylvester).
"""

from __future__ import annotations

from typing import Any

import numpy as np

Integers = Any  # arrays of Python integers (dtype object)
KEPT = 56  # bits of a matrix's largest entry that a rounded matrix keeps


def first_failing_minor(matrix: Integers) -> int | None:
    """The size of the first leading minor that is not positive of a symmetric integer matrix (n,
    n); None: it is positive definite.

    Raises ValueError for a matrix that is not symmetric, whose minors would say nothing.
    """
    if matrix.shape != matrix.T.shape or not np.all(matrix == matrix.T):
        raise ValueError("the matrix is not symmetric")
    rows = [[int(value) for value in row] for row in matrix]
    previous = 1
    for k in range(len(rows)):
        pivot, base = rows[k][k], rows[k]
        if pivot <= 0:
            return k + 1
        for i in range(k + 1, len(rows)):
            factor, row = rows[i][k], rows[i]
            for j in range(i, len(rows)):
                row[j] = (row[j] * pivot - factor * base[j]) // previous
            for j in range(k + 1, i):
                row[j] = rows[j][i]
        previous = pivot
    return None


def rounded_below(matrix: Integers) -> Integers:
    """A symmetric matrix of short integers: times a power of two it is below `matrix` (the
    difference is positive semidefinite).

    Each entry is cut by less than one unit; a symmetric matrix of entries in [0, 1) is at most n
    times the identity (Gershgorin).
    """
    spare = max(int(abs(value)).bit_length() for value in matrix.ravel()) - KEPT
    if spare <= 0:
        return matrix
    return np.asarray(
        (matrix >> spare) - len(matrix) * np.identity(len(matrix), dtype=object), dtype=object
    )


def inverse_of_upper(factor: Integers, one: int) -> Integers:
    """An inverse, rounded, of the upper triangular matrix `factor`/one, times `one`.

    Raises ZeroDivisionError where a diagonal entry is zero.
    """
    n = len(factor)
    found = np.zeros((n, n), dtype=object)
    for column in range(n):
        for row in range(column, -1, -1):
            known = sum(
                (factor[row, k] * found[k, column] for k in range(row + 1, column + 1)), start=0
            )
            found[row, column] = ((one * one if row == column else 0) - known) // factor[row, row]
    return found
