"""Rows of a text file in batches of bounded size: the bytes of the file are fed to the kernel
(kernels/row_scanner.py) piece after piece."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.errors import LogError
from frictool.logs.kernels.row_scanner import ISSUE_FIELDS, PADDING, STAMP, read_rows
from frictool.logs.log import Vector
from frictool.logs.table import BLOCK_ROWS, Nanoseconds

LONGEST_ROW = 16 << 20  # bytes
MOST_ISSUES = 4096  # that the kernel lists before they are taken from it
FEED = ord("\n")

Pieces = Iterator[tuple[bytes, int]]  # bytes of the text, and of the file read so far


@dataclass(frozen=True)
class RowIssue:
    """What is no plain number in row `row` of a batch: `kind` of kernels/row_scanner.py, `what` the
    column or the number of cells, its bytes."""

    row: int
    kind: int
    line: int
    what: int
    text: bytes


@dataclass(frozen=True)
class RowBatch:
    """Rows as the kernel gives them: values (slots, n), stamps (n,) or none; last_line: of the last
    row; bytes of the file read so far."""

    first_row: int
    rows: int
    values: Vector
    stamps: Nanoseconds
    issues: tuple[RowIssue, ...]
    last_line: int
    done: int


class TextWindow:
    """A window of the text that the kernel reads from: what it has used is dropped, what follows is
    appended."""

    def __init__(self, pieces: Pieces, skipped: int) -> None:
        self._pieces, self._skip = pieces, skipped
        self._text = np.full(PADDING, FEED, np.uint8)
        self._begin = self._end = 0
        self.done, self.last = 0, False

    @property
    def text(self) -> NDArray[np.uint8]:
        return self._text[self._begin :]

    @property
    def size(self) -> int:
        return self._end - self._begin

    def use(self, count: int) -> None:
        self._begin += count

    def more(self) -> None:
        """Appends the next piece; `last` where there was none."""
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
        self._text, self._begin, self._end = text, 0, left.size + len(piece)


def batches(
    source: str,
    feed: TextWindow,
    first_line: int,
    dialect: tuple[int, int],
    slots: NDArray[np.int64],
    width: int,
    until: int | None = None,
) -> Iterator[RowBatch]:
    """The rows of a text, BLOCK_ROWS at a time; with `until` no further than that row, so that the
    last batch ends with it.

    Args:
        source: for messages. feed: the text; its first byte is in line `first_line`.
        dialect: the bytes between cells and before decimals. slots: where each column goes, see
        `read_rows`; width: how many of values.

    Raises LogError where a row is longer than LONGEST_ROW.
    """
    issues = np.zeros((max(MOST_ISSUES, slots.size + 3), ISSUE_FIELDS), np.int64)
    first, line = 0, first_line
    while until is None or first <= until:
        rows = BLOCK_ROWS if until is None else min(BLOCK_ROWS, until + 1 - first)
        values = np.empty((width, rows))
        stamps = np.empty(rows if STAMP in slots else 0, np.int64)
        row, last_line, listed = 0, line, []
        while row < rows:
            text = feed.text
            progress = read_rows(
                text, feed.size, feed.last, *dialect, slots, values, stamps, issues, row
            )
            for at, kind, below, what, start, stop in issues[: progress.issues].tolist():
                listed.append(RowIssue(at, kind, line + below, what, text[start:stop].tobytes()))
            if progress.rows > row:
                last_line = line + progress.last_line
            row, line = progress.rows, line + progress.lines
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
