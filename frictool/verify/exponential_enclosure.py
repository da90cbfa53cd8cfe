"""Enclosures of the sampled axis's exponentials: integer polynomials in the viscous rate.

With the symbols of plant/linear_axis.py, the period T, sigma = s T and lambda = T/tau, the
zero-order hold of the axis is

    h_q(sigma, lambda) = sum over m, n of (-sigma)^m (-lambda)^n/(m + n + q)!

    drive+ = e i + (1 - e) u
    speed+ = h_0 v + k T (a i + (h_1 - a) u) - f T h_1 w
    eta+   = eta + T v_c - T h_1 v - k T^2 (b i + (h_2 - b) u) + f T^2 h_2 w

    e = h_0(0, lambda),  h_q = h_q(sigma, 0),  a = h_1(sigma, lambda),  b = h_2(sigma, lambda)

and h_0 = 1 - sigma h_1. Each h_q is a sum of decaying exponentials with nonnegative weights, whose
sum is at most 1. Apart from the sign, the derivatives of h_q are also such sums. The remainder of a
Taylor polynomial about the middle of an interval is therefore bounded. All operations use integers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from frictool.errors import NoSolutionError

BITS = 96  # bits of an enclosure below the binary point
ONE = 1 << BITS
LARGEST = 64  # limit of lambda and |sigma|; above it, the lag or the inertia is negligible
DEGREE = 14  # degree of the polynomials; on an interval of width 1 the remainder is below 1e-16
Series = Callable[[int, Fraction], tuple[Fraction, Fraction]]


@dataclass(frozen=True)
class HoldPolynomials:
    """Polynomials of h_1, h_2, a and b in sigma - `middle`, and bounds of their errors.

    The module docstring defines the symbols.

    - coefficients: coefficients of each polynomial, lowest power first
    - errors: error bound of each polynomial
    - kept: e, with an error of at most `kept_error`
    """

    middle: Fraction
    coefficients: tuple[tuple[Fraction, ...], ...]
    errors: tuple[Fraction, ...]
    kept: Fraction
    kept_error: Fraction


def check_range(ratio: Fraction, low: Fraction, high: Fraction) -> None:
    """Raise NoSolutionError if the period is too long for the lag or the time constant J/sigma_v.

    - ratio: sample period divided by the lag
    - low, high: interval of sigma, the sample period times the viscous rate sigma_v/J

    The absolute values of `ratio`, `low` and `high` must be at most LARGEST.
    """
    if ratio > LARGEST or max(abs(low), abs(high)) > LARGEST:
        what = "actuator.loop_time_constant_s" if ratio > LARGEST else "inertia/viscous"
        raise NoSolutionError(
            f"no certificate: the time constant {what} is below 1/{LARGEST} of the sample period; "
            "allowed: a longer time constant, or 0"
        )


def hold_polynomials(ratio: Fraction, low: Fraction, high: Fraction) -> HoldPolynomials:
    """Return the polynomials of the module docstring for low <= sigma <= high <= low + 1.

    ratio: lambda, the period divided by the drive's lag; 0 for a drive without lag.
    """
    largest = max(abs(low), abs(high))
    middle = Fraction(float((low + high) / 2))
    half = max(high - middle, middle - low)
    polynomials, errors = [], []
    for q, lagged in ((1, False), (2, False), (1, True), (2, True)):
        series = exponential_series(q, ratio if lagged else Fraction(0), math.ceil(largest))
        terms = [series(order, middle) for order in range(DEGREE + 1)]
        factorials = [math.factorial(order) for order in range(DEGREE + 2)]
        polynomials.append(
            tuple(centre / factorials[order] for order, (centre, _) in enumerate(terms))
        )
        error = growth(low) * half ** (DEGREE + 1) / factorials[-1]
        for order, (_, radius) in enumerate(terms):
            error += radius / factorials[order] * half**order
        errors.append(error)
    kept, kept_error = exponential_series(0, ratio, 0)(0, Fraction(0))
    return HoldPolynomials(middle, tuple(polynomials), tuple(errors), kept, kept_error)


def growth(low: Fraction) -> Fraction:
    """Return an upper bound of exp(-sigma x) for sigma >= low and 0 <= x <= 1.

    The bound also applies to h_q and to the derivatives of h_q.
    """
    return Fraction(1 if low >= 0 else 3 ** math.ceil(-low))


@lru_cache(maxsize=64)
def exponential_series(q: int, ratio: Fraction, largest: int) -> Series:
    """Return a function of (order, sigma) that computes the derivatives of h_q(., ratio).

    The order of the derivative is at most DEGREE, and |sigma| at most `largest`. The function
    returns the derivative and a bound of its error, below 2^-94. Two recursions compute the sums:

        v_j = 1 - ratio/j v_(j+1),    0 <= v_j <= 1
        H_m = m!/(m+q)! v_(m+q+1) - sigma/(m+1) H_(m+1),    |H_m| <= exp(|sigma|),    h_q = H_0

    The sum over n of (-ratio)^n/(m + n + q)! is v_(m+q+1)/(m+q)!. Each recursion starts at a term
    whose bound is negligible. The recursions multiply an error of the last bit by at most exp(ratio
    + sigma).
    """
    guard = BITS + 32 + 4 * math.ceil(ratio) + 4 * largest
    one = 1 << guard
    terms = 64 + 4 * largest
    inner = _nested(ratio, terms + DEGREE + q + 1, one)

    def derivative(order: int, sigma: Fraction) -> tuple[Fraction, Fraction]:
        size = abs(sigma)
        centre = 0
        radius = one * 3 ** math.ceil(size)
        for m in range(terms, -1, -1):
            shifted = m + order
            scale = math.perm(shifted + q, q)
            v, v_radius = inner[shifted + q + 1]
            centre = v // scale - centre * sigma.numerator // (sigma.denominator * (m + 1))
            radius = v_radius // scale + radius * size.numerator // (size.denominator * (m + 1)) + 4
        shift = guard - BITS
        return Fraction((-1) ** order * (centre >> shift), ONE), Fraction(
            (radius >> shift) + 2, ONE
        )

    return derivative


def _nested(ratio: Fraction, last: int, one: int) -> dict[int, tuple[int, int]]:
    """Return integers (centre, radius) that enclose v_j times `one`, for each j up to `last`.

    `exponential_series` defines v_j.

    - one: power of 2 that scales numbers to integers
    """
    begun = last + 64 + 4 * math.ceil(ratio)
    enclosures = {begun: (one >> 1, (one >> 1) + 1)}
    for j in range(begun - 1, 0, -1):
        (centre, radius), below = enclosures[j + 1], ratio.denominator * j
        enclosures[j] = (
            one - centre * ratio.numerator // below,
            radius * ratio.numerator // below + 2,
        )
    return enclosures
