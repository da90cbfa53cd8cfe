"""Where over a travel a polynomial is least: at an end, or where its derivative changes sign.

The zeros of a derivative of up to the second degree are written down; those of a higher one lie one
each between the zeros of its own derivative, and so on down. Scalars: a campaign asks it of every
plant that it draws. Eigenvalues of a companion matrix, beside taking twenty times as long, lose all
digits where the highest coefficient is next to nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
# Newton's, halving where they leave the bracket: some six, and a zero of the sixth order gains a
# bit in four
STEPS = 200


def minimum(coefficients: Sequence[float] | Vector, low: float, high: float) -> tuple[float, float]:
    """The place in [low, high] and the value there; coefficients finite, lowest power first."""
    b = [float(one) for one in coefficients]
    place, smallest = float(low), _at(b, low)
    for x in (float(high), *sign_changes(_derivative(b), low, high)):
        value = _at(b, x)
        if value < smallest:
            place, smallest = x, value
    return place, smallest


def _at(b: list[float], x: float) -> float:
    total = 0.0
    for one in reversed(b):
        total = total * x + one
    return total


def _derivative(b: list[float]) -> list[float]:
    return [power * one for power, one in enumerate(b)][1:]


def sign_changes(b: list[float], low: float, high: float) -> list[float]:
    """Return the zeros in [low, high], rising, at which a polynomial changes sign.

    A zero at which it only touches zero may be among them. Coefficients: lowest power first.
    """
    while b and b[-1] == 0.0:
        b = b[:-1]
    if len(b) <= 3:
        return sorted(x for x in _zeros(b) if low <= x <= high)
    slope = _derivative(b)
    places = [low, *sign_changes(slope, low, high), high]
    return [
        _between(b, slope, *ends)
        for ends in pairwise(places)
        if (_at(b, ends[0]) < 0.0) != (_at(b, ends[1]) < 0.0)
    ]


def _zeros(b: list[float]) -> list[float]:
    """The real zeros of a polynomial of up to the second degree, whose highest coefficient is not
    zero."""
    if len(b) < 3:
        return [-b[0] / b[1]] if len(b) == 2 else []
    most = max(map(abs, b))
    c, half, a = b[0] / most, 0.5 * b[1] / most, b[2] / most
    inside = half * half - a * c
    if inside < 0.0:
        return []
    q = -(
        half + math.copysign(math.sqrt(inside), half)
    )  # no difference of near numbers: both zeros to full precision
    return [one / other for one, other in ((q, a), (c, q)) if other != 0.0]


def _between(b: list[float], slope: list[float], first: float, last: float) -> float:
    """The zero in [first, last], over which the polynomial rises or falls throughout and changes
    sign."""
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
