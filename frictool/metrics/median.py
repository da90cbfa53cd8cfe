"""The median, for signals of which very many are looked at."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def median(values: NDArray[np.float64]) -> float:
    """Of values (n,), n >= 1; nan where one is none. The bits of `numpy.median`, whose way to them
    takes three times as long."""
    half, last = values.size // 2, values.size - 1
    ordered = np.partition(values, (max(half - 1, 0), half, last))
    if math.isnan(ordered[last]):  # nan is sorted to the end
        return math.nan
    return (
        float(ordered[half]) if values.size % 2 else float(ordered[half - 1] + ordered[half]) / 2.0
    )
