"""Rows of text to numbers: cells between delimiters, quoted or not, one pass over the bytes.

The bytes are of any encoding that has ASCII in it (UTF-8, Latin-1). What is no plain number is not
judged here but listed for the caller.

    text ──▶ cell ──▶ slot >= 0: values[slot, row]     issue CELL: no plain number, text[start:stop]
                                                       is the cell
                      STAMP:     stamps[row]
                      SKIP:      passed over, whatever it holds
             row  ──▶ issue ROW: not as many cells as the others     issue CUT: the text ends
                                                                     without a line end
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.logs.kernels.decimal_parser import NUMBER, scan_number
from frictool.logs.kernels.iso8601 import COMMA, scan_stamp
from frictool.logs.kernels.pointer import pointer_to
from frictool.runtime.kernels import inner_kernel, kernel

SKIP, STAMP = -1, -2  # slots
CELL, ROW, CUT = 0, 1, 2  # kinds of issues
ISSUE_FIELDS = 6  # row, kind, line, column (of a CELL) or number of cells (of a ROW), start, stop
BLANK, TAB, FEED, RETURN, QUOTE = 32, 9, 10, 13, 34
PADDING = 64  # bytes after the end of the text that may be looked at: line feeds


class ScanProgress(NamedTuple):
    """rows: filled in all. used: bytes of the rows read. lines: that they are. issues: listed.
    last_line: of the last row, in the text."""

    rows: int
    used: int
    lines: int
    issues: int
    last_line: int


@inner_kernel
def _over_blanks(text: NDArray[np.uint8], at: int, delimiter: int) -> int:
    while text[at] == BLANK or (text[at] == TAB and delimiter != TAB):
        at += 1
    return at


@inner_kernel
def _is_break(byte: int, delimiter: int) -> bool:
    return byte in (delimiter, FEED, RETURN) or (delimiter == BLANK and byte == TAB)


@kernel
def _past_cell(text: NDArray[np.uint8], at: int, end: int, delimiter: int) -> tuple[int, int]:
    """Where the cell that begins at `at` ends, and how many line ends lie inside its quotes."""
    lines = 0
    if text[at] == QUOTE:
        at += 1
        while at < end and (text[at] != QUOTE or text[at + 1] == QUOTE):
            lines += text[at] == FEED
            at += 2 if text[at] == QUOTE else 1
        at = min(at + 1, end)
    while not _is_break(text[at], delimiter):
        at += 1
    return at, lines


@inner_kernel
def _scan(
    text: NDArray[np.uint8], at: int, delimiter: int, mark: int, stamped: bool
) -> tuple[float, int, int, bool]:
    """The cell that begins at `at`, as a number or a stamp: (value, ns, where it ends, whether the
    whole cell is one)."""
    value, stamp = 0.0, 0
    quoted = text[at] == QUOTE
    if quoted:
        at = _over_blanks(text, at + 1, delimiter)
    if stamped:
        stamp, at, status = scan_stamp(text, at, quoted or delimiter != COMMA)
    else:
        value, at, status = scan_number(text, at, mark)
    plain = status == NUMBER
    if quoted:
        at = _over_blanks(text, at, delimiter)
        plain = plain and text[at] == QUOTE
        at += 1
    if delimiter != BLANK:
        at = _over_blanks(text, at, delimiter)
    return value, stamp, at, plain and _is_break(text[at], delimiter)


@inner_kernel
def _ends_line(byte: int) -> bool:
    return byte in (FEED, RETURN)


@inner_kernel
def _next_cell(text: NDArray[np.uint8], at: int, delimiter: int) -> tuple[int, bool]:
    """From where a cell ends to where the next begins, and whether there is one in this row."""
    if _ends_line(text[at]):
        return at, False
    after = _over_blanks(text, at if delimiter == BLANK else at + 1, delimiter)
    if delimiter == BLANK and _ends_line(text[after]):
        return after, False
    return after, True


@inner_kernel
def _is_blank_line(text: NDArray[np.uint8], at: int) -> bool:
    while text[at] == BLANK or text[at] == TAB:
        at += 1
    return _ends_line(text[at])


@kernel
def _list(
    issues: NDArray[np.int64],
    found: int,
    row: int,
    kind: int,
    line: int,
    what: int,
    start: int,
    stop: int,
) -> int:
    for field, value in enumerate((row, kind, line, what, start, stop)):
        issues[found, field] = value
    return found + 1


@kernel
def read_rows(
    buffer: NDArray[np.uint8],
    end: int,
    last: bool,
    delimiter: int,
    mark: int,
    slots: NDArray[np.int64],
    values: NDArray[np.float64],
    stamps: NDArray[np.int64],
    issues: NDArray[np.int64],
    row: int,
) -> ScanProgress:
    """Whole rows from the start of the text, until it, the rows or the issues are full.

    Args:
        buffer: (end + PADDING,) bytes; those from `end` on are line feeds.
        last: whether nothing follows the text; else a row that reaches its end is left for the next
        time. delimiter, mark: the bytes between cells (BLANK: any number of blanks and tabs) and
        before decimals. slots: (columns,) where each column goes. values: (slots, rows), filled
        from `row` on; nan where a CELL is listed. stamps: (rows,), or (0,) where no column is a
        STAMP. issues: (m, ISSUE_FIELDS), m > columns + 1.
    """
    columns, rows, text = slots.size, values.shape[1], pointer_to(buffer)
    zero = 0 * row  # a constant would have numba compile what is called with it twice
    begin, lines, listed, last_line = zero, zero, zero, zero
    while begin < end and row < rows and listed + columns + 1 < issues.shape[0]:
        cells, surplus, inside, found = zero, False, zero, listed
        empty = _is_blank_line(text, begin)
        more = not empty
        at = _over_blanks(text, begin, BLANK if empty else delimiter)
        while more:
            start, slot = at, slots[cells] if cells < columns else SKIP
            plain = False
            if slot != SKIP:
                value, stamp, at, plain = _scan(text, start, delimiter, mark, slot == STAMP)
                if slot == STAMP:
                    stamps[row] = stamp
                else:
                    values[slot, row] = value if plain else np.nan
            if not plain:
                at, inner = _past_cell(text, start, end, delimiter)
                inside += inner
                surplus = surplus or (
                    cells >= columns
                    and at > start
                    and not (at == start + 2 and text[start] == QUOTE)
                )
                if slot != SKIP:
                    found = _list(issues, found, row, CELL, lines, cells, start, at)
            cells += 1
            at, more = _next_cell(text, at, delimiter)
        if not last and (at >= end or (at == end - 1 and text[at] == RETURN)):
            break
        if not empty:
            if cells < columns or surplus:
                found = _list(issues, listed, row, ROW, lines, cells, begin, at)
            if at >= end:
                found = _list(issues, found, row, CUT, lines, cells, begin, at)
            last_line = lines
            row += 1
        listed = found
        both = text[at] == RETURN and text[at + 1] == FEED
        begin = min(at + (2 if both else 1), end)
        lines += 1 + inside
    return ScanProgress(row, begin, lines, listed, last_line)
