"""Polynomial fit (thesis (4.44)) of a curve within the travel, of the lowest sufficient degree."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictool.documents.laws import MOST_COEFFICIENTS
from frictool.friction.polynomial_minimum import minimum
from frictool.typing import Vector

GOOD = 0.005  # sufficient error of the fit, relative to the mean of the curve
NODES = 400  # Chebyshev nodes
NOTHING = 1e-12  # largest omitted term at the ends of the travel, relative to the curve's mean


class PolynomialFit(NamedTuple):
    """Polynomial fitted to a curve.

    coefficients: coefficients, lowest power first [SI].
    error: largest absolute error [N m | N].
    """

    coefficients: tuple[float, ...]
    error: float


def fit_polynomial(x: Vector, values: Vector, over: tuple[float, float]) -> PolynomialFit:
    """Fit a nonnegative polynomial to the curve with `values` (n,) at x (n,).

    The fit is by least squares at Chebyshev nodes, so that the largest error is nearly as small as
    possible. A constant is added if the polynomial would be negative within `over`, a range that
    contains x. Negligible coefficients are set to 0; the error includes this change.
    """
    low, high = float(x[0]), float(x[-1])
    nodes = 0.5 * (low + high) + 0.5 * (high - low) * np.cos(
        np.pi * (np.arange(NODES) + 0.5) / NODES
    )
    wanted = np.interp(nodes, x, values)
    scale = max(abs(float(np.mean(values))), 1e-300)
    best: PolynomialFit | None = None
    for degree in range(MOST_COEFFICIENTS):
        series = np.polynomial.Polynomial.fit(nodes, wanted, degree, domain=[low, high])
        powers = series.convert().coef
        reach = max(abs(low), abs(high)) ** np.arange(len(powers))
        powers = np.where(np.abs(powers) * reach < NOTHING * scale, 0.0, powers)
        coefficients = tuple(
            float(b) for b in np.concatenate([powers, np.zeros(degree + 1 - len(powers))])
        )
        smallest = minimum(coefficients, *over)[1]
        coefficients = (coefficients[0] - min(0.0, smallest) * (1.0 + 1e-9), *coefficients[1:])
        error = float(np.max(np.abs(np.polynomial.Polynomial(coefficients)(x) - values)))
        if best is None or error < best.error:
            best = PolynomialFit(coefficients, error)
        if best.error <= GOOD * scale:
            break
    assert best is not None
    return best


def mean_of(coefficients: tuple[float, ...], low: float, high: float) -> float:
    """Return the mean of the polynomial from `low` to `high`."""
    whole = np.polynomial.Polynomial(coefficients).integ()
    return float((whole(high) - whole(low)) / (high - low))
