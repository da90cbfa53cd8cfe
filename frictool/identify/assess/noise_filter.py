"""First-order low-pass of 4.2.2: share of the noise power that it leaves (4.7), and the inverse.

    ratio x = arctan(x),   x = 2 pi tau/T

Figure 4.3 shows tau for ratios of 2 to 80 %.
"""

from __future__ import annotations

import math

LARGEST_RATIO = 0.8  # largest noise ratio; above it the cut-off is beyond the sample rate
CONVERGED = 1e-12


def noise_ratio(time_constant: float, period: float) -> float:
    """Return the share of white noise power that a filter leaves (4.7).

    The time constant and the period are in s. Without a filter the share is 1.
    """
    x = 2.0 * math.pi * time_constant / period
    return math.atan(x) / x if x > 0.0 else 1.0


def filter_for(ratio: float, period: float) -> float:
    """Return the time constant [s] that leaves the share `ratio` of the noise (4.7), by Newton.

    ratio x - arctan(x) is convex, and positive at pi/(2 ratio); from there every step stays above
    the root. Raises ValueError unless 0 < ratio < 1.
    """
    if not 0.0 < ratio < 1.0:
        raise ValueError(f"ratio is {ratio:g}; allowed: between 0 and 1")
    x = 0.5 * math.pi / ratio
    while True:
        change = (ratio * x - math.atan(x)) / (ratio - 1.0 / (1.0 + x * x))
        x -= change
        if change <= CONVERGED * x:
            return x * period / (2.0 * math.pi)
