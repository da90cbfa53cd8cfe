"""Reader of JSON lines: files with one object per line. The path of a number is its column name.

    {"t": 0.001, "axis": {"pos": [0.1, 0.2]}}  ->  t, axis.pos[0], axis.pos[1]

A file may also be one JSON document with one list of samples, as the tool BAM writes it. Each
sample is a row; the numbers outside the list are constant columns.

    {"kp": 32, "entries": [{"position": 0.1}, {"position": 0.2}]}  ->  kp, position

The first key with a date or a time of day gives the times of the rows. A line that contains none of
the requested numbers gives no row. If a line lacks only some of these numbers, the missing numbers
are empty cells.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import msgspec
import numpy as np

from frictool.documents.bench import Layout
from frictool.errors import LogError
from frictool.logs.day_clock import DayClock
from frictool.logs.kernels.date_order import YEAR_FIRST
from frictool.logs.kernels.decimal_parser import NUMBER
from frictool.logs.kernels.iso8601 import scan_stamp
from frictool.logs.kernels.row_scanner import PADDING
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import (
    BLOCK_ROWS,
    SALVAGE,
    DataLoss,
    RawTable,
    RowBlock,
    find,
)
from frictool.logs.recordings.json_messages import LONGEST, JsonDecoder, decoded
from frictool.logs.text.cells import is_stamp

_START = re.compile(rb"(?:\xef\xbb\xbf)?\s*(\{\s*\"|\{\s*\}|\[\s*\{)")
NAMED_LINES = 200  # number of lines whose numbers give the columns
LARGEST_DOCUMENT = 100_000_000  # bytes
ONE_DOCUMENT = (
    "is one JSON document; write one object per line, for example by jq -c '.[]', or one object of "
    f"at most {LARGEST_DOCUMENT // 1_000_000} MB with one list of samples"
)


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file begins with a JSON object, or with an array of objects."""
    return _START.match(head) is not None


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return the table of the file.

    Raises LogError if the first line is not a JSON object, or if the first lines have no number.
    """
    return (JsonLinesTable(path),)


class JsonLinesTable:
    """Table of the objects in a file of JSON lines (implements RawTable)."""

    def __init__(self, path: Path) -> None:
        self.source = str(path)
        self.topic = ""
        self.size = path.stat().st_size
        self._path = path
        self._decoder = JsonDecoder()
        names: dict[str, None] = {}
        stamps: dict[str, None] = {}
        messages: list[Mapping[str, object]] = []
        self._document = _document_rows(path)
        with open_log(path) as stream:
            for row, (_, line) in enumerate(islice(self._rows(stream), NAMED_LINES)):
                try:
                    message = _object(line)
                    names.update(dict.fromkeys(self._decoder.names(line)))
                except ValueError:
                    if row == 0:
                        raise LogError(path, ONE_DOCUMENT) from None
                    continue  # `blocks` reports the line, or records it as lost
                stamps.update(dict.fromkeys(_dated(message)))
                messages.append(message)
        if len(messages) == 1 and any(map(_is_series, messages[0].values())):
            raise LogError(path, ONE_DOCUMENT)  # several lists of samples
        self.names = tuple(names)
        self.clock = next(iter(stamps), None)
        self.units: Mapping[str, str | None] = dict.fromkeys(self.names)
        if not self.names:
            raise LogError(
                path,
                f"has no number in its first {NAMED_LINES} lines; write numbers without quotes",
            )

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing."""
        return find(self.names, wanted)

    def line(self, row: int) -> int | None:
        """Return None, because not every line gives a row."""
        return None

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows, one row for each line (see RawTable.blocks)."""
        clock = DayClock()
        first = done = 0
        with open_log(self._path) as stream:
            numbered = self._rows(stream)
            while batch := list(islice(numbered, BLOCK_ROWS)):
                rows: list[Sequence[float]] = []
                times: list[int] = []
                for number, line in batch:
                    done += len(line)
                    try:
                        values = self._row(line, wanted)
                        if values is None:
                            continue
                        time = 0 if self.clock is None else self._time(line)
                    except ValueError as error:
                        if losses is None:
                            raise LogError(
                                self.source, f"{error}; {SALVAGE}", line=number
                            ) from None
                        losses.append(DataLoss((), f"line {number}: {error}", samples=1))
                        continue
                    rows.append(values)
                    times.append(time)
                if rows:
                    columns = np.array(rows, dtype=np.float64).reshape(len(rows), len(wanted))
                    stamps = clock.onward(np.array(times)) if self.clock is not None else None
                    yield (
                        RowBlock(
                            first,
                            {name: columns[:, k].copy() for k, name in enumerate(wanted)},
                            stamps,
                        ),
                        done,
                    )
                    first += len(rows)
        if not first:
            raise LogError(self.source, "has no rows")

    def _rows(self, stream: BinaryIO) -> Iterator[tuple[int, bytes]]:
        if self._document is None:
            yield from _lines(stream)
        else:
            yield from enumerate(map(msgspec.json.encode, self._document), 1)

    def _row(self, line: bytes, wanted: Sequence[str]) -> Sequence[float] | None:
        found = self._decoder.numbers_of(line)
        if wanted and not any(name in found for name in wanted):
            return None
        return [found.get(name, np.nan) for name in wanted]

    def _time(self, line: bytes) -> int:
        cell = _dated(_object(line)).get(str(self.clock))
        if cell is None:
            raise ValueError(f"key {self.clock!r}: found no time; allowed: a time in each line")
        text = np.full(len(cell) + PADDING, ord("\n"), np.uint8)
        text[: len(cell)] = np.frombuffer(cell.encode("ascii", "replace"), np.uint8)
        time, end, status = scan_stamp(text, 0, True, YEAR_FIRST)
        if status != NUMBER or end != len(cell):
            raise ValueError(
                f"key {self.clock!r}: found {cell!r}; allowed: a date and time such as "
                "2026-01-31T12:00:00.5"
            )
        return int(time)


def _lines(stream: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Yield (number, at most LONGEST + 2 bytes) of each nonblank line, without byte-order mark."""
    number = 0
    while line := stream.readline(LONGEST + 2):
        number += 1
        if number == 1:
            line = line.removeprefix(codecs.BOM_UTF8)
        if line.strip():
            yield number, line


def _document_rows(path: Path) -> list[dict[str, object]] | None:
    """Return the samples of a document with one list of samples; None for any other file.

    Each sample also contains the keys that are outside the list.
    """
    with open_log(path) as stream:
        lines = _lines(stream)
        first = next(lines, (0, b""))[1]
        whole = not first.rstrip().endswith((b"}", b"]")) or next(lines, None) is None
    if not whole or path.stat().st_size > LARGEST_DOCUMENT:
        return None
    with open_log(path) as stream:
        try:
            document = msgspec.json.decode(stream.read(LARGEST_DOCUMENT))
        except (msgspec.DecodeError, UnicodeDecodeError):
            return None
    if not isinstance(document, dict):
        return None
    series = [name for name, value in document.items() if _is_series(value)]
    if len(series) != 1:
        return None
    constants = {name: value for name, value in document.items() if name != series[0]}
    samples = [one for one in document[series[0]] if isinstance(one, dict)]
    return [constants | sample for sample in samples]


def _object(line: bytes) -> Mapping[str, object]:
    message = decoded(line)
    if not isinstance(message, Mapping):
        raise ValueError("is not a JSON object; allowed: one object per line")
    return message


def _is_series(value: object) -> bool:
    return isinstance(value, list) and len(value) > 1 and isinstance(value[0], Mapping)


def _dated(message: Mapping[str, object]) -> dict[str, str]:
    return {
        key: value for key, value in message.items() if isinstance(value, str) and is_stamp(value)
    }
