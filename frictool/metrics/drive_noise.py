"""White noise of a measured drive: its standard deviation and its peak."""

from __future__ import annotations

import math

import numpy as np

from frictool.metrics.median import median
from frictool.typing import Vector

# distance of the noise floor from the expected maximum of n samples, in standard deviations; fewer
# than 1 of 1000 records exceed the noise floor by chance
MARGIN = 2.0


def noise_deviation(signal: Vector) -> float:
    """Return the standard deviation of the white noise on `signal` (n,); 0 for n < 3.

    The estimate is the median of |second difference|/(0.6745 sqrt 6). A component that is smooth
    from sample to sample does not change the estimate.
    """
    if signal.size < 3:
        return 0.0
    first = signal[1:] - signal[:-1]
    return deviation_of(np.abs(first[1:] - first[:-1]))


def deviation_of(second_differences: Vector) -> float:
    """Return the standard deviation of white noise from absolute second differences (n - 2,)."""
    if second_differences.size == 0:
        return 0.0
    return median(second_differences) / (0.6745 * math.sqrt(6.0))


def noise_floor(signal: Vector) -> float:
    """Return the peak that the white noise on `signal` (n,) hardly ever exceeds.

    The peak, in the unit of the signal, is (sqrt(2 ln n) + 2) times the standard deviation of the
    noise.
    """
    return noise_deviation(signal) * peak_factor(signal.size)


def peak_factor(samples: int) -> float:
    """Return (peak that `samples` values of white noise hardly exceed)/(standard deviation)."""
    return math.sqrt(2.0 * math.log(max(samples, 2))) + MARGIN
