"""First-order low-pass filter (thesis 4.2.2): noise that passes a filter of given time constant.

    ratio x = arctan(x),   x = 2 pi tau/T

This is thesis (4.7). `ratio` is the fraction of the noise power that passes the filter, tau the
time constant, and T the sample period.
"""

from __future__ import annotations

import math

LARGEST_RATIO = 0.8  # ratio above which the cut-off frequency would exceed the sample rate
CONVERGED = 1e-12


def noise_ratio(time_constant: float, period: float) -> float:
    """Return the fraction of the power of white noise that passes a low-pass filter (thesis 4.7).

    The time constant and the period are in s. A time constant of 0 gives 1.
    """
    x = 2.0 * math.pi * time_constant / period
    return math.atan(x) / x if x > 0.0 else 1.0


def filter_for(ratio: float, period: float) -> float:
    """Return the time constant [s] of the low-pass that leaves the fraction `ratio` of noise power.

    Raises ValueError unless 0 < ratio < 1.
    """
    if not 0.0 < ratio < 1.0:
        raise ValueError(f"ratio is {ratio:g}; allowed: above 0 and below 1")
    x = 0.5 * math.pi / ratio
    while True:
        change = (ratio * x - math.atan(x)) / (ratio - 1.0 / (1.0 + x * x))
        x -= change
        if change <= CONVERGED * x:
            return x * period / (2.0 * math.pi)
