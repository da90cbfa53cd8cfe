"""Conversion of rows of text to numbers, in one pass; cells may be quoted.

The bytes may have any encoding that contains ASCII (UTF-8, Latin-1). A cell that is not a plain
number is listed as an issue, which the caller resolves.

    text ──▶ cell ──▶ slot >= 0: values[slot, row]     issue CELL: no plain number; the cell is
                                                       text[start:stop]
                      STAMP:     stamps[row]
                      SKIP:      ignored
             row  ──▶ issue ROW: wrong number of cells     issue CUT: the text ends without a line
                                                           end
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.logs.kernels.decimal_parser import NUMBER, scan_number
from frictool.logs.kernels.iso8601 import COMMA, scan_stamp
from frictool.logs.kernels.pointer import pointer_to
from frictool.runtime.kernels import inner_kernel, kernel

SKIP, STAMP = -1, -2  # slot of a column that is ignored, and of a column of time stamps
CELL, ROW, CUT = 0, 1, 2  # kinds of issues
ISSUE_FIELDS = 6  # row, kind, line, column (of a CELL) or number of cells (of a ROW), start, stop
BLANK, TAB, FEED, RETURN, QUOTE = 32, 9, 10, 13, 34
PADDING = 64  # line feeds after the end of the text, which the scanner may read


class ScanProgress(NamedTuple):
    """Progress of a scan.

    rows: total number of rows that are filled in `values` and `stamps`.
    used: number of bytes read.
    lines: number of lines read.
    issues: number of rows that are filled in the array `issues`.
    last_line: number of the text line with the last row.
    """

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
    text: NDArray[np.uint8], at: int, delimiter: int, mark: int, dates: int | None, is_stamp: bool
) -> tuple[float, int, int, bool]:
    """Return (value, time in ns, end, plain) of the cell at `at`, a number or a time stamp.

    dates: order of the parts of a stamp's date; None if no column has time stamps, so that the
        reader of stamps need not be compiled.
    is_stamp: True if the cell is read as a time stamp.
    end: index of the first character after the cell, or after the part of it that was read.
    plain: True if the whole cell is a number or a stamp.
    """
    value = 0.0
    stamp = 0
    status = NUMBER
    is_number = True
    quoted = text[at] == QUOTE
    if quoted:
        at = _over_blanks(text, at + 1, delimiter)
    if dates is not None:
        is_number = not is_stamp
        if is_stamp:
            stamp, at, status = scan_stamp(text, at, quoted or delimiter != COMMA, dates)
    if is_number:
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
    count: int,
    row: int,
    kind: int,
    line: int,
    what: int,
    start: int,
    stop: int,
) -> int:
    for field, value in enumerate((row, kind, line, what, start, stop)):
        issues[count, field] = value
    return count + 1


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
    dates: int | None,
) -> ScanProgress:
    """Read whole rows from the start of the text until the text, `values` or `issues` is exhausted.

    buffer: text of `end` bytes, followed by PADDING line feeds.
    last: True if nothing follows the text. If False, a row that reaches the end is left for the
        next call.
    delimiter: byte between cells; BLANK stands for any number of blanks and tabs.
    mark: byte before decimals.
    slots: for each column of the text (columns,), its index in the first axis of `values`, or STAMP
        or SKIP.
    values: numbers (slots, rows), NaN for each CELL issue.
    stamps: times (rows,) in ns; (0,) if no column has time stamps.
    issues: array (m, ISSUE_FIELDS), filled with the issues; m > columns + 1.
    row: index in `values` and `stamps` of the first row to fill.
    dates: order of the parts of a stamp's date (iso8601.py); None if no column has time stamps.
    """
    columns = slots.size
    rows = values.shape[1]
    text = pointer_to(buffer)
    # not the literal 0, for which numba would compile the called functions a second time
    zero = 0 * row
    begin = zero
    lines = zero
    listed = zero
    last_line = zero
    while begin < end and row < rows and listed + columns + 1 < issues.shape[0]:
        cells = zero
        surplus = False
        inside = zero
        listed_now = listed
        empty = _is_blank_line(text, begin)
        more = not empty
        at = _over_blanks(text, begin, BLANK if empty else delimiter)
        while more:
            start = at
            slot = slots[cells] if cells < columns else SKIP
            plain = False
            if slot != SKIP:
                value, stamp, at, plain = _scan(text, start, delimiter, mark, dates, slot == STAMP)
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
                    listed_now = _list(issues, listed_now, row, CELL, lines, cells, start, at)
            cells += 1
            at, more = _next_cell(text, at, delimiter)
        if not last and (at >= end or (at == end - 1 and text[at] == RETURN)):
            break
        if not empty:
            if cells < columns or surplus:
                listed_now = _list(issues, listed, row, ROW, lines, cells, begin, at)
            if at >= end:
                listed_now = _list(issues, listed_now, row, CUT, lines, cells, begin, at)
            last_line = lines
            row += 1
        listed = listed_now
        both = text[at] == RETURN and text[at + 1] == FEED
        begin = min(at + (2 if both else 1), end)
        lines += 1 + inside
    return ScanProgress(row, begin, lines, listed, last_line)
