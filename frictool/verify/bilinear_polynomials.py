"""Exact polynomials of a controller's stored coefficients after a bilinear transform.

    C(z) = N(z)/A(z),   z = (q + p)/(q - p):   C = sum n_j p^j q^(m - j) / sum a_j p^j q^(m - j)

m is the number of states, and p/q the bilinear variable (z - 1)/(z + 1). A is the characteristic
polynomial of the complete state matrix, including states that do not affect the output. All
arithmetic uses integers and fractions.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import comb
from typing import Any

import numpy as np

from frictool.documents.controller import StateSpace

Polynomial = list[Fraction]  # coefficients, lowest power first


def of_state_space(controller: StateSpace) -> tuple[Polynomial, Polynomial]:
    """Return the exact numerator and denominator of a controller, as polynomials in z.

    The function uses the algorithm of Faddeev and Le Verrier. The state matrix is first multiplied
    by a power of two that makes its entries integers. The divisions of the algorithm then have no
    remainder.
    """
    n = len(controller.a)
    scale = _scale([value for row in controller.a for value in row])
    a = _integers(controller.a, n, n, scale)
    b = [Fraction(value) for (value,) in controller.b]
    c = [Fraction(value) for value in controller.c[0]] if n else []
    direct = Fraction(controller.d[0][0])
    matrix = _integers(np.identity(n).tolist(), n, n, 1)
    denominator, numerator = [Fraction(1)], [direct]  # highest power first
    for k in range(1, n + 1):
        through = sum(
            (c[i] * int(matrix[i, j]) * b[j] for i in range(n) for j in range(n)), Fraction(0)
        )
        product = a @ matrix
        coefficient = -int(np.trace(product)) // k
        matrix = product + coefficient * _integers(np.identity(n).tolist(), n, n, 1)
        denominator.append(Fraction(coefficient, scale**k))
        numerator.append(through / scale ** (k - 1) + direct * denominator[-1])
    return numerator[::-1], denominator[::-1]


def of_sections(sections: Sequence[Sequence[float]]) -> tuple[Polynomial, Polynomial]:
    """Return the exact numerator and denominator in z of second-order sections b0 b1 b2 1 a1 a2.

    A section with b2 = a2 = 0 has one state, or none if also b1 = a1 = 0.
    """
    numerator, denominator = [Fraction(1)], [Fraction(1)]
    for section in sections:
        order = section_order(section)
        numerator = product(numerator, [Fraction(x) for x in section[order::-1]])
        ones = [Fraction(x) for x in (1.0, *section[4:])]
        denominator = product(denominator, ones[order::-1])
    return numerator, denominator


def section_order(section: Sequence[float]) -> int:
    """Return the number of states (0, 1 or 2) of a second-order section b0 b1 b2 1 a1 a2."""
    _, b1, b2, _, a1, a2 = section
    return 2 if b2 or a2 else int(bool(b1 or a1))


def on_circle(polynomial: Polynomial) -> Polynomial:
    """Return the coefficients of p^j q^(m - j) in (q - p)^m f((q + p)/(q - p)).

    f is the polynomial in z of degree m with the coefficients `polynomial`.
    """
    m = len(polynomial) - 1
    mapped = [Fraction(0)] * (m + 1)
    for power, value in enumerate(polynomial):
        if value:
            for j, count in enumerate(_binomials(power, m - power)):
                mapped[j] += value * count
    return mapped


def _binomials(plus: int, minus: int) -> list[int]:
    return [
        sum(
            comb(plus, j - i) * comb(minus, i) * (-1) ** i
            for i in range(max(0, j - plus), min(minus, j) + 1)
        )
        for j in range(plus + minus + 1)
    ]


def product(x: Polynomial, y: Polynomial) -> Polynomial:
    """Return the product of two polynomials; their coefficients belong to p^j q^(degree - j)."""
    whole = [Fraction(0)] * (len(x) + len(y) - 1)
    for i, one in enumerate(x):
        for j, other in enumerate(y):
            whole[i + j] += one * other
    return whole


def total(x: Polynomial, y: Polynomial) -> Polynomial:
    """Return the sum of two polynomials with the same number of coefficients."""
    return [one + other for one, other in zip(x, y, strict=True)]


def _scale(values: Sequence[float]) -> int:
    return max((Fraction(value).denominator for value in values), default=1)


def _integers(rows: Sequence[Sequence[float]], n: int, m: int, scale: int) -> Any:
    matrix = np.zeros((n, m), dtype=object)
    for i, row in enumerate(rows):
        matrix[i] = [int(Fraction(value) * scale) for value in row]
    return matrix
