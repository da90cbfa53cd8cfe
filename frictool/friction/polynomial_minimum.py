"""The minimum of a polynomial over an interval.

The minimum lies at an end or at a zero of the derivative. The zeros of a derivative of degree 1 or
2 have a closed form. A derivative of a higher degree has at most one zero between two neighbouring
zeros of its own derivative; these zeros are computed recursively. The usual method, the eigenvalues
of a companion matrix, would lose all digits if the highest coefficient is nearly zero.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from frictool.typing import Vector

# largest number of Newton steps; a step that leaves the bracket is replaced by a bisection. About
# six steps suffice, but near a zero of order six, four steps gain one bit only.
STEPS = 200


def minimum(coefficients: Sequence[float] | Vector, low: float, high: float) -> tuple[float, float]:
    """Return position and value of the polynomial's minimum in [low, high].

    The coefficients are finite, lowest power first.
    """
    b = [float(one) for one in coefficients]
    position = float(low)
    smallest = _at(b, low)
    for x in (float(high), *sign_changes(_derivative(b), low, high)):
        value = _at(b, x)
        if value < smallest:
            position, smallest = x, value
    return position, smallest


def _at(b: list[float], x: float) -> float:
    total = 0.0
    for one in reversed(b):
        total = total * x + one
    return total


def _derivative(b: list[float]) -> list[float]:
    return [power * one for power, one in enumerate(b)][1:]


def sign_changes(b: list[float], low: float, high: float) -> list[float]:
    """Return the arguments in [low, high] at which a polynomial changes sign, in rising order.

    The result may also contain double zeros, at which the polynomial is 0 without a change of sign.
    """
    while b and b[-1] == 0.0:
        b = b[:-1]
    if len(b) <= 3:
        return sorted(x for x in _zeros(b) if low <= x <= high)
    slope = _derivative(b)
    edges = [low, *sign_changes(slope, low, high), high]
    return [
        _between(b, slope, *ends)
        for ends in pairwise(edges)
        if (_at(b, ends[0]) < 0.0) != (_at(b, ends[1]) < 0.0)
    ]


def _zeros(b: list[float]) -> list[float]:
    """Return the real zeros of a polynomial of degree 2 or less with a leading coefficient != 0."""
    if len(b) < 3:
        return [-b[0] / b[1]] if len(b) == 2 else []
    most = max(map(abs, b))
    c = b[0] / most
    half = 0.5 * b[1] / most
    a = b[2] / most
    inside = half * half - a * c
    if inside < 0.0:
        return []
    # avoids cancellation: both zeros have full precision
    q = -(half + math.copysign(math.sqrt(inside), half))
    return [one / other for one, other in ((q, a), (c, q)) if other != 0.0]


def _between(b: list[float], slope: list[float], first: float, last: float) -> float:
    below = _at(b, first) < 0.0
    x = 0.5 * (first + last)
    for _ in range(STEPS):
        value, steep = _at(b, x), _at(slope, x)
        first, last = (x, last) if (value < 0.0) == below else (first, x)
        following = x - value / steep if steep != 0.0 else first
        if not first < following < last:
            following = 0.5 * (first + last)
        if following == x:
            break
        x = following
    return x
