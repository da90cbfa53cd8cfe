"""Table whose columns are in memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from frictool.errors import LogError
from frictool.logs.raw_table import (
    BLOCK_ROWS,
    DataLoss,
    Nanoseconds,
    RawTable,
    RowBlock,
    common_rows,
    find,
)
from frictool.typing import Vector


@dataclass(frozen=True)
class MemoryTable:
    """Table with columns in memory (implements RawTable).

    columns: numbers (n,) of each column, by name.
    units: unit of each column as stated in the file; None if the file states no unit.
    time_ns: times (n,) of the rows in ns; None if the file gives no times.
    first_line: line of the first row in the file; None if the rows have no lines.
    unreadable: for each column with cells that are not numbers, error at the first such cell.
    """

    columns: Mapping[str, Vector]
    units: Mapping[str, str | None]
    source: str
    topic: str = ""
    clock: str | None = None
    time_ns: Nanoseconds | None = field(default=None, repr=False)
    first_line: int | None = None
    unreadable: Mapping[str, LogError] = field(default_factory=dict, repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the columns."""
        return tuple(self.columns)

    @property
    def size(self) -> int:
        """Return the size of the columns in bytes."""
        return 8 * sum(values.size for values in self.columns.values())

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing."""
        return find(self.names, wanted)

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows; raise LogError if the requested columns differ in length."""
        chosen = {name: self.columns[name] for name in wanted}
        rows = common_rows(self.source, {name: values.size for name, values in chosen.items()})
        for first in range(0, rows, BLOCK_ROWS):
            part = slice(first, first + BLOCK_ROWS)
            dated = None if self.time_ns is None else self.time_ns[part]
            yield (
                RowBlock(first, {name: values[part] for name, values in chosen.items()}, dated),
                self.size * min(part.stop, rows) // rows,
            )

    def line(self, row: int) -> int | None:
        """Return the line number of the row `row` in the file; None if the file has no lines."""
        return None if self.first_line is None else self.first_line + row


def in_memory(
    table: RawTable, wanted: Sequence[str], most: int, losses: list[DataLoss] | None = None
) -> MemoryTable:
    """Read the columns `wanted` of a table into memory, up to the block with row `most`.

    The result may have more than `most` rows, because blocks are not divided.

    losses: list to which losses are appended (see RawTable); None to raise LogError instead.
    """
    blocks = []
    rows = 0
    for block, _ in table.blocks(wanted, losses):
        blocks.append(block)
        rows = block.first_row + next(iter(block.columns.values())).size
        if rows >= most:
            break
    columns = {name: np.concatenate([block.columns[name] for block in blocks]) for name in wanted}
    dates = [block.time_ns for block in blocks if block.time_ns is not None]
    time_ns = np.concatenate(dates) if dates else None
    return MemoryTable(
        columns,
        {name: table.units.get(name) for name in wanted},
        table.source,
        table.topic,
        table.clock,
        time_ns,
    )
