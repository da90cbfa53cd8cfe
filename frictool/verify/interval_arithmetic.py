"""Numbers known to lie in an interval, as integers: centre +- radius, both times 2^-BITS. No
floating-point operation takes part.

A product's centre is rounded, and what rounding may have cost is added to its radius, so that the
interval always holds the true value. Scalars are Python integers, matrices NumPy arrays of them
(dtype object).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

BITS = 96
ONE = 1 << BITS
Integers = Any  # an int, or an array of Python integers (dtype object)


@dataclass(frozen=True)
class Enclosure:
    """Every entry lies within `radius` of `centre`, in units of 2^-BITS; both an int, or both
    arrays of one shape."""

    centre: Integers
    radius: Integers

    @staticmethod
    def of(value: float | Fraction | int) -> Enclosure:
        """A number: exact where it is a multiple of 2^-BITS, as a double above 2^-43 is."""
        scaled = Fraction(value) * ONE
        centre = round(scaled)
        return Enclosure(centre, int(scaled != centre))

    @staticmethod
    def matrix(rows: Any) -> Enclosure:
        """Of an array of numbers, of any shape."""
        cells = np.asarray(rows, dtype=object)
        found = [Enclosure.of(value) for value in cells.ravel()]
        centre, radius = np.empty(len(found), dtype=object), np.empty(len(found), dtype=object)
        for index, one in enumerate(found):
            centre[index], radius[index] = one.centre, one.radius
        return Enclosure(centre.reshape(cells.shape), radius.reshape(cells.shape))

    @staticmethod
    def stacked(rows: list[Enclosure]) -> Enclosure:
        """Rows of equal length as a matrix."""
        return Enclosure(
            np.array([row.centre for row in rows], dtype=object),
            np.array([row.radius for row in rows], dtype=object),
        )

    def widened(self, ulps: int) -> Enclosure:
        """With `ulps` units of 2^-BITS more on each side."""
        return Enclosure(self.centre, self.radius + ulps)

    def __add__(self, other: Enclosure) -> Enclosure:
        return Enclosure(self.centre + other.centre, self.radius + other.radius)

    def __sub__(self, other: Enclosure) -> Enclosure:
        return Enclosure(self.centre - other.centre, self.radius + other.radius)

    def __mul__(self, other: Enclosure) -> Enclosure:
        """Entry by entry; either may be a scalar."""
        a, r, b, q = self.centre, self.radius, other.centre, other.radius
        return Enclosure(a * b >> BITS, (abs(a) * q + r * (abs(b) + q) >> BITS) + 2)

    def __matmul__(self, other: Enclosure) -> Enclosure:
        a, r, b, q = self.centre, self.radius, other.centre, other.radius
        return Enclosure(a @ b >> BITS, (abs(a) @ q + r @ (abs(b) + q) >> BITS) + 2)
