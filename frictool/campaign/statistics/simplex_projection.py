"""Projection of estimated variance shares onto shares that add up to at most 1.

The factors are independent, so that their first-order shares are nonnegative and add up to at most
1. Estimates S_i with standard deviations e_i can violate this. The projection s is the nearest
point to the estimates, in units of e_i, that satisfies both conditions:

    min sum (s_i - S_i)^2 / e_i^2,    s_i >= 0, sum s_i <= 1

The projection changes the least certain shares most. In this norm, the true shares are at least as
near to the projection as to the estimates, because the points that satisfy both conditions form a
convex set.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector


def within_whole(shares: Vector, errors: Vector) -> Vector:
    """Return the shares (k,), projected if the positive shares add up to more than 1.

    Negative shares are unchanged.

    `errors` (k,): standard deviations of the shares.
    """
    projected = np.array(shares, dtype=float)
    left = projected > 0.0
    if projected[left].sum() <= 1.0:
        return projected
    weights = np.maximum(errors, 1e-9) ** 2
    # s_i = S_i - m e_i^2; a share that would become negative is 0, and the others decrease more

    while True:
        excess = projected[left].sum() - 1.0
        moved = projected[left] - weights[left] * excess / weights[left].sum()
        if np.all(moved >= 0.0):
            projected[left] = moved
            return projected
        low = np.flatnonzero(left)[moved < 0.0]
        projected[low] = 0.0
        left[low] = False
