"""Reader of CSV and similar text, in blocks, with a compiled scanner (kernels/row_scanner.py).

    bytes ──▶ layout, from the first lines (text_layout.py)
          ──▶ rows ──▶ RowBlock, RowBlock, ...
                └─ cells that the scanner rejects are examined here; they are blank, contain a
                   number in another notation, or contain no number

A cell that contains no number raises LogError, and so does a row with the wrong number of cells.
With `--salvage`, such a cell becomes NaN, and such a row is left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Layout
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import LATEST, NS
from frictool.logs.day_clock import DayClock
from frictool.logs.kernels.row_scanner import CELL, CUT, ROW, SKIP, STAMP
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import EMPTY_CELL, HOLD, SALVAGE, DataLoss, RowBlock, find
from frictool.logs.text.cells import THOUSANDS, number
from frictool.logs.text.held_cells import HeldCells
from frictool.logs.text.long_format import pivot_advice
from frictool.logs.text.row_batches import RowBatch, RowIssue, TextWindow, batches
from frictool.logs.text.text_encoding import decoded, encoding_of, head_bytes, is_text, text_bytes
from frictool.logs.text.text_layout import LONGEST_LINE, find_layout

NO_END = (
    "the last line has no line end: the file may be cut off; if it is complete, add a line end, or "
    "write layout.whole: true in bench.yaml"
)
OVER_RANGE = "\u221e"  # infinity sign, which a PicoScope writes for a sample out of its range
_DATE = re.compile(r"\d+[./-]\d+[./-]\d+\b")
_SHORT_YEAR = re.compile(r"\d\d?([./-])\d\d?\1\d\d\b")


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file may be text: its first bytes are UTF-16, or contain no NUL."""
    return is_text(head)


def tables(path: Path, layout: Layout | None = None) -> tuple[CsvTable, ...]:
    """Return the table of the file; raise LogError if it has no row of numbers."""
    return (CsvTable(path, layout or Layout()),)


class CsvTable:
    """Table of the rows of a text file (implements RawTable).

    description: text that describes the detected layout.
    """

    def __init__(self, path: Path, layout: Layout) -> None:
        with open_log(path) as stream:
            try:
                head = stream.read(LONGEST_LINE + 1)
            except OSError as error:
                raise LogError(path, f"cannot be read: {error.strerror or error}") from None
        self._path = path
        self._whole = layout.whole
        self._hold = layout.hold
        self.source = str(path)
        self.topic = ""
        self.size = path.stat().st_size
        encoding = encoding_of(head, layout.encoding)
        text = head_bytes(head, encoding)
        self.layout = text_layout = find_layout(
            path, decoded(text, encoding), len(head) >= self.size, encoding, layout
        )
        ends = re.finditer(rb"\r\n|\n|\r", text)
        self._start = (
            next((end.end() for end in islice(ends, text_layout.first_line - 2, None)), 0)
            if text_layout.first_line > 1
            else 0
        )
        self.names, self.clock, self.description = (
            text_layout.names[text_layout.metadata :],
            text_layout.clock,
            text_layout.description,
        )
        self.units = dict(zip(text_layout.names, text_layout.units, strict=True))

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing.

        Raises LogError if the column is missing because the file is in long format.
        """
        name = find(self.layout.names, wanted)
        if name is None and self.pivot_advice is not None:
            raise LogError(self.source, self.pivot_advice)
        return name

    @property
    def pivot_advice(self) -> str | None:
        """Return a message if the file is in long format (text/long_format.py), else None."""
        return pivot_advice(self.layout)

    def line(self, row: int) -> int | None:
        """Return the line number of the row `row` in the file; blank lines are counted, too."""
        slots = np.full(len(self.layout.names), SKIP)
        return next(
            (
                batch.last_line
                for batch in self._batches(slots, 0, row)
                if batch.first_row + batch.rows > row
            ),
            None,
        )

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks).

        If `losses` is a list, a cell that contains no number becomes NaN. A row is left out if it
        has the wrong number of cells or no valid time stamp.
        """
        chosen = [
            name
            for name in dict.fromkeys(wanted)
            if name != self.clock or self.layout.stamps is None
        ]
        slots = np.full(len(self.layout.names), SKIP)
        slots[[self.layout.names.index(name) for name in chosen]] = np.arange(len(chosen))
        if self.layout.stamps is not None:
            slots[self.layout.stamps] = STAMP
        if not self._hold:
            yield from self._read(chosen, slots, losses)
            return
        cells = HeldCells()
        for block, done in self._read(chosen, slots, losses):
            filled = cells.fill(block) if chosen else block
            if filled is not None:
                yield filled, done

    def _read(
        self, chosen: Sequence[str], slots: NDArray[np.int64], losses: list[DataLoss] | None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of the columns `chosen`, with NaN for a cell without a number."""
        rows = 0
        clock = DayClock()
        for batch in self._batches(slots, len(chosen), None):
            begin = 0
            for row, lost in self._judged(batch, slots, losses):
                if row > begin:
                    yield self._block(batch, chosen, begin, row, clock), batch.done
                if losses is not None and lost is not None and row >= begin:
                    losses.append(lost)
                begin = row + 1
            if batch.rows > begin:
                yield self._block(batch, chosen, begin, batch.rows, clock), batch.done
            rows = batch.first_row + batch.rows
        if not rows:
            raise LogError(self.source, "has no rows")

    def _block(
        self, batch: RowBatch, chosen: Sequence[str], begin: int, end: int, clock: DayClock
    ) -> RowBlock:
        first = batch.first_row + begin
        layout = self.layout
        columns = {
            name: values[begin:end] for name, values in zip(chosen, batch.values, strict=True)
        }
        if layout.stamps is not None:
            return RowBlock(first, columns, clock.onward(batch.stamps[begin:end]))
        if layout.period_ns is not None:
            with np.errstate(over="ignore", invalid="ignore"):
                time = np.rint(
                    layout.start_ns + np.arange(first, first + end - begin) * layout.period_ns
                )
            if not np.abs(time[[0, -1]]).max() < LATEST * NS:
                raise LogError(
                    self.source,
                    f"{layout.clock} results in times beyond {LATEST:g} s; check this value",
                )
            return RowBlock(first, columns, time.astype(np.int64))
        return RowBlock(first, columns)

    def _batches(
        self, slots: NDArray[np.int64], width: int, until: int | None
    ) -> Iterator[RowBatch]:
        layout = self.layout
        dialect = ord(layout.delimiter), ord(layout.mark), layout.dates
        feed = TextWindow(text_bytes(self._path, layout.encoding), self._start)
        return batches(self.source, feed, layout.first_line, dialect, slots, width, until)

    def _judged(
        self, batch: RowBatch, slots: NDArray[np.int64], losses: list[DataLoss] | None
    ) -> Iterator[tuple[int, DataLoss | None]]:
        """Yield (row, loss) for each row of a batch that is left out.

        The loss is None for a line of text that marks the end of the samples. Numbers in another
        notation are converted and stored in the batch. If `losses` is None, the first issue raises
        LogError.
        """
        for issue in batch.issues:
            cell = decoded(issue.text, self.layout.encoding).strip().strip('"').strip()
            value = (
                number(cell, self.layout.mark, self.layout.thousands)
                if issue.kind == CELL
                else None
            )
            if value is not None and slots[issue.what] >= 0:
                batch.values[slots[issue.what], issue.row] = value
                continue
            held = self._hold and issue.kind == CELL and not cell and slots[issue.what] >= 0
            if held or self._ignored(issue):
                continue
            if issue.kind == ROW and self.layout.trailer == cell:
                yield issue.row, None
                continue
            message = self._message(issue, cell)
            if losses is None:
                # True for a single damaged value; False if the whole file has another notation
                one = issue.kind == ROW or message.endswith("allowed: a number")
                if one and not cell and sum(not other.text for other in batch.issues) > 1:
                    message += HOLD
                raise LogError(
                    self.source, f"{message}; {SALVAGE}" if one else message, line=issue.line
                )
            if issue.kind != CELL or slots[issue.what] == STAMP:
                yield issue.row, DataLoss((), f"line {issue.line}: {message}", samples=1)

    def _ignored(self, issue: RowIssue) -> bool:
        if issue.kind == CUT:
            return self._whole or decoded(issue.text, self.layout.encoding) == self.layout.trailer
        columns = len(self.layout.names)
        return issue.kind == ROW and self.layout.commented and issue.what == columns + 1

    def _message(self, issue: RowIssue, cell: str) -> str:
        if issue.kind == CUT:
            return NO_END
        layout = self.layout
        if issue.kind == ROW:
            cut = "; is the file cut off here?" if issue.what < len(layout.names) else ""
            where = (
                f"the header in line {layout.header_line}"
                if layout.header_line
                else "the first row of numbers"
            )
            return f"has {issue.what} cells, but {where} has {len(layout.names)}{cut}"
        if cell.lstrip("+-") == OVER_RANGE:
            return (
                f"column {layout.names[issue.what]!r}: found {cell} (instrument out of range); "
                "allowed: a number; measure with a larger range; "
                f"{SALVAGE}"
            )
        shown = repr(cell if len(cell) <= 40 else cell[:37] + "...") if cell else EMPTY_CELL
        other = "," if layout.mark == "." else "."
        hint = (
            f" with a decimal {'point' if layout.mark == '.' else 'comma'}"
            if number(cell, other) is not None
            else ""
        )
        signs = [
            name
            for name, signs in THOUSANDS.items()
            if layout.mark not in signs and number(cell, layout.mark, signs) is not None
        ]
        if signs and signs[0] is not None and not hint:
            hint = (
                f"; does the {signs[0]} separate thousands? then write layout.thousands: "
                f"{signs[0]} in bench.yaml"
            )
        if issue.what == layout.stamps or _DATE.match(cell):
            hint = "" if issue.what == layout.stamps else " or "
            hint += "a date and time such as 2026-01-31T12:00:00.5"
            hint += ", with four digits of the year" if _SHORT_YEAR.match(cell) else ""
        allowed = hint if issue.what == layout.stamps else f"a number{hint}"
        return f"column {layout.names[issue.what]!r}: found {shown}; allowed: {allowed}"
