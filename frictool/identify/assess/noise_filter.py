"""The first-order low-pass of 4.2.2: which share of the noise's power it leaves, and the slowest
one that the axis bears (4.7).

ratio x = arctan(x),   x = 2 pi tau/T        figure 4.3 shows tau over the ratio, 2 to 80 %
"""

from __future__ import annotations

import math

LARGEST_RATIO = 0.8  # above it the cut-off lies beyond the sample rate
CONVERGED = 1e-12


def noise_ratio(time_constant: float, period: float) -> float:
    """(4.7) forwards: what a filter of this time constant [s] leaves of the power of white noise; 1
    where there is none."""
    x = 2.0 * math.pi * time_constant / period
    return math.atan(x) / x if x > 0.0 else 1.0


def filter_for(ratio: float, period: float) -> float:
    """(4.7) by Newton and Raphson: the time constant [s] that leaves `ratio`, 0 < ratio < 1. Raises
    ValueError outside.

    ratio x - arctan(x) is convex, and positive at pi/(2 ratio): from there every step stays above
    the root.
    """
    if not 0.0 < ratio < 1.0:
        raise ValueError(f"ratio is {ratio:g}; allowed: between 0 and 1")
    x = 0.5 * math.pi / ratio
    while True:
        change = (ratio * x - math.atan(x)) / (ratio - 1.0 / (1.0 + x * x))
        x -= change
        if change <= CONVERGED * x:
            return x * period / (2.0 * math.pi)
