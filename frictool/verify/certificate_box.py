"""Parameter box of a certificate in the rates k = K/J and s = sigma_v/J.

The functions decide which rectangles of rates contain plants of the box, and which of them the
cells cover. For the plants of a rectangle, 1/J lies in one interval, which three conditions
restrict independently: J lies in its interval, K = k J in the interval of K, and sigma_v = s J in
the interval of sigma_v. All numbers are fractions of integers.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction

from frictool.documents.certificate import Box, Cell

Interval = tuple[Fraction, Fraction]


def exact(interval: Sequence[float]) -> Interval:
    """Return the two ends as fractions."""
    return Fraction(interval[0]), Fraction(interval[1])


def inverse_inertia(box: Box, drive: Interval, viscous: Interval) -> Interval | None:
    """Return the interval of 1/J of the plants with k in `drive` and s in `viscous`.

    The result is None if there is no such plant.
    """
    j, k, sigma = exact(box.inertia), exact(box.constant), exact(box.viscous)
    low, high = 1 / j[1], 1 / j[0]
    # a K_low <= k_high, a K_high >= k_low, and the same for s; multiplier * a <= bound
    for multiplier, bound in (
        (k[0], drive[1]),
        (-k[1], -drive[0]),
        (sigma[0], viscous[1]),
        (-sigma[1], -viscous[0]),
    ):
        if multiplier > 0:
            high = min(high, bound / multiplier)
        elif multiplier < 0:
            low = max(low, bound / multiplier)
        elif bound < 0:
            return None
    return (low, high) if low <= high else None


def friction_rates(box: Box, drive: Interval, viscous: Interval) -> Interval:
    """Return bounds of |F_c|/J at the two ends of `drive`, or (0, 0) if there is no such plant.

    The straight line between the two values is a bound for the rates between the ends.
    """
    inside = inverse_inertia(box, drive, viscous)
    if inside is None:
        return Fraction(0), Fraction(0)
    largest = max(abs(end) for end in exact(box.coulomb))
    least_constant = Fraction(box.constant[0])
    if drive[1] / least_constant <= inside[1]:  # 1/J = k/K <= k/K_low everywhere
        return largest * drive[0] / least_constant, largest * drive[1] / least_constant
    return largest * inside[1], largest * inside[1]


def surroundings(box: Box) -> tuple[Interval, Interval]:
    """Return the smallest rectangle of k and s that holds every plant."""
    j, k, sigma = exact(box.inertia), exact(box.constant), exact(box.viscous)
    corners = [end / inertia for end in sigma for inertia in j]
    return (k[0] / j[1], k[1] / j[0]), (min(corners), max(corners))


def uncovered(box: Box, cells: Sequence[Cell]) -> tuple[Interval, Interval] | None:
    """Return a rectangle of k and s that holds plants but is in no cell; None if there is none.

    The cells must extend slightly beyond the box in s.
    """
    (k_low, k_high), (s_low, s_high) = surroundings(box)
    rectangles = [(exact(cell.drive_rate), exact(cell.viscous_rate)) for cell in cells]
    marks = sorted(
        {k_low, k_high, *(end for k, _ in rectangles for end in k if k_low < end < k_high)}
    )
    strips = list(itertools.pairwise(marks)) or [(k_low, k_low)]
    for strip in strips:
        reached = (
            s_low - 1
        )  # the scan extends beyond the plants: a box without width in s needs a cell too
        across = sorted(s for k, s in rectangles if k[0] <= strip[0] and strip[1] <= k[1])
        for s in (*across, (s_high + 1, s_high + 1)):
            gap = (reached, s[0])
            if s[0] > reached and inverse_inertia(box, strip, gap) is not None:
                return strip, gap
            reached = max(reached, s[1])
    return None
