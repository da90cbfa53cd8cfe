"""Positive definiteness in whole numbers against determinants by permutations, and what it is asked
of."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.verify.exact_definiteness import first_failing_minor, inverse_of_upper, rounded_below


def _determinant(matrix: np.ndarray) -> int:
    total = 0
    for order in itertools.permutations(range(len(matrix))):
        sign = (-1) ** sum(
            order[i] > order[j] for i, j in itertools.combinations(range(len(order)), 2)
        )
        term = sign
        for row, column in enumerate(order):
            term *= int(matrix[row, column])
        total += term
    return total


def _symmetric(values: list[int], n: int) -> np.ndarray:
    matrix = np.zeros((n, n), dtype=object)
    matrix[np.triu_indices(n)] = values
    return matrix + np.triu(matrix, 1).T


@given(n=st.integers(1, 5), data=st.data())
@settings(max_examples=150)
def test_the_first_failing_minor_is_the_first_determinant_that_is_not_positive(
    n: int, data: st.DataObject
) -> None:
    count = n * (n + 1) // 2
    matrix = _symmetric(
        data.draw(st.lists(st.integers(-5, 5), min_size=count, max_size=count)), n
    ) + 3 * np.identity(n, dtype=object)
    minors = [_determinant(matrix[:k, :k]) for k in range(1, n + 1)]
    assert first_failing_minor(matrix) == next(
        (k for k, minor in enumerate(minors, start=1) if minor <= 0), None
    )


@given(n=st.integers(1, 6), seed=st.integers(0, 10**6))
@settings(max_examples=40)
def test_gram_matrices_pass_and_one_unit_less_than_singular_fails(n: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    root = np.array(random.integers(-(2**40), 2**40, size=(n, n)).tolist(), dtype=object)
    gram = root.T @ root + np.identity(n, dtype=object)
    assert first_failing_minor(gram) is None
    singular = root.T @ np.diag([*[1] * (n - 1), 0]).astype(object) @ root
    assert first_failing_minor(singular) is not None
    assert first_failing_minor(singular - np.identity(n, dtype=object)) is not None


def test_a_matrix_that_is_not_symmetric_is_refused() -> None:
    with pytest.raises(ValueError, match="not symmetric"):
        first_failing_minor(np.array([[1, 0], [1, 1]], dtype=object))


@given(n=st.integers(1, 5), seed=st.integers(0, 10**6))
@settings(max_examples=40)
def test_a_rounded_matrix_is_below(n: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    wide = [
        int(value) * 2**90 + int(rest)
        for value, rest in random.integers(-(2**50), 2**50, size=(n * (n + 1) // 2, 2))
    ]
    matrix = _symmetric(wide, n)
    rounded = rounded_below(matrix)
    spare = max(int(abs(value)).bit_length() for value in matrix.ravel()) - 56
    assert first_failing_minor(matrix - (rounded << spare) + np.identity(n, dtype=object)) is None
    assert max(int(abs(value)).bit_length() for value in rounded.ravel()) <= 57


@given(n=st.integers(1, 5), seed=st.integers(0, 10**6))
@settings(max_examples=40)
def test_the_inverse_of_a_triangle(n: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    one = 1 << 64
    factor = np.array(
        np.triu(random.integers(-(2**60), 2**60, size=(n, n))).tolist(), dtype=object
    ) + one * np.identity(n, dtype=object)
    product = factor @ inverse_of_upper(factor, one)
    error = max(
        abs(Fraction(int(value), one * one))
        for value in (product - one * one * np.identity(n, dtype=object)).ravel()
    )
    assert error < Fraction(1, 2**50)
