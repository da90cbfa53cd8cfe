"""Durations of samples, each of which holds until the next, and a fast median."""

from __future__ import annotations

import math

import numpy as np

from frictool.typing import Vector


def sample_durations(time: Vector) -> Vector:
    """Return the time (n,) [s] from each sample of `time` (n,) [s] to the next.

    The last sample holds for the median period; a single sample holds for 1 s.
    """
    if time.size < 2:
        return np.ones_like(time)
    intervals = np.diff(time)
    return np.append(intervals, median(intervals))


def median(values: Vector) -> float:
    """Return the median of values (n,), n >= 1; NaN if one of them is NaN.

    The result equals `numpy.median` bit by bit, which takes three times as long.
    """
    half = values.size // 2
    last = values.size - 1
    ordered = np.partition(values, (max(half - 1, 0), half, last))
    if math.isnan(ordered[last]):  # NaN sorts last
        return math.nan
    return (
        float(ordered[half]) if values.size % 2 else float(ordered[half - 1] + ordered[half]) / 2.0
    )
