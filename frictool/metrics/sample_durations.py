"""Duration of each sample of a signal, from the sample to the next sample."""

from __future__ import annotations

import numpy as np

from frictool.metrics.median import median
from frictool.typing import Vector


def sample_durations(time: Vector) -> Vector:
    """Return the time (n,) [s] from each sample of `time` (n,) [s] to the next.

    The duration of the last sample is the median of the other durations. A single sample lasts 1 s.
    """
    if time.size < 2:
        return np.ones_like(time)
    intervals = np.diff(time)
    return np.append(intervals, median(intervals))
