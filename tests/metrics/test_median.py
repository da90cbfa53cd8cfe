"""The median is numpy's, to the last bit."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from frictool.metrics.median import median


@given(st.lists(st.floats(-1e300, 1e300), min_size=1, max_size=40), st.booleans())
def test_it_is_that_of_numpy(values: list[float], broken: bool) -> None:
    signal = np.array([*values, *([np.nan] if broken else [])])
    np.testing.assert_array_equal(median(signal), np.median(signal))


def test_ties_and_infinities() -> None:
    for values in (
        [1.0, 1.0],
        [np.inf, 1.0, 2.0],
        [np.inf, np.inf],
        [-np.inf, 0.0, 0.0, 3.0],
        [0.1, 0.2],
        [5.0],
    ):
        assert median(np.array(values)) == np.median(values)
