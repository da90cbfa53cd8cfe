"""Detection of a text file's layout from its first lines. Keys in bench.yaml take precedence."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import msgspec

from frictool.documents.bench import Layout
from frictool.errors import LogError
from frictool.logs.kernels.date_order import DAY_FIRST, MONTH_FIRST, YEAR_FIRST
from frictool.logs.text.cells import (
    DELIMITERS,
    MARKS,
    THOUSANDS,
    cells_of,
    dialect,
    is_stamp,
    number,
    order_of_dates,
)
from frictool.logs.text.declared_headers import (
    DeclaredHeader,
    HeaderError,
    Number,
    declared_header,
    labview_dialect,
)
from frictool.logs.text.header_units import ISO_8601
from frictool.logs.text.text_encoding import TextEncoding
from frictool.logs.text.text_header import IsNumber, Rows, first_row, labels, labels_above

LONGEST_LINE = 1_000_000  # characters, maximum length of an examined line
# the usual layout, which is not reported
PLAIN = "UTF-8, comma between cells, decimal point, header in line 1, numbers from line 2"
ORDERS = {"day-first": DAY_FIRST, "month-first": MONTH_FIRST}
MOST_LINES = 200  # maximum number of lines examined


@dataclass(frozen=True)
class TextLayout:
    """Layout of a text file.

    Lines are numbered from 1. The number 0 means that there is no such line.

    names, units: names and units of the columns.
    header_line, unit_line: lines with the names and with the units.
    first_line: line of the first row of numbers.
    clock: name of the source of the times, for messages; None if the file has no times, or if the
        source is a numeric column.
    stamps: index of the column with dates or times of day; None if there is no such column.
    dates: order of the parts of these dates (kernels/iso8601.py).
    period_ns, start_ns: interval and start of the rows in ns, from a line above the numbers or
        from bench.yaml.
    commented: True if a row may have a comment as an additional last cell.
    trailer: text of a last line that ends the samples; "" if there is no such line.
    metadata: number of columns with metadata before the columns of the samples.
    """

    encoding: TextEncoding
    delimiter: str
    mark: str
    thousands: str
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    header_line: int
    unit_line: int
    first_line: int
    clock: str | None = None
    stamps: int | None = None
    dates: int = YEAR_FIRST
    period_ns: float | None = None
    start_ns: float = 0.0
    commented: bool = False
    trailer: str = ""
    metadata: int = 0

    @property
    def description(self) -> str:
        """Return a text for messages that describes the layout."""
        between = next(name for name, sign in DELIMITERS.items() if sign == self.delimiter)
        decimal = next(name for name, sign in MARKS.items() if sign == self.mark)
        lines = [
            f"{what} in line {line}"
            for what, line in (("header", self.header_line), ("units", self.unit_line))
            if line
        ]
        shown = [
            self.encoding.shown,
            f"{between} between cells",
            f"decimal {decimal}",
            *(lines or ["no header"]),
        ]
        return ", ".join([*shown, f"numbers from line {self.first_line}"])


def find_layout(
    path: Path, head: str, whole: bool, encoding: TextEncoding, layout: Layout
) -> TextLayout:
    """Return the layout of a file that begins with `head`.

    whole: True if `head` is the complete file.
    layout: keys of the layout that bench.yaml states; they take precedence.

    Raises LogError if the file is empty, or has no row of numbers below its header. Raises LogError
    also if a declared header is incomplete, the order of the dates is unclear, or an examined line
    is longer than LONGEST_LINE.
    """
    lines = _lines(path, head, whole, max(MOST_LINES, layout.first_line or 0))
    declared_delimiter, declared_mark, samples = labview_dialect(lines)
    layout = msgspec.structs.replace(
        layout,
        delimiter=layout.delimiter or declared_delimiter,
        decimal=layout.decimal or declared_mark,
    )
    delimiter, mark = dialect(lines[samples:MOST_LINES], layout)
    thousands = THOUSANDS[layout.thousands]
    rows = [cells_of(line, delimiter) for line in lines]

    def value(cell: str) -> float | None:
        return number(cell, mark, thousands)

    def is_number(cell: str) -> bool:
        return value(cell) is not None or is_stamp(cell)

    found = _header(path, rows, layout, value, is_number)
    names, first = found.labels, found.first
    stamps = next(
        (index for index, cell in enumerate(rows[first][: len(names.names)]) if is_stamp(cell)),
        None,
    )
    units = tuple(ISO_8601 if index == stamps else one for index, one in enumerate(names.units))
    clock, period, start = names.clock, names.period_ns, names.start_ns
    dates = YEAR_FIRST
    if layout.period_s is not None:
        clock = "layout.period_s"
        stamps = None
        period = layout.period_s * 1e9
        start = (layout.start_s or 0.0) * 1e9
    elif stamps is not None:
        clock = names.names[stamps]
        period = None
        start = 0.0
        dates = _order(path, [row[stamps] for row in rows[first:] if stamps < len(row)], layout)
    return TextLayout(
        encoding,
        delimiter,
        mark,
        thousands,
        names.names,
        units,
        header_line=0 if found.header is None else found.header + 1,
        unit_line=0 if found.unit is None else found.unit + 1,
        first_line=first + 1,
        clock=clock,
        stamps=stamps,
        dates=dates,
        period_ns=period,
        start_ns=start,
        commented=found.commented,
        trailer=found.trailer,
        metadata=found.metadata,
    )


def _header(
    path: Path, rows: list[list[str]], layout: Layout, value: Number, is_number: IsNumber
) -> DeclaredHeader:
    """Return the header from bench.yaml's lines, else the instrument's, else the detected one."""
    after = max(layout.header_line or 0, layout.unit_line or 0)
    if layout.header_line is None and layout.unit_line is None and layout.first_line is None:
        try:
            declared = declared_header(rows, value, is_number)
        except HeaderError as error:
            raise LogError(path, str(error)) from None
        if declared is not None:
            return declared
    below = [[] if index < after else row for index, row in enumerate(rows)]
    first = first_row(below, is_number) if layout.first_line is None else layout.first_line - 1
    if first is None or first >= len(rows):
        raise LogError(path, _no_rows(rows, first, after))
    header, unit = _above(rows, first, layout, is_number)
    return DeclaredHeader(labels(rows, first, header, unit, value), header, unit, first)


def _order(path: Path, cells: list[str], layout: Layout) -> int:
    order = ORDERS[layout.dates] if layout.dates else order_of_dates(cells)
    if order is None:
        raise LogError(
            path,
            f"has dates such as {cells[0]!r}, which may begin with the day or with the month; "
            "write layout.dates: day-first or month-first in bench.yaml",
        )
    return order


def _lines(path: Path, head: str, whole: bool, most: int) -> list[str]:
    lines = re.split(r"\r\n|\n|\r", head, maxsplit=most)
    if not any(line.strip() for line in lines):
        raise LogError(path, "is empty; a table with a header is expected")
    if len(lines) > most or (not whole and len(lines) > 1):
        lines.pop()  # the rest of the text, or a line that continues beyond the head
    for index, line in enumerate(lines, start=1):
        if len(line) >= LONGEST_LINE:
            raise LogError(
                path,
                f"is longer than {LONGEST_LINE} characters; a table with a header is expected",
                line=index,
            )
    return lines


def _no_rows(rows: list[list[str]], first: int | None, after: int) -> str:
    if first is not None:
        return f"has {len(rows)} lines, but layout.first_line is {first + 1}"
    if after:
        return f"has no row of numbers after line {after}, the last header line in bench.yaml"
    if sum(any(row) for row in rows) == 1:
        return "has a header, but no rows"
    return (
        f"has no row of numbers in its first {len(rows)} lines; if a table begins later, write "
        "layout.first_line in bench.yaml"
    )


def _above(
    rows: Rows, first: int, layout: Layout, is_number: IsNumber
) -> tuple[int | None, int | None]:
    header, unit = labels_above(rows, first, is_number)
    if layout.unit_line is not None:
        unit = layout.unit_line - 1 if layout.unit_line else None
        header = max(
            (index for index in range(first if unit is None else unit) if any(rows[index])),
            default=None,
        )
    if layout.header_line is not None:
        header = layout.header_line - 1 if layout.header_line else None
        if layout.unit_line is None and (header is None or (unit is not None and unit <= header)):
            unit = None
    return header, unit
