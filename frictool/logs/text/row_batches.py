"""Rows of a text file in batches of bounded size."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.errors import LogError
from frictool.logs.kernels.row_scanner import ISSUE_FIELDS, PADDING, STAMP, read_rows
from frictool.logs.raw_table import BLOCK_ROWS, Nanoseconds
from frictool.typing import Vector

LONGEST_ROW = 16 << 20  # bytes, maximum size of a row
MOST_ISSUES = 4096  # maximum number of issues per call of the scanner
FEED = ord("\n")

# bytes of the text, and number of bytes of the file read so far
Pieces = Iterator[tuple[bytes, int]]


@dataclass(frozen=True)
class RowIssue:
    """Cell or row of a batch that the scanner could not convert to numbers.

    row: index of the row in the batch.
    kind: CELL, ROW or CUT (kernels/row_scanner.py).
    line: number of the line in the file.
    what: index of the column if `kind` is CELL; number of cells if `kind` is ROW.
    text: bytes of the cell or row.
    """

    row: int
    kind: int
    line: int
    what: int
    text: bytes


@dataclass(frozen=True)
class RowBatch:
    """Rows that the scanner has read.

    first_row: index of the first row in the file.
    rows: number n of rows.
    values: numbers (k, n) of the k numeric columns.
    stamps: times (n,) in ns; (0,) if no column has time stamps.
    issues: cells and rows that could not be converted.
    last_line: number of the line with the last row.
    done: number of bytes of the file read so far.
    """

    first_row: int
    rows: int
    values: Vector
    stamps: Nanoseconds
    issues: tuple[RowIssue, ...]
    last_line: int
    done: int


class TextWindow:
    """Text that the row scanner has not used yet; pieces of the file are appended to it.

    pieces: iterator over the pieces of the file.
    skipped: number of bytes that are left out at the start of the text.
    """

    def __init__(self, pieces: Pieces, skipped: int) -> None:
        self._pieces, self._skip = pieces, skipped
        self._text = np.full(PADDING, FEED, np.uint8)
        self._begin = self._end = 0
        self.done = 0
        self.last = False

    @property
    def text(self) -> NDArray[np.uint8]:
        """Return the unused bytes, followed by the line feeds that the scanner needs."""
        return self._text[self._begin :]

    @property
    def size(self) -> int:
        """Return the number of unused bytes."""
        return self._end - self._begin

    def use(self, count: int) -> None:
        """Mark the next `count` bytes as used."""
        self._begin += count

    def more(self) -> None:
        """Append the next piece of the file; set `last` if no piece is left."""
        piece = b""
        while not piece and not self.last:
            taken = next(self._pieces, None)
            if taken is None:
                self.last = True
                return
            piece, self.done = taken
            piece, self._skip = piece[self._skip :], max(0, self._skip - len(piece))
        left = self._text[self._begin : self._end]
        text = np.full(left.size + len(piece) + PADDING, FEED, np.uint8)
        text[: left.size] = left
        text[left.size : left.size + len(piece)] = np.frombuffer(piece, np.uint8)
        self._text = text
        self._begin = 0
        self._end = left.size + len(piece)


def batches(
    source: str,
    feed: TextWindow,
    first_line: int,
    dialect: tuple[int, int, int],
    slots: NDArray[np.int64],
    width: int,
    until: int | None = None,
) -> Iterator[RowBatch]:
    """Yield the rows of a text in batches of BLOCK_ROWS.

    source: name of the file for messages.
    feed: text whose first byte is in line `first_line` of the file.
    dialect: byte between cells, byte before decimals, and order of a date's parts (iso8601.py).
    slots: index of each column in `RowBatch.values`, or STAMP or SKIP (see `read_rows`).
    width: number of columns that are read as numbers.
    until: index of the last row to read; None for all rows.

    Raises LogError if a row is longer than LONGEST_ROW.
    """
    issues = np.zeros((max(MOST_ISSUES, slots.size + 3), ISSUE_FIELDS), np.int64)
    first = 0
    line = first_line
    while until is None or first <= until:
        rows = BLOCK_ROWS if until is None else min(BLOCK_ROWS, until + 1 - first)
        values = np.empty((width, rows))
        stamps = np.empty(rows if STAMP in slots else 0, np.int64)
        row = 0
        delimiter, mark, date_order = dialect
        dates = date_order if STAMP in slots else None
        last_line = line
        listed = []
        while row < rows:
            text = feed.text
            progress = read_rows(
                text,
                feed.size,
                feed.last,
                delimiter,
                mark,
                slots,
                values,
                stamps,
                issues,
                row,
                dates,
            )
            for at, kind, below, what, start, stop in issues[: progress.issues].tolist():
                listed.append(RowIssue(at, kind, line + below, what, text[start:stop].tobytes()))
            if progress.rows > row:
                last_line = line + progress.last_line
            row = progress.rows
            line = line + progress.lines
            feed.use(progress.used)
            if not progress.used:
                if feed.last:
                    break
                if feed.size > LONGEST_ROW:
                    raise LogError(
                        source,
                        f"is longer than {LONGEST_ROW >> 20} MB; is a quote left open?",
                        line=line,
                    )
                feed.more()
        if row:
            yield RowBatch(
                first, row, values[:, :row], stamps[:row], tuple(listed), last_line, feed.done
            )
        first += row
        if row < rows:
            return
