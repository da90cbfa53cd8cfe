"""Ties: the last digits of figures that agree do not decide which of them is named."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.presentation.tie_rule import TOLERANCE, largest, smallest

FIGURES = st.lists(st.integers(-50, 50).map(lambda number: number / 7.0), min_size=1, max_size=12)
LAST_DIGITS = st.floats(-0.2 * TOLERANCE, 0.2 * TOLERANCE)


@given(FIGURES, st.data())
def test_rounding_does_not_decide_which_is_named(figures: list[float], data: st.DataObject) -> None:
    """The figures differ by a seventh or not at all: each one's rounding moves the value by that
    much, and the index not at all."""
    rounded = [figure * (1.0 + data.draw(LAST_DIGITS)) for figure in figures]
    for find, extreme in ((largest, max), (smallest, min)):
        value, index = find(rounded)
        assert index == figures.index(extreme(figures))
        assert value == extreme(rounded)


@given(FIGURES)
def test_what_differs_by_more_is_no_tie(figures: list[float]) -> None:
    top = max(figures)
    above = top + 3.0 * TOLERANCE * max(abs(top), 1.0)
    assert largest([*figures, above]) == (above, len(figures))
    assert smallest([-figure for figure in [*figures, above]]) == (-above, len(figures))


def test_infinite_values_agree_with_each_other_only() -> None:
    assert largest([1.0, math.inf, math.inf]) == (math.inf, 1)
    assert smallest([5.0, math.inf]) == (5.0, 0)
    assert largest([-math.inf, -math.inf]) == (-math.inf, 0)


def test_what_is_no_number_is_not_named() -> None:
    assert largest([math.nan, 1.0]) == (1.0, 1)
    assert smallest([math.nan, 1.0]) == (1.0, 1)


def test_nothing_has_no_largest() -> None:
    with pytest.raises(ValueError, match=r"empty|arg"):
        largest([])
