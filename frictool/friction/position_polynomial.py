"""Friction in each direction as a polynomial of position (thesis 4.44, 4.41).

    C_s(x, direction) = b_n x^n + .. + b_0          C_r = (mean C_r/mean C_s) C_s

C_s is the breakaway, C_r the Coulomb friction. The parameters F_s and F_c of a law are the means of
C_s and C_r over the travel. The polynomial divided by its mean is a factor that multiplies both F_s
and F_c. Outside the travel the factor keeps its value at the nearer end, since a polynomial fitted
within the travel is not valid outside. Coefficients are in order of rising powers.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from frictool.friction.polynomial_minimum import minimum
from frictool.typing import Vector


def normalise(coefficients: Vector, low: float, high: float) -> tuple[Vector, float]:
    """Return the coefficients divided by the polynomial's mean over [low, high], and this mean.

    Raises ValueError if the mean is not positive, if coefficients are missing or not finite, or if
    low >= high.
    """
    b = np.asarray(coefficients, dtype=np.float64)
    if (
        b.ndim != 1
        or b.size == 0
        or not np.all(np.isfinite(b))
        or not np.isfinite([low, high]).all()
        or low >= high
    ):
        raise ValueError(
            "a polynomial of position needs finite coefficients and a travel low < high, "
            f"found [{low:g}, {high:g}]"
        )
    powers = np.arange(1, b.size + 1)
    mean = float(np.sum(b * (high**powers - low**powers) / powers) / (high - low))
    if mean <= 0.0:
        raise ValueError(
            f"the polynomial's mean over [{low:g}, {high:g}] is {mean:g}; allowed: > 0"
        )
    return b / mean, mean


@lru_cache(maxsize=64)
def normalised_coefficients(
    coefficients: tuple[float, ...], low: float, high: float
) -> tuple[float, ...]:
    """Return the coefficients that `normalise` returns, from a cache.

    Raises ValueError as `normalise` does.
    """
    return tuple(map(float, normalise(np.array(coefficients), low, high)[0]))


def mean_over(
    coefficients: Sequence[float] | Vector, low: float, high: float, first: float, last: float
) -> float:
    """Return the mean over [first, last] of a polynomial that is constant outside [low, high].

    `first` must be below `last`.
    """
    curve = np.polynomial.Polynomial(coefficients)
    whole = curve.integ()
    start, end = min(max(first, low), high), min(max(last, low), high)
    below = max(0.0, min(last, low) - first)
    above = max(0.0, last - max(first, high))
    return float(below * curve(low) + whole(end) - whole(start) + above * curve(high)) / (
        last - first
    )


@lru_cache(maxsize=64)
def least_factor(coefficients: tuple[float, ...], low: float, high: float) -> tuple[float, float]:
    """Return position and value of the polynomial's minimum in [low, high], from a cache."""
    return minimum(normalised_coefficients(coefficients, low, high), low, high)
