"""Integrals of decaying exponentials, accurate also for rates that are zero, equal or nearly equal.

For x <= 0:   phi1(x) = (e^x - 1)/x        phi2(x) = (e^x - 1 - x)/x^2
For two rates a, b >= 0 over a time t:
    convolved(a, b, t) = int_0^t e^{-a (t-s)} e^{-b s} ds                  two lags in series
    convolved_integral(a, b, t) = int_0^t convolved(a, b, s) ds
"""

from __future__ import annotations

import math

from frictool.runtime.kernels import kernel

SMALL = 0.6  # |x| below which a power series is used; above, the formula loses less than three bits
NEGLIGIBLE = 2.0**-56  # term at which a series ends; the sum of the series is above 1/4
NEAR = 0.02  # relative difference of two rates below which their mean is used
# Gauss-Legendre, 4 points on [0, 1]
NODES = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970263)
WEIGHTS = (0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692)


@kernel
def phi1(x: float) -> float:
    """Return (e^x - 1)/x."""
    return 1.0 if x == 0.0 else math.expm1(x) / x


@kernel
def phi2(x: float) -> float:
    """Return (e^x - 1 - x)/x^2."""
    if abs(x) > SMALL:
        return (math.expm1(x) - x) / (x * x)
    total, term = 0.5, 0.5
    for k in range(3, 20):
        term *= x / k
        total += term
        if abs(term) < NEGLIGIBLE:
            break
    return total


@kernel
def phi1_slope(x: float) -> float:
    """Return the derivative of phi1: int_0^1 s e^{x s} ds."""
    if abs(x) > SMALL:
        return (math.exp(x) - phi1(x)) / x
    total, term = 0.5, 1.0
    for k in range(1, 20):
        term *= x / k
        total += term / (k + 2)
        if abs(term) < NEGLIGIBLE:
            break
    return total


@kernel
def convolved(a: float, b: float, t: float) -> float:
    """Return int_0^t e^{-a (t-s)} e^{-b s} ds [s] for the rates a, b [1/s]."""
    return math.exp(-min(a, b) * t) * t * phi1(-abs(a - b) * t)


@kernel
def convolved_integral(a: float, b: float, t: float) -> float:
    """Return int_0^t convolved(a, b, s) ds [s^2]."""
    p, q = -a * t, -b * t
    gap = q - p
    if abs(gap) > NEAR * max(1.0, abs(p)):
        return t * t * (phi1(q) - phi1(p)) / gap
    total = 0.0
    for k in range(4):
        total += WEIGHTS[k] * phi1_slope(p + NODES[k] * gap)
    return t * t * total
