"""Projection of estimated variance shares onto shares that add up to at most 1.

The factors are independent, so that their first-order shares are nonnegative and add up to at most
1. Estimates S_i with standard deviations e_i can violate this. The projection s is the solution of

    min sum (s_i - S_i)^2 / e_i^2,    s_i >= 0, sum s_i <= 1

The least certain shares change most. Measured by this weighted sum, the projection is not farther
from the true shares than the estimates are, because the allowed shares form a convex set.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector


def within_whole(shares: Vector, errors: Vector) -> Vector:
    """Return the shares (k,), reduced to a sum of 1 if the positive shares add up to more than 1.

    Negative shares are unchanged. `errors` (k,): standard deviations of the shares.
    """
    projected = np.array(shares, dtype=float)
    left = projected > 0.0
    if projected[left].sum() <= 1.0:
        return projected
    weights = np.maximum(errors, 1e-9) ** 2
    # s_i = max(0, S_i - m e_i^2) with the multiplier m

    while True:
        excess = projected[left].sum() - 1.0
        moved = projected[left] - weights[left] * excess / weights[left].sum()
        if np.all(moved >= 0.0):
            projected[left] = moved
            return projected
        low = np.flatnonzero(left)[moved < 0.0]
        projected[low] = 0.0
        left[low] = False
