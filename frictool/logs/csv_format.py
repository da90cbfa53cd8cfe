"""Raw CSV of a bench: a header `name [unit]`, then rows of numbers between commas, semicolons or tabs.

The numbers are parsed by `numpy.loadtxt`. Only where it refuses the file is the file walked row by row, to say which line is wrong and why.
"""

from __future__ import annotations

import csv
import re
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import islice
from os import SEEK_END
from pathlib import Path
from typing import TextIO

import numpy as np

from frictool.documents.bench import Layout
from frictool.errors import LogError
from frictool.logs.log import Vector
from frictool.logs.raw_table import RawTable, Wanted, pick
from frictool.logs.source import open_log
from frictool.logs.table import BLOCK_ROWS, Block, Loss, find

DELIMITERS = ",;\t"
LONGEST_HEADER = 1_000_000  # characters
BLOCK_BYTES = 1 << 20
_NAME_AND_UNIT = re.compile(r"(.*?)\s*\[([^\[\]]*)\]")
NO_END = "the last line has no line end: the file may be cut; add a line end if it is whole"


@dataclass(frozen=True)
class Header:
    """The first line: how columns are parted, what they are called, their units; `line` is 0 where the file has none."""

    delimiter: str
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    line: int


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file may be text: it begins without a NUL character."""
    return b"\0" not in head


def tables(path: Path, layout: Layout | None = None) -> tuple[CsvTable, ...]:
    """The one table of the file. Raises LogError where it has no header."""
    return (CsvTable(path),)


class CsvTable:
    """The rows of a CSV file (a Table)."""

    def __init__(self, path: Path) -> None:
        open_log(path).close()
        self._path = path
        with _told(path), path.open(encoding="utf-8-sig", newline="") as text:
            self._header = _header(text, path)
        self.source, self.topic, self.clock, self.size = str(path), "", None, path.stat().st_size
        self.names = self._header.names
        self.units = dict(zip(self.names, self._header.units, strict=True))

    def find(self, wanted: str | int) -> str | None:
        return find(self.names, wanted)

    def blocks(self, wanted: Sequence[str], losses: list[Loss] | None = None) -> Iterator[tuple[Block, int]]:
        columns = read_csv(self._path, wanted).columns
        rows = next(iter(columns.values())).size
        for first in range(0, rows, BLOCK_ROWS):
            end = min(first + BLOCK_ROWS, rows)
            yield Block(first, {name: values[first:end] for name, values in columns.items()}), self.size * end // rows

    def line(self, row: int) -> int | None:
        return _line_of(self._path, self._header, row)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """What cannot be read as text, in one line."""
    try:
        yield
    except UnicodeDecodeError as error:
        raise LogError(path, f"is not UTF-8 text (byte {error.object[error.start]:#04x}); save it as UTF-8") from None
    except OSError as error:
        raise LogError(path, f"cannot be read: {error.strerror or error}") from None


def read_csv(path: Path, wanted: Wanted | None = None) -> RawTable:
    """The columns of a CSV file; `wanted` (names, or numbers from 1) leaves the others unparsed.

    Raises LogError with the line, the column, what was found and what is allowed.
    """
    open_log(path).close()
    with _told(path), path.open(encoding="utf-8-sig", newline="") as text:
        header = _header(text, path)
        chosen = header.names if wanted is None else tuple(dict.fromkeys(pick(header.names, one, str(path)) for one in wanted))
        columns = _load(text, path, header, chosen)
    units = dict(zip(header.names, header.units, strict=True))
    line_of = partial(_line_of, path, header)
    if not _ends_in_line_end(path):  # a number cut short is a number all the same: nothing else tells
        raise LogError(path, NO_END, line=line_of(next(iter(columns.values())).size - 1))
    return RawTable(columns, units, str(path), header.names, line_of)


def _load(text: TextIO, path: Path, header: Header, chosen: tuple[str, ...]) -> dict[str, Vector]:
    """The chosen columns of the rows that follow. Raises LogError where a row is ragged, a cell no number, or there is no row."""
    indexes = [header.names.index(name) for name in chosen]
    every = indexes == list(range(len(header.names)))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a file without rows, which is an error below
            values = np.loadtxt(
                text, delimiter=header.delimiter, comments=None, quotechar='"', ndmin=2, usecols=None if every else indexes, unpack=True
            )
    except UnicodeDecodeError:
        raise
    except ValueError as error:
        _locate(path, header, indexes)
        raise LogError(path, f"is no table of numbers: {error}") from None
    if values.size == 0:
        raise LogError(path, "has a header and no rows" if header.line else "has no rows")
    # with chosen columns loadtxt lets ragged rows pass: the number of delimiters tells
    if len(values) != len(indexes) or (not every and _delimiters(path, header) != _expected(values.shape[1], header)):
        _locate(path, header, indexes)
    return {name: np.ascontiguousarray(values[position]) for position, name in enumerate(chosen)}


def _header(text: TextIO, path: Path) -> Header:
    """Reads the first line that is not blank; leaves `text` at the first row of numbers."""
    line, number = "\n", 0
    while line in ("\n", "\r\n", "\r"):
        line, number = text.readline(LONGEST_HEADER), number + 1
    if not line.strip():
        raise LogError(path, "is empty; a table with a header is expected")
    if len(line) == LONGEST_HEADER:
        raise LogError(path, f"is longer than {LONGEST_HEADER} characters; a table with a header is expected", line=number)
    delimiter = max(DELIMITERS, key=line.count)
    cells = [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]
    if all(_is_number(cell) for cell in cells):
        text.seek(0)
        return Header(delimiter, tuple(str(column) for column in range(1, len(cells) + 1)), (None,) * len(cells), 0)
    matches = [_NAME_AND_UNIT.fullmatch(cell) for cell in cells]
    names = [match.group(1) if match else cell for match, cell in zip(matches, cells, strict=True)]
    units = tuple(match.group(2).strip().strip("-") or None if match else None for match in matches)
    return Header(delimiter, _distinct(names), units, number)


def _distinct(names: list[str]) -> tuple[str, ...]:
    """Names as they are; one without a name, or with the name of another, is called by its number as well."""
    count = Counter(names)
    return tuple(name if name and count[name] == 1 else f"{name} (column {number})".strip() for number, name in enumerate(names, start=1))


def _locate(path: Path, header: Header, indexes: list[int]) -> None:
    """Raises LogError at the first row that is ragged or has a cell that is no number; returns where there is none."""
    with path.open(encoding="utf-8-sig", newline="") as text:
        for _ in range(header.line):
            text.readline()
        rows = csv.reader(text, delimiter=header.delimiter)
        try:
            for row in rows:
                if row:
                    _check_row(path, header, indexes, row, header.line + rows.line_num)
        except csv.Error as error:
            raise LogError(path, str(error), line=header.line + rows.line_num) from None


def _check_row(path: Path, header: Header, indexes: list[int], row: list[str], line: int) -> None:
    if len(row) != len(header.names):
        cut = "; is the file cut off here?" if len(row) < len(header.names) else ""
        where = "the header" if header.line else "the first line"
        raise LogError(path, f"has {len(row)} cells, {where} has {len(header.names)}{cut}", line=line)
    for index in indexes:
        cell = row[index].strip()
        if not _is_number(cell):
            shown = repr(cell if len(cell) <= 40 else cell[:37] + "...") if cell else "an empty cell"
            hint = " with a decimal point" if _is_number(cell.replace(",", ".")) else ""
            raise LogError(path, f"column {header.names[index]!r}: found {shown}; allowed: a number{hint}", line=line)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _expected(rows: int, header: Header) -> int:
    return (rows + bool(header.line)) * (len(header.names) - 1)


def _delimiters(path: Path, header: Header) -> int:
    mark, count = header.delimiter.encode(), 0
    with path.open("rb") as stream:
        while block := stream.read(BLOCK_BYTES):
            count += block.count(mark)
    return count


def _ends_in_line_end(path: Path) -> bool:
    with path.open("rb") as stream:
        stream.seek(-1, SEEK_END)
        return stream.read() in (b"\n", b"\r")


def _line_of(path: Path, header: Header, row: int) -> int:
    """The line of a row, from 0, in the file: blank lines count as lines and not as rows."""
    with path.open(encoding="utf-8-sig", newline="") as text:
        filled = (number for number, line in enumerate(text, start=1) if number > header.line and line.strip("\r\n"))
        return next(islice(filled, row, None))
