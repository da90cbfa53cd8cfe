"""What a raw bench file gives before its columns mean anything: tables of named columns, read in
blocks.

A file holds one table for each of its time bases: the rows of a CSV, a channel group of an MDF
file, a topic of a recording. A table is read block after block, so that a log of hours fits in
little memory; mapping (mapping.py) and the canonical writer follow block by block.

    Table ──blocks──▶ Block, Block, ... ──mapping──▶ samples in SI ──▶ canonical log
       └─ damage: LogError, or a Loss each where the user asked to salvage
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from frictool.errors import LogError
from frictool.logs.log import Vector

BLOCK_ROWS = (
    1 << 16
)  # rows of a block, at most; a reader whose file has its own blocks (chunks, records) gives those, split
MOST_NAMES_SHOWN = 12
LONGEST_LIST = 200  # most characters of the names in a message
LAYOUT = "layout"  # metadata record: file -> how it was found to be laid out
Nanoseconds = NDArray[np.int64]


@dataclass(frozen=True)
class DataLoss:
    """Samples that could not be read, and why: of which channels, in which span of the log's time
    [s], how many where that is known.

    A table names its columns, or none where all of them are lost, and leaves the span open where it
    does not know it: the mapper fills in the samples before and after, as long as the loss is
    appended before the next block is given.
    """

    channels: tuple[str, ...]
    reason: str
    start_s: float | None = None
    end_s: float | None = None
    samples: int | None = None


class LostColumnError(LogError):
    """A column that the file may have had behind where it is damaged. reason: the message without
    the file."""

    def __init__(self, source: str, reason: str) -> None:
        self.reason = reason
        super().__init__(source, reason)


@dataclass(frozen=True)
class RowBlock:
    """Rows of a table that follow one another.

    first_row: index of the first of them in the table, from 0. columns: name -> (n,) numbers as
    they stand in the file, those that were asked for; nan where the cell is empty. time_ns: (n,)
    where the file itself dates its rows (a recording's messages, ISO 8601): exact, of any epoch;
    None where time is a column like any other, or where there is none. recorded_ns: (n,) when the
    recorder has dated them, where time_ns is another clock's.
    """

    first_row: int
    columns: dict[str, Vector]
    time_ns: Nanoseconds | None = None
    recorded_ns: Nanoseconds | None = None


class RawTable(Protocol):
    """One time base of a raw file.

    source: the file, for messages. topic: what the file calls the table, "" where it has but one.
    names: its columns in their order, so that one can be asked for by its number. units: name ->
    unit that the file gives, or None. clock: what dates its rows (`header.stamp`, `log time`, ...),
    None where a column does. size: bytes that `blocks` works through, for its progress.
    """

    source: str
    topic: str
    names: tuple[str, ...]
    units: Mapping[str, str | None]
    clock: str | None
    size: int

    def find(self, wanted: str | int) -> str | None:
        """The name of the column that is asked for by name or by number from 1; None where the
        table has none of that name.

        Raises LogError where it is there and holds no numbers. A table whose columns have names as
        they stand leaves it to `find`.
        """
        ...

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """The rows of the columns `wanted`, block after block, each with the bytes worked through
        so far.

        Without `losses` damage raises LogError that names line or time, column, what was found and
        what is allowed. With it what cannot be read is left out and appended to it, and the rest is
        read.
        """
        ...

    def line(self, row: int) -> int | None:
        """The line of a row in the file, or None where the file has no lines."""
        ...


@runtime_checkable
class DetectedLayout(Protocol):
    """A table whose layout was found in the file. told: how, for people."""

    told: str


SALVAGE = "`frictool ingest --salvage` keeps what is whole"  # what to try where a file is damaged


def fail_at(table: RawTable, row: int, message: str) -> LogError:
    """The error about one row: it names the line, or the sample where the file has no lines."""
    line = table.line(row)
    return LogError(
        table.source, message if line is not None else f"sample {row + 1}, {message}", line=line
    )


def find(names: Sequence[str], wanted: str | int) -> str | None:
    """The one of `names` that is asked for by name or by number from 1, or None."""
    if isinstance(wanted, int):
        return names[wanted - 1] if 1 <= wanted <= len(names) else None
    return wanted if wanted in names else None


def pick(names: Sequence[str], wanted: str | int, source: str, kind: str = "column") -> str:
    """The name of the column that is asked for by name or by number from 1.

    Raises LogError with the nearest name and what there is.
    """
    found = find(names, wanted)
    if found is not None:
        return found
    if isinstance(wanted, int):
        raise LogError(source, f"has no {kind} {wanted}; it has {len(names)}: {listed(names)}")
    near = difflib.get_close_matches(wanted, names, n=1, cutoff=0.5)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    numbered = list(names) == [str(number) for number in range(1, len(names) + 1)]
    without = " (no header was found: columns are called by their number)" if numbered else ""
    raise LogError(source, f"has no {kind} {wanted!r}{hint}; found: {listed(names)}{without}")


def listed(names: Collection[str]) -> str:
    """Return names for a message, as many as fit one line; an empty name is shown in quotes."""
    shown: list[str] = []
    for name in names:
        if len(shown) == MOST_NAMES_SHOWN or (
            shown and sum(map(len, shown)) + len(name) > LONGEST_LIST
        ):
            break
        shown.append(name or "''")
    return (
        ", ".join(shown)
        + (f" and {len(names) - len(shown)} more" if len(names) > len(shown) else "")
        if shown
        else "nothing"
    )
