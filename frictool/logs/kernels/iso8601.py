"""Conversion of dates and times of day to integer nanoseconds since 1970-01-01.

    YYYY-MM-DD[T| ]hh:mm[:ss[.fff...]][Z|+hh[[:]mm]]     ISO 8601; UTC without a zone
    hh:mm[:ss[.fff...]]                                  time of day, counted as on 1970-01-01
    D.M.YYYY hh:mm[:ss[.fff...]] [AM|PM]                 the caller says whether the day or the
                                                         month comes first

Year, month and day may be separated by `-`, `/` or `.`.

Days are counted by the civil calendar from 1 March, so that the leap day is the last of a year (H.
Hinnant, chrono-compatible date algorithms).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.logs.kernels.date_order import DAY_FIRST, YEAR_FIRST
from frictool.logs.kernels.decimal_parser import NO_NUMBER, NUMBER
from frictool.runtime.kernels import kernel

FIRST_YEAR, LAST_YEAR = 1678, 2261  # first and last full year that fit 63 bits of ns
SECOND = 1_000_000_000
NO_DATE = -1_000_000  # days; earlier than FIRST_YEAR
DASH, COLON, BLANK, SMALL_T, BIG_T, BIG_Z, POINT, COMMA, PLUS = (ord(sign) for sign in "-: tTZ.,+")
SLASH, SMALL_A, SMALL_P, SMALL_M, LOWER = ord("/"), ord("a"), ord("p"), ord("m"), 32
MONTH_DAYS = np.array([31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31])


@kernel
def _whole(text: NDArray[np.uint8], at: int, length: int) -> int:
    value = 0
    for k in range(length):
        digit = int(text[at + k]) - 48
        if not 0 <= digit <= 9:
            return -1
        value = value * 10 + digit
    return value


@kernel
def days_of(year: int, month: int, day: int) -> int:
    """Return the number of days from 1970-01-01 to a date.

    The result is NO_DATE if the date does not exist or is outside FIRST_YEAR to LAST_YEAR.
    """
    if not (FIRST_YEAR <= year <= LAST_YEAR and 1 <= month <= 12 and day >= 1):
        return NO_DATE
    leap = year % 4 == 0 and (year % 100 != 0 or year % 400 == 0)
    if day > MONTH_DAYS[month - 1] + (1 if leap and month == 2 else 0):
        return NO_DATE
    from_march = year - 1 if month <= 2 else year
    day_of_year = (153 * ((month + 9) % 12) + 2) // 5 + day - 1
    return (
        from_march * 365
        + from_march // 4
        - from_march // 100
        + from_march // 400
        + day_of_year
        - 719468
    )


@kernel
def _one_or_two(text: NDArray[np.uint8], at: int) -> tuple[int, int]:
    length = 2 if _whole(text, at, 2) >= 0 else 1
    return _whole(text, at, length), at + length


@kernel
def scan_date(text: NDArray[np.uint8], at: int, order: int) -> tuple[int, int]:
    """Return (days since 1970-01-01 or NO_DATE, index after the date) of the date at `text[at]`.

    order: order of the parts of the date (YEAR_FIRST, DAY_FIRST, MONTH_FIRST).
    """
    year = _whole(text, at, 4)
    first, after = (year, at + 4) if year >= 0 else _one_or_two(text, at)
    mark = text[after]
    if first < 0 or mark not in (DASH, SLASH, POINT):
        return NO_DATE, at
    second, after = _one_or_two(text, after + 1)
    if second < 0 or text[after] != mark:
        return NO_DATE, at
    if year >= 0:
        day, after = _one_or_two(text, after + 1)
        return days_of(year, second, day), after
    year = _whole(text, after + 1, 4)
    if year < 0 or order == YEAR_FIRST:
        return NO_DATE, at
    if order == DAY_FIRST:
        return days_of(year, second, first), after + 5
    return days_of(year, first, second), after + 5


@kernel
def scan_stamp(text: NDArray[np.uint8], at: int, comma: bool, order: int) -> tuple[int, int, int]:
    """Return (time in ns, end, status) of the time stamp at `text[at]`.

    text: bytes (n,); the last byte is an end marker, such as a line feed, outside the time stamp.
    comma: True if a comma may precede the fraction of a second; False if a comma ends a cell.
    order: order of the parts of a date (YEAR_FIRST, DAY_FIRST, MONTH_FIRST).

    The end is the index after the time stamp. The status is NUMBER, or NO_NUMBER if there is no
    valid time stamp.
    """
    days = 0
    if _whole(text, at, 2) < 0 or text[at + 2] != COLON:
        days, at = scan_date(text, at, order)
        if days == NO_DATE or not (text[at] == BLANK or text[at] == BIG_T or text[at] == SMALL_T):
            return 0, at, NO_NUMBER
        at += 1
    hour, at = _one_or_two(text, at)
    if not 0 <= hour <= 23 or text[at] != COLON:
        return 0, at, NO_NUMBER
    minute = _whole(text, at + 1, 2)
    at += 3
    second, fraction = 0, 0
    if text[at] == COLON:
        second = _whole(text, at + 1, 2)
        at += 3
        if (text[at] == POINT or (comma and text[at] == COMMA)) and _whole(text, at + 1, 1) >= 0:
            at += 1
            weight = SECOND
            while _whole(text, at, 1) >= 0:  # digits below 1 ns are truncated
                weight //= 10
                fraction += weight * _whole(text, at, 1)
                at += 1
    if not (0 <= minute <= 59 and 0 <= second <= 59):
        return 0, at, NO_NUMBER
    half = text[at + 1] | LOWER if text[at] == BLANK else 0
    if half in (SMALL_A, SMALL_P) and text[at + 2] | LOWER == SMALL_M:
        if not 1 <= hour <= 12:
            return 0, at, NO_NUMBER
        hour = hour % 12 + (12 if half == SMALL_P else 0)
        at += 3
    zone = 0
    if text[at] == BIG_Z:
        at += 1
    elif text[at] == PLUS or text[at] == DASH:
        sign = 1 if text[at] == PLUS else -1
        hours = _whole(text, at + 1, 2)
        at += 3
        minutes = 0
        if text[at] == COLON:
            at += 1
            minutes = _whole(text, at, 2)
            at += 2
        elif _whole(text, at, 1) >= 0:
            minutes = _whole(text, at, 2)
            at += 2
        if not (0 <= hours <= 23 and 0 <= minutes <= 59):
            return 0, at, NO_NUMBER
        zone = sign * (hours * 60 + minutes)
    seconds = ((days * 24 + hour) * 60 + minute - zone) * 60 + second
    return seconds * SECOND + fraction, at, NUMBER
