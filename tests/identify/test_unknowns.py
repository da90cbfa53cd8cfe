"""Half widths of normal and uniform parts: against the quantiles of a million draws, and in both
limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.identify.regression.combined_interval import half_width

DRAWS = np.random.default_rng(7).uniform(-1.0, 1.0, (3, 200_000))
NORMAL = np.random.default_rng(8).standard_normal(200_000)


@settings(max_examples=30, deadline=None)
@given(
    st.floats(0.05, 2.0),
    st.lists(st.floats(0.0, 3.0), min_size=0, max_size=3),
    st.sampled_from([0.68, 0.9, 0.95, 0.99]),
)
def test_against_draws(deviation: float, ranges: list[float], confidence: float) -> None:
    total = np.abs(
        deviation * NORMAL + sum(r * draw for r, draw in zip(ranges, DRAWS, strict=False))
    )
    assert half_width(confidence, deviation, ranges) == pytest.approx(
        np.quantile(total, confidence), rel=0.02
    )


def test_limits() -> None:
    assert half_width(0.95, 2.0, []) == pytest.approx(2.0 * 1.959964, rel=1e-6)
    assert half_width(0.95, 0.0, [3.0]) == pytest.approx(
        0.95 * 3.0, rel=2e-3
    )  # and not 1.13 times 3
    assert half_width(0.95, 0.0, []) == 0.0
