"""For how long each sample stands: until the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.median import median


def sample_durations(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) [s] from each sample of `time` (n,) [s] to the next; the last stands for the median
    period. A single sample stands for 1 s."""
    if time.size < 2:
        return np.ones_like(time)
    intervals = np.diff(time)
    return np.append(intervals, median(intervals))
