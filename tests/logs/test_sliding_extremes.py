"""The sliding maximum gives the values of scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import maximum_filter1d

from frictool.logs.quality.sliding_extremes import sliding_maximum


@pytest.mark.parametrize("length", [1, 2, 30, 31])
@pytest.mark.parametrize("count", [31, 60, 1000])
def test_windows_hold_the_largest_value_of_scipy(count: int, length: int) -> None:
    values = np.random.default_rng(count).normal(size=count)
    centred = sliding_maximum(values, length, length // 2)
    assert np.array_equal(centred, maximum_filter1d(values, length))
    if length % 2 == 0:
        earlier = sliding_maximum(values, length, length // 2 - 1)
        assert np.array_equal(earlier, maximum_filter1d(values, length, origin=-1))
