"""Decimal text to the nearest double, exactly rounded.

    text = digits [mark digits] [e exponent]  ->  w * 10^q,  w the digits as a whole number

Two ways are fast, and a text that neither decides is left to Python:

- w < 2^53 and |q| <= 22: both factors are doubles, so that one multiplication or division rounds once (W. D. Clinger, 1990);
- else the leading 64 bits of w * 5^q from a table of the powers' leading 64 bits. What the table cuts off moves the product by less
  than 2 units of its last place: only where it lies that close to half-way between two doubles is the rounding unknown, about once in
  500 (D. Lemire, Number parsing at a gigabyte per second, 2021, decides those from 128 bits).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.kernels import inner_kernel

NUMBER, UNDECIDED, NO_NUMBER = 0, 1, 2  # status: the value is right; a number that Python has to round; no number

MOST_DIGITS = 19  # of 10^19 < 2^64
LOWEST, HIGHEST = -300, 288  # powers of ten that neither under- nor overflow, whatever the 19 digits
LARGEST_EXPONENT = 100_000  # beyond, the digits are not counted on: Python says 0 or inf

TENS = np.array([10.0**power for power in range(23)])
POINT, PLUS, MINUS, ZERO, SMALL_E, BIG_E = (ord(sign) for sign in ".+-0eE")
_ONE = np.uint64(1)
_HALF = np.uint64(32)
_LOW = np.uint64(0xFFFFFFFF)
_TOP = np.uint64(1 << 63)
_EXACT = np.uint64(1 << 53)


def _fives() -> tuple[NDArray[np.uint64], NDArray[np.int64]]:
    """The leading 64 bits of 5^q, cut off, and the power of two that they are multiplied by."""
    leading, shifts = [], []
    for power in range(LOWEST, HIGHEST + 1):
        if power >= 0:
            shift = (5**power).bit_length() - 64
            leading.append(5**power >> shift if shift >= 0 else 5**power << -shift)
        else:
            shift = -63 - (5**-power - 1).bit_length()
            leading.append((1 << -shift) // 5**-power)
        shifts.append(shift)
    return np.array(leading, np.uint64), np.array(shifts, np.int64)


FIVES, SHIFTS = _fives()


@inner_kernel
def rounded(digits: np.uint64, power: int) -> tuple[float, int]:
    """digits * 10^power as the nearest double. Returns (value, NUMBER), or (0, UNDECIDED)."""
    if digits == 0:
        return 0.0, NUMBER
    if digits <= _EXACT and -22 <= power <= 22:
        whole = float(digits)
        return (whole / TENS[-power] if power < 0 else whole * TENS[power]), NUMBER
    if power < LOWEST or power > HIGHEST:
        return 0.0, UNDECIDED
    left = 0
    while digits < _TOP:
        digits <<= _ONE
        left += 1
    five = FIVES[power - LOWEST]
    # the upper word of the product of two words, by halves
    a, b, c, d = digits >> _HALF, digits & _LOW, five >> _HALF, five & _LOW
    middle = a * d + ((b * d) >> _HALF)
    upper = a * c + (middle >> _HALF) + ((b * c + (middle & _LOW)) >> _HALF)
    spare = np.uint64(11) if upper >= _TOP else np.uint64(10)
    half = _ONE << (spare - _ONE)
    rest = upper & ((half << _ONE) - _ONE)
    if rest == half or rest == half - _ONE:
        return 0.0, UNDECIDED
    mantissa = upper >> spare
    if rest > half:
        mantissa += _ONE
    return math.ldexp(float(mantissa), SHIFTS[power - LOWEST] + power + 64 + int(spare) - left), NUMBER


@inner_kernel
def scan_number(text: NDArray[np.uint8], at: int, mark: int) -> tuple[float, int, int]:
    """The number that begins at `text[at]`, with `mark` before its decimals; the text ends in a byte that belongs to no number.

    Returns (value, where it ends, status).
    """
    negative = text[at] == MINUS
    if negative or text[at] == PLUS:
        at += 1
    digits, count, power, any_digit = np.uint64(0), 0, 0, False
    decimals = False
    while True:
        byte = text[at]
        if ZERO <= byte <= ZERO + 9:
            any_digit = True
            if count or byte != ZERO:
                count += 1
                if count <= MOST_DIGITS:
                    digits = digits * np.uint64(10) + np.uint64(byte - ZERO)
            if decimals:
                power -= 1
        elif byte == mark and not decimals:
            decimals = True
        else:
            break
        at += 1
    if not any_digit:
        return 0.0, at, NO_NUMBER
    if text[at] == SMALL_E or text[at] == BIG_E:
        at += 1
        down = text[at] == MINUS
        if down or text[at] == PLUS:
            at += 1
        if not ZERO <= text[at] <= ZERO + 9:
            return 0.0, at, NO_NUMBER
        exponent = 0
        while ZERO <= text[at] <= ZERO + 9:
            exponent = min(exponent * 10 + (text[at] - ZERO), LARGEST_EXPONENT)
            at += 1
        power += -exponent if down else exponent
    if count > MOST_DIGITS:
        return 0.0, at, UNDECIDED
    value, status = rounded(digits, power)
    return (-value if negative else value), at, status
