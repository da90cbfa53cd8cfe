"""Fixed-point coefficients: integer words, each with a separate number of fractional bits."""

from __future__ import annotations

import math

BITS = {"q31": 31, "q15": 15}  # bits of a coefficient, without its sign
FINEST = 60  # largest number of fractional bits


def round_coefficient(value: float, bits: int) -> float:
    """Return the value of a coefficient after rounding to a fixed-point word of `bits` bits."""
    word, fraction = coefficient(value, bits)
    return math.ldexp(word, -fraction)


def coefficient(value: float, bits: int) -> tuple[int, int]:
    """Return (word, fraction) of a fixed-point coefficient, value = word 2^-fraction.

    `bits` is the number of bits of the integer word without the sign. The fraction is the number of
    fractional bits; it is 0 for an integer that fits into the word.
    """
    if value == int(value) and abs(value) < 2**bits:
        return int(value), 0
    fraction = min(bits - math.frexp(value)[1], FINEST)
    word = round(math.ldexp(value, fraction))
    if word == 0:  # |value| is at most half of 2^-FINEST
        return 0, 0
    if abs(word) >= 2**bits:  # rounded up to the next power of two
        return round(math.ldexp(value, fraction - 1)), fraction - 1
    return word, fraction
