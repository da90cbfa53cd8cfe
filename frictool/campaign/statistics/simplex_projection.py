"""Shares that add up to no more than the whole.

Factors are independent, so that first-order shares are of a sum of variances: S_i >= 0, sum S_i <=
1. Estimates, each with an error of its own, need not keep to it: with a hundred trials 80 % +- 6 %
and 23 % +- 9 % are found beside each other. What is there is then the point of that set nearest to
the estimates in units of their errors,

    min sum (s_i - S_i)^2 / e_i^2,    s_i >= 0, sum s_i <= 1,

which takes most off what is known least. No point of the set, the true shares among them, is
farther from it than from the estimates, since the set is convex.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def within_whole(shares: Vector, errors: Vector) -> Vector:
    """(k,) of shares (k,) with errors (k,): themselves where those above 0 add up to no more than
    1; nothing below 0 is moved."""
    found = np.array(shares, dtype=float)
    left = found > 0.0
    if found[left].sum() <= 1.0:
        return found
    weights = np.maximum(errors, 1e-9) ** 2
    while True:  # s_i = S_i - m e_i^2; what would fall below 0 is 0, and the others give more
        excess = found[left].sum() - 1.0
        moved = found[left] - weights[left] * excess / weights[left].sum()
        if np.all(moved >= 0.0):
            found[left] = moved
            return found
        low = np.flatnonzero(left)[moved < 0.0]
        found[low], left[low] = 0.0, False
