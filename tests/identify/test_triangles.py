"""Rows reduced to triangles: the same normal matrix, run by run, as plain products give."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.identify.regression.tsqr import merged, triangles


@settings(derandomize=True, deadline=None, max_examples=40)
@given(
    seed=st.integers(0, 10_000),
    rows=st.integers(1, 300),
    columns=st.integers(2, 6),
    runs=st.integers(1, 5),
)
def test_each_triangle_has_the_products_of_its_rows(
    seed: int, rows: int, columns: int, runs: int
) -> None:
    draw = np.random.default_rng(seed)
    table = draw.normal(size=(columns, rows)) * 10.0 ** draw.uniform(-6.0, 6.0, (columns, 1))
    weight, starts = (
        draw.uniform(0.1, 2.0, rows),
        np.unique(np.append(0, draw.integers(0, rows, runs - 1))),
    )
    parts = triangles(tuple(table), weight, starts)
    size = np.linalg.norm(table * weight, axis=1)
    for part, first, last in zip(parts, starts, [*starts[1:], rows], strict=True):
        plain = (table[:, first:last] * weight[first:last]) @ (
            table[:, first:last] * weight[first:last]
        ).T
        assert np.abs((part.T @ part - plain) / np.outer(size, size)).max() < 1e-13
        assert np.all(np.tril(part, -1) == 0.0)
    whole = merged(parts)
    assert (
        np.abs(
            (whole.T @ whole - (table * weight) @ (table * weight).T) / np.outer(size, size)
        ).max()
        < 1e-13
    )


def test_a_triangle_keeps_what_products_lose() -> None:
    """Two columns that differ by 1e-9: squared, the difference is below rounding, and the value is
    lost."""
    draw = np.random.default_rng(1)
    base, other = draw.normal(size=(2, 400))
    columns = (base, base + 1e-9 * other)
    target = 2.0 * columns[0] + 3.0 * columns[1]
    part = triangles((*columns, target), np.ones(400), np.array([0, 200]))
    whole = merged(part)
    assert np.linalg.solve(whole[:2, :2], whole[:2, 2]) == pytest.approx([2.0, 3.0], rel=1e-5)
    assert np.linalg.cond(np.array(columns) @ np.array(columns).T) > 1e15


@pytest.mark.parametrize("size", [1e-150, 1e-155, 1e-160, 1e-200])
def test_a_column_whose_squares_underflow_leaves_the_others_as_they_are(size: float) -> None:
    """The values of a steep exponential reach this size at the fastest runs."""
    ordinary, tiny, target = (
        np.array([1.0, 2.0]),
        np.array([size, 3.0 * size]),
        np.array([4.0, 1.0]),
    )
    found = triangles((ordinary, tiny, target), np.ones(2), np.array([0]))
    plain = triangles((ordinary, target), np.ones(2), np.array([0]))
    assert np.all(np.isfinite(found))
    gram = found[0].T @ found[0]
    assert gram[0, 2] == pytest.approx((plain[0].T @ plain[0])[0, 1], rel=1e-12)
