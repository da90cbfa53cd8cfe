"""Cells of a line of text, numbers in cells, and detection of delimiter and decimal mark.

The detection chooses the pair of delimiter and mark with which the first lines of the file contain
the most numbers.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence

from frictool.documents.bench import Layout
from frictool.logs.kernels.date_order import DAY_FIRST, MONTH_FIRST, YEAR_FIRST

BLANK = " "
LAST_MONTH = 12
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "blank": BLANK}
MARKS = {"point": ".", "comma": ","}
THOUSANDS = {
    None: "",
    "point": ".",
    "comma": ",",
    "blank": " \u00a0\u202f",
    "apostrophe": "'\u2019",
}
# in order of preference if several fit equally well: a comma between cells implies the decimal
# point
DIALECTS = (
    (",", "."),
    (";", "."),
    (";", ","),
    ("\t", "."),
    ("\t", ","),
    (BLANK, "."),
    (BLANK, ","),
    (",", ","),
)
# a cell is a quoted text, or a word, including a unit in brackets after it
_BETWEEN_BLANKS = re.compile(r'"[^"]*"|\S+(?:[ \t]+\[[^\]]*\])?')
_DATE = r"(?:\d{4}([-/.])\d\d?\1\d\d?|(?P<first>\d\d?)([-/.])(?P<second>\d\d?)\3\d{4})[Tt ]\d?"
_STAMP = re.compile(rf"(?:{_DATE}|\d)\d:\d\d(:\d\d([.,]\d+)?)?( [AaPp][Mm])?(Z|[+-]\d\d(:?\d\d)?)?")
_NUMBERS = {
    mark: re.compile(
        rf"[+-]?(?:(?:[0-9]+(?:{form}[0-9]*)?|{form}[0-9]+)(?:e[+-]?[0-9]+)?|nan|inf|infinity)",
        re.IGNORECASE,
    )
    for mark, form in ((".", r"\."), (",", ","))
}


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without the blanks and quotes around them.

    If blanks are the delimiter, the line has no empty cells.
    """
    if delimiter == BLANK:
        return [cell.strip('"') for cell in _BETWEEN_BLANKS.findall(line)]
    try:
        cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:  # the field is too long for csv.reader
        cells = line.split(delimiter)
    return [cell.strip() for cell in cells]


def number(cell: str, mark: str, thousands: str = "") -> float | None:
    """Return the number in a cell; None if the cell is not a number.

    mark: decimal mark.
    thousands: signs that may separate thousands.

    >>> number("1.234,5", ",", "."), number("-3e2", "."), number("1_0", ".")
    (1234.5, -300.0, None)
    """
    plain = cell.strip()
    for sign in thousands:
        plain = plain.replace(sign, "")
    return float(plain.replace(mark, ".")) if _NUMBERS[mark].fullmatch(plain) else None


def is_stamp(cell: str) -> bool:
    """Return True if a cell is a time of day, with or without a date."""
    return _STAMP.fullmatch(cell) is not None


def order_of_dates(cells: Sequence[str]) -> int | None:
    """Return the order of day, month and year in the dates of `cells`, a constant of iso8601.py.

    The result is None if the year comes last and it is unclear in every date which number is the
    day.

    >>> order_of_dates(["03/04/2026 12:00"]), order_of_dates(["3.4.2026 12:00"])
    (None, 1)
    """
    dates = [match for cell in cells if (match := _STAMP.fullmatch(cell)) and match["first"]]
    if not dates:
        return YEAR_FIRST
    if any(int(date["first"]) > LAST_MONTH or date[3] == "." for date in dates):
        return DAY_FIRST
    if any(int(date["second"]) > LAST_MONTH for date in dates):
        return MONTH_FIRST
    return None


def dialect(lines: Sequence[str], layout: Layout) -> tuple[str, str]:
    """Return the delimiter and the decimal mark from `layout`; detect them if `layout` has none."""

    def numbers(tried: tuple[str, str]) -> float:
        total = 0.0
        for line in lines:
            cells = [cell for cell in cells_of(line, tried[0]) if cell]
            count = sum(
                number(cell, tried[1], THOUSANDS[layout.thousands]) is not None or is_stamp(cell)
                for cell in cells
            )
            # number of numeric cells, times their share
            total += count**2 / len(cells) if cells else 0.0
        return total

    delimiter, mark = DELIMITERS.get(layout.delimiter or ""), MARKS.get(layout.decimal or "")
    left = [
        (one, other)
        for one, other in DIALECTS
        if delimiter in (None, one) and mark in (None, other)
    ]
    if layout.thousands == "blank":
        left = [one for one in left if one[0] != BLANK]
    return max(left, key=numbers) if left else (delimiter or ",", mark or ".")
