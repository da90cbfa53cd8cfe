"""Where a hold ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEAST_SAMPLES = 10


def tail_samples(count: int) -> int:
    """How many of a hold's `count` samples are its end: the last tenth, at least ten."""
    return min(count, max(LEAST_SAMPLES, count // 10))


def final_value(position: NDArray[np.float64]) -> float:
    """Mean position [rad or m] over the last tenth of a hold (n,), at least its last ten
    samples."""
    return float(np.mean(position[-tail_samples(position.size) :]))
