"""Sampled axis for every drive rate k and viscous rate s of a rectangle, in interval arithmetic.

No floating-point operation takes part. With sigma = s T and lambda = T/tau, the zero-order hold of
linear_axis.py is

    h_q(sigma, lambda) = sum over m, n of (-sigma)^m (-lambda)^n/(m + n + q)!

    drive+ = e i + (1 - e) u
    speed+ = h_0 v + k T (a i + (h_1 - a) u) - f T h_1 w
    eta+   = eta + T v_c - T h_1 v - k T^2 (b i + (h_2 - b) u) + f T^2 h_2 w

    e = h_0(0, lambda),  h_q = h_q(sigma, 0),  a = h_1(sigma, lambda),  b = h_2(sigma, lambda)

Each h_q is a sum of decaying exponentials whose weights are nonnegative and sum to at most one.
Apart from the sign, the same holds for the derivatives of h_q. Over the rectangle, each h_q differs
from a cubic in sigma by at most w^4/384, where w is T times the width of the rectangle in s. The
axis therefore lies in the convex hull of eight corners, widened by that remainder: two ends in k
times the four Bernstein control points of the cubics in s.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from frictool.errors import NoSolutionError
from frictool.verify.interval_arithmetic import BITS, Enclosure

# limit of lambda and |sigma|: above it the series is long, and the axis is better described without
# that lag or that mass
LARGEST = 64
CONTROL_POINTS = 4


@dataclass(frozen=True)
class EnclosedAxis:
    """Coefficients of the axis at one corner, each an Enclosure of a number.

    If `lagless` is set, the drive equals the command.
    """

    lagless: bool
    kept_drive: Enclosure
    kept_speed: Enclosure
    speed_from_drive: Enclosure
    speed_from_command: Enclosure
    speed_from_friction: Enclosure
    eta_from_speed: Enclosure
    eta_from_drive: Enclosure
    eta_from_command: Enclosure
    eta_from_friction: Enclosure


def corners(
    drive: tuple[Fraction, Fraction],
    viscous: tuple[Fraction, Fraction],
    friction: tuple[Fraction, Fraction],
    lag: float,
    period: float,
) -> list[EnclosedAxis]:
    """Return the eight corners of the axis for k in `drive` and s in `viscous`.

    The order is the low end in k with the four control points in s, then the high end. `friction`
    has the rates f at the two ends in k; f is linear in k between them. Raises NoSolutionError if
    the lag or 1/s is too short against the period for the series.
    """
    t = Fraction(period)
    ratio = t / Fraction(lag) if lag else Fraction(0)
    low, high = (s * t for s in viscous)
    largest = max(abs(low), abs(high))
    if ratio > LARGEST or largest > LARGEST:
        what = "actuator.loop_time_constant_s" if ratio > LARGEST else "inertia/viscous"
        raise NoSolutionError(
            f"no certificate: {what} is below 1/{LARGEST} of the sample period; allowed: above "
            "it, or no lag at all"
        )
    points = {
        (q, lagged): cubic(q, ratio if lagged else Fraction(0), low, high)
        for q, lagged in _FUNCTIONS
    }
    e = exponential_series(0, ratio, 0)(0, Fraction(0))
    zero = Enclosure.of(0)
    step = Enclosure.of(t)
    corner_plants = []
    for k, f in zip(drive, friction, strict=True):
        k_t, f_t = Enclosure.of(k) * step, Enclosure.of(f) * step
        for index in range(CONTROL_POINTS):
            h_0, h_1, h_2, a, b = (points[key][index] for key in _FUNCTIONS)
            if not lag:
                a, b = zero, zero
            corner_plants.append(
                EnclosedAxis(
                    lagless=not lag,
                    kept_drive=e if lag else zero,
                    kept_speed=h_0,
                    speed_from_drive=k_t * a,
                    speed_from_command=k_t * (h_1 - a),
                    speed_from_friction=zero - f_t * h_1,
                    eta_from_speed=zero - step * h_1,
                    eta_from_drive=zero - step * k_t * b,
                    eta_from_command=zero - step * k_t * (h_2 - b),
                    eta_from_friction=step * f_t * h_2,
                )
            )
    return corner_plants


_FUNCTIONS = ((0, False), (1, False), (2, False), (1, True), (2, True))  # h_0, h_1, h_2, a, b


def cubic(q: int, ratio: Fraction, low: Fraction, high: Fraction) -> list[Enclosure]:
    """Return four control points of h_q(., ratio) between `low` and `high`.

    At any sigma the function equals the Bernstein form of some p_i in the enclosures, all with the
    same remainder from their centres.
    """
    series = exponential_series(q, ratio, math.ceil(max(abs(low), abs(high))))
    middle = (low + high) / 2
    half = (high - low) / 2
    # c_0 + c_1 y + c_2 y^2 + c_3 y^3, sigma = middle + y half
    c = [
        series(order, middle) * Enclosure.of(half**order / math.factorial(order))
        for order in range(4)
    ]
    third = Enclosure.of(Fraction(1, 3))
    inner = (c[1] * third) - c[3]
    outer = c[1] + c[3]
    even = c[0] - c[2] * third
    sum_even = c[0] + c[2]
    ulps = math.ceil(_growth(low) * half**4 / 24 * (1 << BITS))
    return [
        point.widened(ulps)
        for point in (sum_even - outer, even - inner, even + inner, sum_even + outer)
    ]


def _growth(low: Fraction) -> int:
    """Return a bound of exp(-sigma x) for sigma >= low and 0 <= x <= 1.

    It also bounds h_q and its derivatives.
    """
    return 1 if low >= 0 else 3 ** math.ceil(-low)


@lru_cache(maxsize=64)
def exponential_series(
    q: int, ratio: Fraction, largest: int
) -> Callable[[int, Fraction], Enclosure]:
    """Return the function (order, sigma) -> derivative of h_q(., ratio), for orders 0 to 3.

    The modulus of sigma is at most `largest`. Both sums are nested products that start at a term
    whose bound is negligible. The inner one uses 0 <= v_j <= 1 in v_j = 1 - ratio/j v_(j+1), with
    which the sum over n of (-ratio)^n/(m + n + q)! is v_(m+q+1)/(m+q)!. The outer one uses the
    bound exp(|sigma|) of H_m in H_m = m!/(m+q)! v_(m+q+1) - sigma/(m+1) H_(m+1), with which h_q =
    H_0. An error of the last bit grows by exp(ratio + sigma) at most.
    """
    guard = BITS + 32 + 4 * math.ceil(ratio) + 4 * largest
    one = 1 << guard
    terms = 64 + 4 * largest
    inner = _nested(ratio, terms + 3 + q + 1, one)

    def derivative(order: int, sigma: Fraction) -> Enclosure:
        size = abs(sigma)
        centre = 0
        radius = one * 3 ** math.ceil(size)
        for m in range(terms, -1, -1):
            shifted = m + order
            scale = math.factorial(shifted + q) // math.factorial(shifted)
            v, v_radius = inner[shifted + q + 1]
            centre = v // scale - centre * sigma.numerator // (sigma.denominator * (m + 1))
            radius = v_radius // scale + radius * size.numerator // (size.denominator * (m + 1)) + 4
        shift = guard - BITS
        return Enclosure((-1) ** order * (centre >> shift), (radius >> shift) + 2)

    return derivative


def _nested(ratio: Fraction, last: int, one: int) -> dict[int, tuple[int, int]]:
    """Return centre and radius of v_j, times `one`, for j up to `last`."""
    begun = last + 64 + 4 * math.ceil(ratio)
    enclosures = {begun: (one >> 1, (one >> 1) + 1)}
    for j in range(begun - 1, 0, -1):
        (centre, radius), below = enclosures[j + 1], ratio.denominator * j
        enclosures[j] = (
            one - centre * ratio.numerator // below,
            radius * ratio.numerator // below + 2,
        )
    return enclosures
