"""Final value of the position in a hold (phase of constant reference)."""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector

LEAST_SAMPLES = 10  # least number of samples in the mean


def tail_samples(count: int) -> int:
    """Return the number of samples in the last tenth of `count` samples, at least ten."""
    return min(count, max(LEAST_SAMPLES, count // 10))


def final_value(position: Vector) -> float:
    """Return the mean [rad or m] of the last tenth (at least ten) of a hold's positions (n,)."""
    tail = position[-tail_samples(position.size) :]
    return float(np.add.reduce(tail) / tail.size)  # equal to np.mean
