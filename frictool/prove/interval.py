"""Intervals of doubles with outward rounding.

A rounded sum or product of doubles differs from the real value by at most half a unit in the last
place (IEEE 754, rounding to nearest). The next doubles on both sides therefore enclose the real
value.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nextafter


@dataclass(slots=True, unsafe_hash=True)  # frozen intervals take twice the time to make
class RoundedInterval:
    """Closed interval [low, high] of real numbers (immutable)."""

    low: float
    high: float

    def __add__(self, other: RoundedInterval) -> RoundedInterval:
        return RoundedInterval(
            nextafter(self.low + other.low, -inf), nextafter(self.high + other.high, inf)
        )

    def __sub__(self, other: RoundedInterval) -> RoundedInterval:
        return RoundedInterval(
            nextafter(self.low - other.high, -inf), nextafter(self.high - other.low, inf)
        )

    def __mul__(self, other: RoundedInterval) -> RoundedInterval:
        if self.low >= 0.0 and other.low >= 0.0:
            return RoundedInterval(
                nextafter(self.low * other.low, -inf), nextafter(self.high * other.high, inf)
            )
        a, b, c, d = (
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        )
        return RoundedInterval(nextafter(min(a, b, c, d), -inf), nextafter(max(a, b, c, d), inf))

    def __truediv__(self, other: RoundedInterval) -> RoundedInterval:
        if other.low <= 0.0 <= other.high:
            raise ZeroDivisionError("the divisor contains 0")
        if other.low > 0.0:
            low = self.low / (other.high if self.low >= 0.0 else other.low)
            high = self.high / (other.low if self.high >= 0.0 else other.high)
            return RoundedInterval(nextafter(low, -inf), nextafter(high, inf))
        a, b, c, d = (
            self.low / other.low,
            self.low / other.high,
            self.high / other.low,
            self.high / other.high,
        )
        return RoundedInterval(nextafter(min(a, b, c, d), -inf), nextafter(max(a, b, c, d), inf))

    def __neg__(self) -> RoundedInterval:
        return RoundedInterval(-self.high, -self.low)

    @property
    def width(self) -> float:
        """Return an upper bound of high - low."""
        return nextafter(self.high - self.low, inf)

    @property
    def magnitude(self) -> float:
        """Return the largest absolute value of the numbers in the interval."""
        return max(abs(self.low), abs(self.high))

    def hull(self, other: RoundedInterval) -> RoundedInterval:
        """Return the smallest interval that contains this interval and `other`."""
        return RoundedInterval(min(self.low, other.low), max(self.high, other.high))

    def clipped(self, low: float, high: float) -> RoundedInterval:
        """Return the interval of min(max(x, low), high) for all x in this interval."""
        return RoundedInterval(min(max(self.low, low), high), min(max(self.high, low), high))


ZERO = RoundedInterval(0.0, 0.0)


def point(value: float) -> RoundedInterval:
    """Return the interval that contains only the double `value`."""
    return RoundedInterval(value, value)


WHOLE = tuple(point(float(n)) for n in range(64))  # exact whole numbers, for the terms of series


def decay(rate_time: RoundedInterval) -> RoundedInterval:
    """Return an enclosure of e^-x for an interval of x >= 0, from a Taylor series."""
    halvings = 0
    x = rate_time
    while x.high > 0.5:
        x = RoundedInterval(0.5 * x.low, 0.5 * x.high)
        halvings += 1
    low = high = ZERO
    # the terms alternate and fall, so that two successive partial sums enclose the value
    total, term = point(1.0), point(1.0)
    for n in range(1, 24):
        term = term * x / WHOLE[n]
        low, high = (total - term, total) if n % 2 else (total, total + term)
        total = total - term if n % 2 else total + term
    value = RoundedInterval(max(0.0, min(low.low, high.low)), max(low.high, high.high))
    for _ in range(halvings):
        value = value * value
    return RoundedInterval(max(0.0, value.low), min(1.0, value.high) if rate_time.low >= 0 else inf)
