"""Interval arithmetic in integers: centre +- radius, both in units of 2^-BITS.

No floating-point operation takes part. The centre of a product is rounded, and its radius is
increased by the possible rounding error, so that the interval always holds the true value. Scalars
are Python integers, matrices are NumPy arrays of them (dtype object).
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
    """Number or array whose entries lie within `radius` of `centre`, in units of 2^-BITS.

    Both fields are ints, or arrays of one shape.
    """

    centre: Integers
    radius: Integers

    @staticmethod
    def of(value: float | Fraction | int) -> Enclosure:
        """Return the enclosure of a number.

        It is exact for a multiple of 2^-BITS, such as a double above 2^-43.
        """
        scaled = Fraction(value) * ONE
        centre = round(scaled)
        return Enclosure(centre, int(scaled != centre))

    @staticmethod
    def matrix(rows: Any) -> Enclosure:
        """Return the enclosure of an array of numbers of any shape."""
        cells = np.asarray(rows, dtype=object)
        enclosures = [Enclosure.of(value) for value in cells.ravel()]
        centre, radius = (
            np.empty(len(enclosures), dtype=object),
            np.empty(len(enclosures), dtype=object),
        )
        for index, one in enumerate(enclosures):
            centre[index], radius[index] = one.centre, one.radius
        return Enclosure(centre.reshape(cells.shape), radius.reshape(cells.shape))

    @staticmethod
    def stacked(rows: list[Enclosure]) -> Enclosure:
        """Return rows of equal length as a matrix."""
        return Enclosure(
            np.array([row.centre for row in rows], dtype=object),
            np.array([row.radius for row in rows], dtype=object),
        )

    def widened(self, ulps: int) -> Enclosure:
        """Return the enclosure with a radius larger by `ulps` units of 2^-BITS."""
        return Enclosure(self.centre, self.radius + ulps)

    def __add__(self, other: Enclosure) -> Enclosure:
        return Enclosure(self.centre + other.centre, self.radius + other.radius)

    def __sub__(self, other: Enclosure) -> Enclosure:
        return Enclosure(self.centre - other.centre, self.radius + other.radius)

    def __mul__(self, other: Enclosure) -> Enclosure:
        """Multiply entry by entry; either factor may be a scalar."""
        a = self.centre
        r = self.radius
        b = other.centre
        q = other.radius
        return Enclosure(a * b >> BITS, (abs(a) * q + r * (abs(b) + q) >> BITS) + 2)

    def __matmul__(self, other: Enclosure) -> Enclosure:
        a = self.centre
        r = self.radius
        b = other.centre
        q = other.radius
        return Enclosure(a @ b >> BITS, (abs(a) @ q + r @ (abs(b) + q) >> BITS) + 2)
