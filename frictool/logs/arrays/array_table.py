"""Table of arrays that a file stores one after the other (MATLAB, NumPy).

Each column is read from a separate byte stream. A block of n rows consists of n values from every
stream.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.arrays.byte_streams import ByteStream
from frictool.logs.raw_table import (
    BLOCK_ROWS,
    SALVAGE,
    DataLoss,
    LostColumnError,
    Nanoseconds,
    RowBlock,
    common_rows,
    find,
)
from frictool.logs.unpacked_size import refusal

LONGEST_READABLE = 30  # maximum number of characters of the list of readable arrays in a message
_LINE = re.compile(r"(.+)([\[(])(:,)?([0-9]{1,6})(,:)?[\])]")
FIRST_YEAR, LAST_YEAR = 1678, 2261  # first and last full year that int64 ns since 1970 can express
STRIDED_BYTES = 1 << 22  # bytes of matrix rows that are read together for one column


@dataclass(frozen=True)
class ArrayColumn:
    """Location of the numbers of a column in a file.

    open: function that returns a stream of the bytes that contain the numbers.
    offset: position in bytes of the first number in that stream.
    dtype: NumPy type of the numbers.
    rows: number of values.
    step: bytes from the start of one number to the start of the next.
    unit: unit stated in the file; None if the file states none.
    """

    open: Callable[[], ByteStream]
    offset: int
    dtype: np.dtype[Any]
    rows: int
    step: int
    unit: str | None = None


class ColumnReader:
    """Reader that returns the numbers of a column in batches."""

    def __init__(self, column: ArrayColumn) -> None:
        self.column = column
        self.stream = column.open()
        self._before = column.offset  # bytes to skip before the next number

    def __enter__(self) -> ColumnReader:
        return self

    def __exit__(self, *_: object) -> None:
        self.stream.__exit__()

    def take(self, n: int) -> NDArray[Any]:
        """Return the next n numbers, or all remaining numbers if fewer than n remain."""
        size = self.column.dtype.itemsize
        step = self.column.step
        at_once = max(1, STRIDED_BYTES // step)
        parts = []
        for first in range(0, n, at_once):
            rows = min(at_once, n - first)
            self.stream.skip(self._before)
            data = self.stream.read((rows - 1) * step + size)
            self._before = step - size
            there = max(0, len(data) - size + step) // step
            parts.append(np.ndarray((there,), self.column.dtype, data, strides=(step,)))
        return np.concatenate(parts)


@dataclass
class ArrayTable:
    """Table of the arrays in one file (implements RawTable).

    columns: location of the numbers of each real vector, by name.
    others: description of each variable that is not a real vector, by name.
    damage: description of damage outside the columns; None if no such damage was found.
    dated: datetime64 column with the times of the rows; None if the file has no such column.
    """

    source: str
    columns: Mapping[str, ArrayColumn]
    size: int
    others: Mapping[str, str] = field(default_factory=dict)
    damage: str | None = None
    dated: ArrayColumn | None = None
    topic: str = ""
    clock: str | None = None

    def __post_init__(self) -> None:
        self.names = tuple(self.columns)
        self.units: Mapping[str, str | None] = {
            name: column.unit for name, column in self.columns.items()
        }

    def line(self, row: int) -> int | None:
        """Return None, because the rows have no line numbers."""
        return None

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing.

        A column of a matrix is named `x(:,1)` as in MATLAB or `x[:, 0]` as in NumPy. Raises
        LogError if `wanted` is not a real vector, or if `wanted` may be in the damaged part of the
        file.
        """
        if isinstance(wanted, str) and wanted in self.others and wanted != self.clock:
            raise LogError(
                self.source,
                f"variable {wanted!r} is a {self.others[wanted]}; allowed: a real vector, here "
                f"{listed(self.names)}",
            )
        name = find_array(self.names, wanted)
        if name is None and self.damage is not None:
            raise LostColumnError(
                self.source,
                f"is damaged: {self.damage}; readable: {listed(self.names, LONGEST_READABLE)}; "
                f"not readable: {wanted!r}",
            )
        return name

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks).

        Raises LogError if the columns differ in length, or if a column is truncated or damaged.
        """
        chosen = {name: self.columns[name] for name in wanted}
        every = {**({} if self.dated is None else {str(self.clock): self.dated}), **chosen}
        rows = common_rows(self.source, {name: column.rows for name, column in every.items()})
        read = 0
        if self.damage is not None and losses is None:
            raise LogError(self.source, f"is damaged: {self.damage}; {SALVAGE}")
        check_rows(self.source, self.size, rows, len(every))
        with ExitStack() as stack:
            feeds = {
                name: stack.enter_context(ColumnReader(column)) for name, column in every.items()
            }
            while read < rows:
                n = min(BLOCK_ROWS, rows - read)
                taken = {name: feed.take(n) for name, feed in feeds.items()}
                there = min(values.size for values in taken.values())
                if there:
                    time = (
                        None
                        if self.dated is None
                        else self._stamps(read, taken[str(self.clock)][:there])
                    )
                    block = RowBlock(
                        read,
                        {name: taken[name][:there].astype(np.float64) for name in chosen},
                        time,
                    )
                    read += there
                    yield block, self.size * read // rows
                if there < n:
                    break
            self._check({name: feed.stream for name, feed in feeds.items()}, rows, read, losses)

    def _stamps(self, row: int, dates: NDArray[Any]) -> Nanoseconds:
        with np.errstate(invalid="ignore"):
            years = dates.astype("M8[Y]").astype(np.float64) + 1970
        missing = np.flatnonzero(np.isnat(dates) | (years < FIRST_YEAR) | (years > LAST_YEAR))
        if missing.size:
            damage = f"{self.clock!r} has {dates[missing[0]]} at sample {row + int(missing[0]) + 1}"
            raise LogError(
                self.source, f"{damage}; allowed: a time in the years {FIRST_YEAR} to {LAST_YEAR}"
            )
        return dates.astype("M8[ns]").astype(np.int64)

    def _check(
        self, streams: Mapping[str, ByteStream], rows: int, read: int, losses: list[DataLoss] | None
    ) -> None:
        """Raise LogError if a stream ended early; with a list `losses`, append a loss instead.

        If all rows were read, the rest of each stream is read first, because the checksum of a
        stream is at its end.
        """
        if read == rows:
            for stream in streams.values():
                stream.check()
        after = f" after {read} of {rows} samples" if read < rows else ""
        damaged = [
            DataLoss((name,), f"variable {name!r} {s.damage}{after}", samples=rows - read)
            for name, s in streams.items()
            if s.damage
        ]
        if self.damage is not None and not damaged:  # damage elsewhere in the file
            damaged = [DataLoss((), self.damage, samples=0)]
        for loss in damaged:
            if losses is None:
                raise LogError(self.source, f"is damaged: {loss.reason}; {SALVAGE}")
            losses.append(loss)


def check_rows(source: str, size: int, rows: int, columns: int) -> None:
    """Raise LogError if a file of `size` bytes declares more rows than its size allows."""
    if reason := refusal(size, rows, columns):
        raise LogError(source, reason)


def find_array(names: Sequence[str], wanted: str | int) -> str | None:
    """Return the element `wanted` (name, or number from 1) of `names`; None if missing.

    The name of a matrix column may be in MATLAB's or in NumPy's notation.
    """
    name = find(names, wanted)
    return other_notation(names, str(wanted)) if name is None else name


def other_notation(names: Sequence[str], wanted: str) -> str | None:
    """Return the element of `names` that `wanted` denotes in another notation; None if missing.

    The names are those of matrix columns or rows. `wanted` may be in MATLAB's or in NumPy's
    notation. Blanks are ignored.
    """
    compact = {name.replace(" ", ""): name for name in names}
    match = _LINE.fullmatch(wanted.replace(" ", ""))
    if match is None:
        return None
    array, bracket, before, number, after = match.groups(default="")
    other = (
        f"({before}{int(number) + 1}{after})"
        if bracket == "["
        else f"[{before}{int(number) - 1}{after}]"
    )
    return compact.get(match.group()) or compact.get(array + other)
