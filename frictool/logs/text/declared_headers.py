"""Headers of instruments that declare where names, units and times are.

    LabVIEW         `***End_of_Header***` ends the metadata; `Delta_X` is the sample interval
    TwinCAT Scope   in the line `Name`, a time column in ms precedes each group of channels
    Tektronix       the metadata is in the columns before the samples (TDS series)

text_header.py detects the headers of other instruments.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from frictool.logs.text.header_units import NO_UNIT, is_unit, name_and_unit, spelled
from frictool.logs.text.text_header import (
    TIME_UNITS,
    ColumnLabels,
    IsNumber,
    Rows,
    distinct,
    trimmed,
)

Number = Callable[[str], float | None]
MOST_METADATA = 40  # maximum number of lines with metadata in the columns before the samples


class HeaderError(ValueError):
    """Error: a declared header is incomplete, or columns have different time bases."""


@dataclass(frozen=True)
class DeclaredHeader:
    """Header that the instrument declares in a file; lines are counted from 0.

    labels: names and units of the columns, and the sample interval.
    header: number of the line with the names; None if there is no such line.
    unit: number of the line with the units; None if there is no such line.
    first: number of the line with the first row of numbers.
    commented: True if a row may have a comment as an additional last cell.
    trailer: text of a last line that ends the samples; "" if there is no such line.
    metadata: number of columns with metadata before the columns of the samples.
    """

    labels: ColumnLabels
    header: int | None
    unit: int | None
    first: int
    commented: bool = False
    trailer: str = ""
    metadata: int = 0


class HeaderReader(NamedTuple):
    """Reader of the headers of one instrument.

    recognises: function that returns True if the first rows are from the instrument.
    read: function that returns the header, or raises HeaderError.
    """

    recognises: Callable[[Rows], bool]
    read: Callable[[Rows, Number, IsNumber], DeclaredHeader]


def declared_header(rows: Rows, number: Number, is_number: IsNumber) -> DeclaredHeader | None:
    """Return the header that the instrument declares; None if no instrument is recognised.

    rows: cells of the first lines of the file.
    number: function that returns the number in a cell, or None.
    is_number: function that returns True if a cell is a number or a time.

    Raises HeaderError if the declared header is incomplete, or if columns have different times.
    """
    for reader in READERS:
        if reader.recognises(rows):
            return reader.read(rows, number, is_number)
    return None


def _keyed(rows: Rows, end: int) -> dict[str, Sequence[str]]:
    return {row[0].lower(): row for row in rows[:end] if row and row[0]}


# LabVIEW measurement file
LABVIEW = "LabVIEW Measurement"
END_OF_HEADER = "***End_of_Header***"
X_VALUE = "X_Value"


def labview_dialect(lines: Sequence[str]) -> tuple[str | None, str | None, int]:
    """Return the delimiter, the decimal mark, and the index of the first line of samples.

    Delimiter and mark are words as in `Layout`, such as `comma`; None if not declared. The index is
    0 if the file is not a LabVIEW measurement, or has no second header.
    """
    if not lines or not lines[0].startswith(LABVIEW):
        return None, None, 0
    words = {line.split()[0]: line.split()[-1] for line in lines if len(line.split()) > 1}
    ends = [index for index, line in enumerate(lines) if line.startswith(END_OF_HEADER)]
    delimiter = {"tab": "tab", "comma": "comma"}.get(words.get("Separator", "").lower())
    mark = {",": "comma", ".": "point"}.get(words.get("Decimal_Separator", ""))
    return delimiter, mark, ends[1] + 2 if len(ends) > 1 else 0


def _is_labview(rows: Rows) -> bool:
    return bool(rows) and bool(rows[0]) and rows[0][0].startswith(LABVIEW)


def _read_labview(rows: Rows, number: Number, is_number: IsNumber) -> DeclaredHeader:
    ends = [index for index, row in enumerate(rows) if row and row[0] == END_OF_HEADER]
    header = ends[1] + 1 if len(ends) > 1 else len(rows)
    first = next((index for index in range(header + 1, len(rows)) if any(rows[index])), None)
    if first is None or not any(rows[header]):
        raise HeaderError(
            "has no samples after its second LabVIEW header; if the samples are elsewhere, write "
            "layout.header_line and layout.first_line in bench.yaml"
        )
    keys = _keyed(rows[ends[0] + 1 :], ends[1] - ends[0])
    names = list(trimmed(rows[header]))
    commented = names[-1] == "Comment"
    if commented:
        names.pop()
    times = [column for column, name in enumerate(names) if name == X_VALUE]
    seconds = all(cell in ("", "Time") for cell in keys.get("x_dimension", ["", "Time"])[1:])
    units = iter(keys.get("y_unit_label", ())[1:])
    # with several time columns, the header has an empty cell after each channel's cell
    paired = len(times) > 1
    found: list[str | None] = []
    for column in range(len(names)):
        if column in times:
            found.append("s" if seconds else None)
        else:
            unit = next(units, "")
            found.append(spelled(unit) if is_unit(unit) else name_and_unit(names[column])[1])
            if paired:
                next(units, "")
    clock, period, start = _labview_clock(rows[first], keys, number, seconds)
    labels = ColumnLabels(tuple(distinct(names)), tuple(found), clock, period, start)
    return DeclaredHeader(labels, header, None, first, commented)


def _labview_clock(
    row: Sequence[str], keys: dict[str, Sequence[str]], number: Number, seconds: bool
) -> tuple[str | None, float | None, float]:
    if row[0]:
        return None, None, 0.0
    steps = {number(cell) for cell in keys.get("delta_x", ())[1:] if cell}
    starts = [number(cell) for cell in keys.get("x0", ())[1:] if cell] or [0.0]
    step = steps.pop() if len(steps) == 1 else None
    if not seconds or step is None or starts[0] is None or not 0.0 < step < math.inf:
        raise HeaderError(
            "has no time column, and its channels have no common Delta_X in s; "
            "write layout.period_s in bench.yaml"
        )
    return "Delta_X", 1e9 * step, 1e9 * starts[0]


# TwinCAT Scope
NAME, SAMPLE_TIME, START_OF_EXPORT = "name", "sampletime[ms]", "starttime of export"


def _is_twincat(rows: Rows) -> bool:
    return START_OF_EXPORT in _keyed(rows, len(rows))


def _read_twincat(rows: Rows, number: Number, is_number: IsNumber) -> DeclaredHeader:
    first = next(
        (
            index
            for index, row in enumerate(rows)
            if len(row) > 1 and all(is_number(cell) for cell in row if cell) and is_number(row[0])
        ),
        None,
    )
    headers = [index for index, row in enumerate(rows[:first]) if row and row[0].lower() == NAME]
    if first is None or len(headers) < 2:
        raise HeaderError(
            "is an export of TwinCAT Scope, but has no samples or no line `Name` with channel names"
        )
    header = headers[-1]
    width = len(rows[first])
    names = [*rows[header], *[""] * width][:width]
    times = [column for column, name in enumerate(names) if name.lower() == NAME]
    _refuse_several_clocks(rows[first:], times)
    keys = {row[0].lower(): index for index, row in enumerate(rows[:first]) if row and row[0]}
    unit_line = keys.get("unit")
    beneath = [] if unit_line is None else rows[unit_line]
    steps = rows[keys[SAMPLE_TIME]] if SAMPLE_TIME in keys else ()
    units: list[str | None] = []
    for column in range(width):
        if column in times:
            units.append(_twincat_time_unit(rows[first : first + 2], column, steps, number))
        else:
            cell = beneath[column] if column < len(beneath) else ""
            units.append(None if cell.lower() in NO_UNIT else spelled(cell))
    for column in times:
        names[column] = "Time" if column == times[0] else f"Time (column {column + 1})"
    return DeclaredHeader(
        ColumnLabels(tuple(distinct(names)), tuple(units)), header, unit_line, first, trailer="EOF"
    )


def _refuse_several_clocks(rows: Rows, times: Sequence[int]) -> None:
    for row in rows:
        stamps = {row[column] for column in times if column < len(row)}
        if len(stamps) > 1:
            raise HeaderError(
                f"has columns with different times ({', '.join(sorted(stamps))} in one row); "
                "export the channels of one sample time"
            )


def _twincat_time_unit(rows: Rows, column: int, steps: Sequence[str], number: Number) -> str | None:
    """Return the unit `ms` of a time column; None for an index column.

    A column whose steps differ from the declared sample time is an index column.
    """
    declared = number(steps[column + 1]) if column + 1 < len(steps) else None
    times = [number(row[column]) for row in rows if column < len(row)]
    if declared is None or len(times) < 2 or times[0] is None or times[1] is None:
        return "ms" if declared is None else None
    return "ms" if math.isclose(times[1] - times[0], declared, rel_tol=1e-6) else None


# Tektronix TDS: key, value, unit, time, sample
RECORD_LENGTH, INTERVAL, SOURCE = "record length", "sample interval", "source"
TEKTRONIX_COLUMNS = 5


def _is_tektronix(rows: Rows) -> bool:
    return (
        bool(rows)
        and len(rows[0]) >= TEKTRONIX_COLUMNS
        and rows[0][0].lower() == RECORD_LENGTH
        and bool(rows[0][3])
    )


def _read_tektronix(rows: Rows, number: Number, is_number: IsNumber) -> DeclaredHeader:
    keys = _keyed(rows, MOST_METADATA)

    def value(key: str) -> str:
        row = keys.get(key, ())
        return row[1] if len(row) > 1 else ""

    time_unit = spelled(value("horizontal units").lower())
    width = len(rows[0])
    names = [str(column + 1) for column in range(width)]
    names[3] = "Time"
    names[4] = value(SOURCE) or "samples"
    units: list[str | None] = [None] * width
    units[3] = time_unit if time_unit in TIME_UNITS else None
    units[4] = spelled(value("vertical units")) or None
    return DeclaredHeader(ColumnLabels(tuple(names), tuple(units)), None, None, 0, metadata=3)


READERS = (
    HeaderReader(_is_labview, _read_labview),
    HeaderReader(_is_twincat, _read_twincat),
    HeaderReader(_is_tektronix, _read_tektronix),
)
