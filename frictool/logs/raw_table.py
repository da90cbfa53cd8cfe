"""Raw tables: named columns of a raw log file, before they are mapped to channels in SI.

A file has one table for each time base. Examples are the rows of a CSV file, a channel group of an
MDF file, and a topic of a recording. A table is read block after block, so that a log of several
hours needs little memory.

    RawTable ──blocks──▶ RowBlock, RowBlock, ... ──mapping──▶ samples in SI ──▶ canonical log

Damaged data raises LogError. With `--salvage`, damaged data is left out and recorded as a DataLoss.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from frictool.documents.name_list import LONGEST_LIST, listed
from frictool.errors import LogError
from frictool.typing import Vector

# maximum rows of a block; larger blocks of a file (chunks, records) are split
BLOCK_ROWS = 1 << 16
LONGEST_REASON = 60  # maximum number of characters of a library's error text in a message
LAYOUT = "layout"  # metadata record: file -> description of its detected layout
Nanoseconds = NDArray[np.int64]


@dataclass(frozen=True)
class DataLoss:
    """Samples that could not be read.

    channels: affected signals: names of columns if a table appends the loss, else paths of signals;
        empty if all signals are affected.
    reason: why the samples could not be read.
    start_s, end_s: first and last time of the loss, in s of log time; None if unknown.
    samples: number of lost samples; None if unknown.

    If both times are None, `ChannelMapper` sets them to the times of the samples before and after
    the loss. A table must therefore append a loss to `losses` before it yields the next block.
    """

    channels: tuple[str, ...]
    reason: str
    start_s: float | None = None
    end_s: float | None = None
    samples: int | None = None


class LostColumnError(LogError):
    """Error about a requested column that is missing, perhaps because the file is damaged.

    reason: the message without the name of the file.
    """

    def __init__(self, source: str, reason: str) -> None:
        self.reason = reason
        super().__init__(source, reason)


@dataclass(frozen=True)
class RowBlock:
    """Consecutive rows of a table.

    first_row: index of the block's first row in the table, from 0.
    columns: numbers (n,) of each requested column, as in the file; NaN for an empty cell.
    time_ns: exact times (n,) in ns, if each row has a time stamp (time of a recorded message,
        ISO 8601); None if the time is a column of numbers or missing.
    recorded_ns: times (n,) in ns at which the recorder stored the rows, if `time_ns` comes from
        another clock; else None.
    """

    first_row: int
    columns: dict[str, Vector]
    time_ns: Nanoseconds | None = None
    recorded_ns: Nanoseconds | None = None


class RawTable(Protocol):
    """Table of a raw file; all its columns have the same times.

    source: file name for messages.
    topic: name of the table in the file; "" if the file has only one table.
    names: columns in the order of the file; a column can be requested by name or by number.
    units: unit of each column as stated in the file; None if the file states no unit.
    clock: name of the clock that gives the times of the rows, such as `log time`; None if the time
        is a column.
    size: number of bytes that `blocks` processes in total.
    """

    source: str
    topic: str
    names: tuple[str, ...]
    units: Mapping[str, str | None]
    clock: str | None
    size: int

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing.

        Raises LogError if the column contains no numbers.
        """
        ...

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of the columns `wanted`, each with the number of bytes processed so far.

        If `losses` is None, damaged data raises LogError with the line or time, the column, the
        value found and the allowed values. Otherwise damaged data is left out, a loss is appended
        to `losses`, and reading continues.
        """
        ...

    def line(self, row: int) -> int | None:
        """Return the line number of the row `row` in the file; None if the file has no lines."""
        ...


class DerivedTable:
    """Base class of tables that are computed from another table; a subclass defines `blocks`.

    names, units: columns and units of the other table. A subclass may add columns.
    """

    def __init__(self, table: RawTable) -> None:
        self._table = table
        self.source = table.source
        self.topic = table.topic
        self.size = table.size
        self.clock = table.clock
        self.names = table.names
        self.units: Mapping[str, str | None] = table.units

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing."""
        return self._table.find(wanted)

    def line(self, row: int) -> int | None:
        """Return the line number of the row `row` in the file; None if the file has no lines."""
        return self._table.line(row)


@runtime_checkable
class DetectedLayout(Protocol):
    """Table of a text file whose layout was detected; `description` is the layout in messages."""

    description: str


# advice in messages about a damaged file
EMPTY_CELL = "an empty cell"
HOLD = ", or layout.hold: true in bench.yaml to repeat the last number"  # after "allowed: a number"
SALVAGE = "`ingest --salvage` keeps the readable part"


def order_error(time_ns: int, before_ns: int) -> str:
    """Return a message about a time in ns that does not exceed the time before it.

    >>> order_error(1772615550_000000000, 1772615550_020000000)
    'time does not increase: 1772615550 s after 1772615550.02 s'
    """
    texts = [f"{Decimal(int(at)).scaleb(-9).normalize():f} s" for at in (time_ns, before_ns)]
    return f"time does not increase: {' after '.join(texts)}"


def fail_at(table: RawTable, row: int, message: str) -> LogError:
    """Return an error about a row, with its line number or, if unknown, its sample number."""
    line = table.line(row)
    return LogError(
        table.source, message if line is not None else f"sample {row + 1}, {message}", line=line
    )


def find(names: Sequence[str], wanted: str | int) -> str | None:
    """Return the element `wanted` (name, or number from 1) of `names`; None if missing."""
    if isinstance(wanted, int):
        return names[wanted - 1] if 1 <= wanted <= len(names) else None
    return wanted if wanted in names else None


def common_rows(source: str, rows: Mapping[str, int]) -> int:
    """Return the common number of rows of all columns; 0 if there are no columns.

    rows: number of rows of each column.

    Raises LogError if the columns have different numbers of rows.
    """
    first = next(iter(rows), "")
    for name, n in rows.items():
        if n != rows[first]:
            mismatch = f"{first!r} has {rows[first]} samples, {name!r} has {n}"
            raise LogError(source, f"{mismatch}; allowed: the same number for all columns")
    return rows.get(first, 0)


def pick(names: Sequence[str], wanted: str | int, source: str, kind: str = "column") -> str:
    """Return the name of the column `wanted` (name, or number from 1).

    Raises LogError, with the nearest name and the available names, if there is no such column.
    """
    column = find(names, wanted)
    if column is not None:
        return column
    if isinstance(wanted, int):
        raise LogError(source, f"has no {kind} {wanted}; it has {len(names)}: {listed(names)}")
    near = difflib.get_close_matches(wanted, names, n=1, cutoff=0.5)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    found = listed(names, LONGEST_LIST - len(hint))
    numbered = list(names) == [str(number) for number in range(1, len(names) + 1)]
    without = " (the file has no header; columns are numbered from 1)" if numbered else ""
    raise LogError(source, f"has no {kind} {wanted!r}{hint}; found: {found}{without}")


def excerpt(reason: str) -> str:
    """Return the first LONGEST_REASON characters of a library's error text, which may be long."""
    return reason if len(reason) <= LONGEST_REASON else f"{reason[:LONGEST_REASON]}..."
