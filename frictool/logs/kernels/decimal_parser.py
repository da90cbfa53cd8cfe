"""Conversion of decimal text to the nearest double, exactly rounded.

    text = digits [mark digits] [e exponent]  ->  w * 10^q,  w: the digits as an integer

Two fast methods are tried. If neither gives a certain result, Python converts the text.

- w <= 2^53 and |q| <= 22: both factors are doubles, so that one multiplication or division rounds
  once (W. D. Clinger, 1990).
- Otherwise, the leading 64 bits of w * 5^q are computed from a table of the leading 64 bits of the
  powers. Because the table is truncated, the product is wrong by less than 2 units of its last bit.
  The rounding is therefore uncertain only if the product is within 2 units of the middle between
  two doubles, about once in 500 (D. Lemire, 2021).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.runtime.kernels import inner_kernel, kernel

# status of a text: value rounded exactly; number that Python has to convert; not a number
NUMBER, UNDECIDED, NO_NUMBER = range(3)

MOST_DIGITS = 19  # maximum number of digits: 10^19 < 2^64
# powers of ten that cause neither underflow nor overflow with up to 19 digits
LOWEST, HIGHEST = -300, 288
LARGEST_EXPONENT = 100_000  # limit at which an exponent is clamped; Python then gives 0 or inf

TENS = np.array([10.0**power for power in range(23)])
POINT, PLUS, MINUS, ZERO, SMALL_E, BIG_E = (ord(sign) for sign in ".+-0eE")
_ZERO = np.uint64(ZERO)
_ONE = np.uint64(1)
_NINE = np.uint64(9)
_TEN = np.uint64(10)
_HALF = np.uint64(32)
_LOW = np.uint64(0xFFFFFFFF)
_TOP = np.uint64(1 << 63)
_EXACT = np.uint64(1 << 53)


def _fives() -> tuple[NDArray[np.uint64], NDArray[np.int64]]:
    """Return (leading, shifts): truncated powers 5^q = leading 2^shift, q = LOWEST to HIGHEST.

    - leading: integers of 64 bits; the highest bit is 1
    - shifts: exponents of the power of two
    """
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


@kernel
def _by_powers(digits: np.uint64, power: int) -> tuple[float, int]:
    if power < LOWEST or power > HIGHEST:
        return 0.0, UNDECIDED
    left = 0
    while digits < _TOP:
        digits <<= _ONE
        left += 1
    five = FIVES[power - LOWEST]
    # upper word of the product of two words, computed from their halves
    a = digits >> _HALF
    b = digits & _LOW
    c = five >> _HALF
    d = five & _LOW
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
    return math.ldexp(
        float(mantissa), SHIFTS[power - LOWEST] + power + 64 + int(spare) - left
    ), NUMBER


@inner_kernel
def rounded(digits: np.uint64, power: int) -> tuple[float, int]:
    """Return (value, status): digits * 10^power rounded to the nearest double, and NUMBER.

    If the rounding is uncertain, the result is (0, UNDECIDED).
    """
    if digits <= _EXACT and -22 <= power <= 22:
        whole = float(digits)
        return (whole / TENS[-power] if power < 0 else whole * TENS[power]), NUMBER
    if digits == 0:
        return 0.0, NUMBER
    return _by_powers(digits, power)


@inner_kernel
def _over_digits(text: NDArray[np.uint8], at: int, digits: np.uint64) -> tuple[int, np.uint64]:
    digit = np.uint64(text[at]) - _ZERO
    while digit <= _NINE:
        digits = digits * _TEN + digit
        at += 1
        digit = np.uint64(text[at]) - _ZERO
    return at, digits


@kernel
def _significant(text: NDArray[np.uint8], at: int, end: int) -> int:
    count = 0
    for k in range(at, end):
        count += ZERO <= text[k] <= ZERO + 9 and (count > 0 or text[k] != ZERO)
    return count


@kernel
def _exponent(text: NDArray[np.uint8], at: int) -> tuple[int, int]:
    down = text[at] == MINUS
    if down or text[at] == PLUS:
        at += 1
    exponent = 0
    while ZERO <= text[at] <= ZERO + 9:
        exponent = min(exponent * 10 + (text[at] - ZERO), LARGEST_EXPONENT)
        at += 1
    return (-exponent if down else exponent), at


@inner_kernel
def scan_number(text: NDArray[np.uint8], at: int, mark: int) -> tuple[float, int, int]:
    """Return (value, end, status) of the number that begins at `text[at]`.

    text: bytes (n,); the last byte is an end marker, such as a line feed, outside the number.
    mark: byte before the decimals.

    The end is the index after the number; the status is NUMBER, UNDECIDED or NO_NUMBER.
    """
    negative = text[at] == MINUS
    if negative or text[at] == PLUS:
        at += 1
    first = at
    at, digits = _over_digits(text, at, np.uint64(0))
    count = at - first
    power = 0
    if text[at] == mark:
        point = at + 1
        at, digits = _over_digits(text, point, digits)
        power = point - at
    count -= power
    if count == 0:
        return 0.0, at, NO_NUMBER
    end = at
    if text[at] == SMALL_E or text[at] == BIG_E:
        exponent, at = _exponent(text, at + 1)
        if not ZERO <= text[at - 1] <= ZERO + 9:
            return 0.0, at, NO_NUMBER
        power += exponent
    if count > MOST_DIGITS and _significant(text, first, end) > MOST_DIGITS:
        return 0.0, at, UNDECIDED
    value, status = rounded(digits, power)
    return (-value if negative else value), at, status
