"""Thinned signals: no peak is lost, however the samples come, in a number of columns that is
bounded."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
from hypothesis import given, settings

from frictool.observe.streamed_decimation import MOST, DecimatedTrace, zigzag


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(1, 7000), min_size=1, max_size=12), st.integers(0, 2**32 - 1))
def test_columns_hold_the_lowest_and_highest_of_their_samples(
    lengths: list[int], seed: int
) -> None:
    count = sum(lengths)
    values, time = np.random.default_rng(seed).normal(size=(2, count)), np.arange(float(count))
    trace, at = DecimatedTrace(2), 0
    for length in lengths:
        trace.take(time[at : at + length], values[:, at : at + length])
        at += length
    shown, low, high = trace.drawn()
    per = 1
    while -(-count // per) >= 2 * MOST:
        per *= 2
    starts = np.arange(0, count, per)
    np.testing.assert_array_equal(shown, time[starts])
    np.testing.assert_array_equal(low, np.minimum.reduceat(values, starts, axis=1))
    np.testing.assert_array_equal(high, np.maximum.reduceat(values, starts, axis=1))


def test_a_line_goes_through_both_ends_of_each_column() -> None:
    time, low, high = np.array([0.0, 1.0]), np.array([-1.0, 2.0]), np.array([3.0, 4.0])
    along, values = zigzag(time, low, high)
    assert (along.tolist(), values.tolist()) == ([0.0, 0.0, 1.0, 1.0], [-1.0, 3.0, 2.0, 4.0])
    along, values = zigzag(time, low, low)
    assert (along.tolist(), values.tolist()) == (time.tolist(), low.tolist())
