"""Kernels of friction as a polynomial of position (position_polynomial.py)."""

from __future__ import annotations

from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def polynomial(coefficients: Vector, x: float) -> float:
    """Return sum_i coefficients[i] x^i, by Horner's rule."""
    total = 0.0
    for i in range(coefficients.shape[0] - 1, -1, -1):
        total = total * x + coefficients[i]
    return total


@kernel
def position_factor(coefficients: Vector, low: float, high: float, x: float) -> float:
    """Return the factor >= 0 of Coulomb friction and breakaway at a position x [m | rad].

    Outside the travel [low, high], the factor is that of the nearer end.
    """
    return max(0.0, polynomial(coefficients, min(max(x, low), high)))
