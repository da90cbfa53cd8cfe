"""Median of values, computed faster than by numpy."""

from __future__ import annotations

import math

import numpy as np

from frictool.typing import Vector


def median(values: Vector) -> float:
    """Return the median of values (n,), n >= 1; NaN if a value is NaN.

    The result equals `numpy.median` bit by bit.
    """
    half = values.size // 2
    last = values.size - 1
    ordered = np.partition(values, (max(half - 1, 0), half, last))
    if math.isnan(ordered[last]):  # NaN sorts last
        return math.nan
    return (
        float(ordered[half]) if values.size % 2 else float(ordered[half - 1] + ordered[half]) / 2.0
    )
