"""Header of a text file: metadata, names and units of the columns.

metadata lines       may contain a sample interval. Lines of TwinCAT repeat their key: the line
                     `Name,a,Name,b` has the names a and b, and the line `Unit,...` has the units.
header               the nearest line above the numbers that has the form of a header
units                part of the header's names, or in a separate line below
rows of numbers      begin at the first line that has numbers in most of the numeric columns; a
                     column is numeric if most lines have a number in it
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from frictool.logs.text.header_units import NO_UNIT, is_unit, name_and_unit, spelled

IsNumber = Callable[[str], bool]
Rows = Sequence[Sequence[str]]
TIME_UNITS = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}  # unit -> ns
RATE_UNITS = {"Hz": 1e9, "kHz": 1e6, "MHz": 1e3}  # unit -> period in ns at a rate of 1
_INTERVAL = re.compile(
    r"(.*\b)?(sampl\w*|time|horizontal)?[ _]*(interval|increment|period|xincr\w*|tinc|dt)\b.*",
    re.IGNORECASE,
)
_RATE = re.compile(r".*\bsampl\w*[ _](rate|frequency|freq)\b.*", re.IGNORECASE)
CHANNEL_KEYS = (  # first cells of the lines that describe channels in an export of TwinCAT Scope
    *(
        "name",
        "symbolcomment",
        "data-type",
        "sampletime[ms]",
        "variablesize",
        "symbolbased",
        "indexgroup",
        "indexoffset",
    ),
    *(
        "symbolname",
        "netid",
        "port",
        "offset",
        "scalefactor",
        "bitmask",
        "unit",
        "unit scalefactor",
        "unit offset",
    ),
)
FEWEST_KEYS = 3  # least number of lines that begin with a key
# columns of an oscilloscope's export that have a number only in the line below the names
START, INCREMENT = "start", "increment"


def trimmed(row: Sequence[str]) -> Sequence[str]:
    """Return a row without blank cells at its end."""
    end = len(row)
    while end and not row[end - 1]:
        end -= 1
    return row[:end]


def first_row(rows: Rows, is_number: IsNumber) -> int | None:
    """Return the index of the first row of numbers; None if there is none.

    This row has the most frequent number of cells. It has numbers in most of the numeric columns
    (columns with a number in most lines). A row such as `Probe Attenuation,10,10` has a text in
    the first column although this column is numeric. Such a row is metadata unless the next
    nonblank line is a row of numbers. If no row meets these conditions, the result is the first row
    with numbers and the most frequent number of cells.
    """
    numeric = [(index, row) for index, row in enumerate(rows) if any(map(is_number, row))]
    if not numeric:
        return None
    width = Counter(len(row) for _, row in numeric).most_common(1)[0][0]
    full = [(index, row) for index, row in numeric if len(row) == width]
    # the second half is less likely to include lines above the numbers
    later = [row for _, row in full[len(full) // 2 :]]
    usual = [
        column
        for column in range(width)
        if 2 * sum(is_number(row[column]) for row in later) > len(later)
    ]

    def is_sample(row: Sequence[str]) -> bool:
        filled = [column for column in usual if row[column]]
        return 2 * sum(is_number(row[column]) for column in filled) > len(filled)

    for index, row in full:
        if is_sample(row) and not _stands_over_units(rows, index):
            below = next((other for other in rows[index + 1 :] if any(other)), row)
            is_metadata = bool(row[0]) and not is_number(row[0]) and 0 in usual
            if not is_metadata or (len(below) == width and is_sample(below)):
                return index
    return full[0][0]


def _stands_over_units(rows: Rows, index: int) -> bool:
    """Return True if a line contains column names of an oscilloscope that are partly numbers.

    An example is `x-axis,1,2` above `second,Volt,Volt`.
    """
    below = rows[index + 1] if index + 1 < len(rows) else ()
    return len(below) == len(rows[index]) and all(is_unit(cell) for cell in below)


def labels_above(rows: Rows, first: int, is_number: IsNumber) -> tuple[int | None, int | None]:
    """Return (index of the line with names, index of the line with units), above the row `first`.

    The index of a missing line is None.
    """
    above = [index for index in range(first) if any(rows[index])]
    keyed = {
        rows[index][0].lower(): index for index in above if rows[index][0].lower() in CHANNEL_KEYS
    }
    if len(keyed) >= FEWEST_KEYS:
        return keyed.get("name"), keyed.get("unit")
    if not above or not _are_labels(rows, above[-1], first):
        return None, None
    if (
        len(above) > 1
        and _are_labels(rows, above[-2], first)
        and _are_units(rows[above[-1]], is_number)
    ):
        return above[-2], above[-1]
    return above[-1], None


def _are_labels(rows: Rows, index: int, first: int) -> bool:
    """Return True if a line may contain the names of the columns.

    A single cell above several columns is a title, not a name.
    """
    return len(rows[first]) < 2 or len(rows[index]) > 1


def _are_units(row: Sequence[str], is_number: IsNumber) -> bool:
    """Return True if a line contains units.

    At least half of its texts must be units, or its first cell must be a unit of time.
    """
    cells = [cell for cell in row if cell.lower() not in NO_UNIT and not is_number(cell)]
    units = [cell for cell in cells if is_unit(cell)]
    return bool(units) and (2 * len(units) >= len(cells) or spelled(row[0]) in TIME_UNITS)


@dataclass(frozen=True)
class ColumnLabels:
    """Names and units of columns, and the sample interval if the header gives it.

    clock: words of the header that give the interval; None if the header gives no interval.
    period_ns: interval of the rows in ns; None if the header gives no interval.
    start_ns: time of the first row in ns.
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    clock: str | None = None
    period_ns: float | None = None
    start_ns: float = 0.0


def labels(
    rows: Rows,
    first: int,
    header: int | None,
    unit: int | None,
    number: Callable[[str], float | None],
) -> ColumnLabels:
    """Return names and units of the columns, and the sample interval of the rows.

    first: index of the first row of numbers.
    header, unit: indices of the lines with the names and with the units; None for a missing line.
    number: function that returns the number in a cell, or None.
    """
    names = list(rows[header]) if header is not None else []
    beneath = list(rows[unit]) if unit is not None else []
    steps = _steps_beneath(names, beneath, number) or _steps_in(
        rows, first if header is None else header, number
    )
    width = len(rows[first])
    if names:
        if names[0][:1] in ("#", "%"):  # comment sign before the first name
            names = [names[0][1:].strip(), *names[1:]] if names[0][1:].strip() else names[1:]
        named = next(
            (
                index
                for index, name in enumerate(names)
                if steps and name.lower() in (START, INCREMENT)
            ),
            len(trimmed(names)),
        )
        width = min(len(names), max(width, named))
    parted = [_label(names, beneath, column, number) for column in range(width)]
    called = (
        distinct([name for name, _ in parted])
        if names
        else [str(column + 1) for column in range(width)]
    )
    clock, period, start = steps or (None, None, 0.0)
    return ColumnLabels(tuple(called), tuple(unit for _, unit in parted), clock, period, start)


def _label(
    names: Sequence[str], beneath: Sequence[str], column: int, number: Callable[[str], float | None]
) -> tuple[str, str | None]:
    """Return name and unit of a column.

    If the cell below the name contains a text that is not a unit, this text becomes the name.
    """
    name, unit = name_and_unit(names[column]) if column < len(names) else ("", None)
    below = beneath[column] if column < len(beneath) else ""
    if is_unit(below):
        return name, spelled(below)
    return (name if below.lower() in NO_UNIT or number(below) is not None else below), unit


def _steps_beneath(
    names: Sequence[str], beneath: Sequence[str], number: Callable[[str], float | None]
) -> tuple[str | None, float | None, float] | None:
    values = {name.lower(): number(cell) for name, cell in zip(names, beneath, strict=False)}
    increment = values.get(INCREMENT)
    start = values.get(START) or 0.0
    if increment is None or not (0.0 < increment < math.inf and math.isfinite(start)):
        return None
    return "increment", increment * 1e9, start * 1e9


def _steps_in(
    rows: Rows, end: int, number: Callable[[str], float | None]
) -> tuple[str | None, float | None, float] | None:
    for row in rows[:end]:
        value = number(row[1]) if len(row) > 1 else None
        if value is None or not 0.0 < value < math.inf:
            continue
        key, unit = name_and_unit(row[0].rstrip(": ="))
        unit = unit or (spelled(row[2]) if len(row) > 2 and is_unit(row[2]) else None)
        if _RATE.fullmatch(key) and (unit or "Hz") in RATE_UNITS:
            return key, RATE_UNITS[unit or "Hz"] / value, 0.0
        if _INTERVAL.fullmatch(key) and (unit or "s") in TIME_UNITS:
            return key, TIME_UNITS[unit or "s"] * value, 0.0
    return None


def distinct(names: Sequence[str]) -> list[str]:
    """Return the names, with the column number appended to each missing or repeated name."""
    count = Counter(names)
    return [
        name if name and count[name] == 1 else f"{name} (column {number})".strip()
        for number, name in enumerate(names, start=1)
    ]
