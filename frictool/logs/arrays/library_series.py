"""Table whose columns are loaded by a library; one call loads a range of rows of one column."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictool.errors import LogError
from frictool.logs.arrays.reader_process import LibraryTable
from frictool.logs.raw_table import BLOCK_ROWS, SALVAGE, DataLoss, RowBlock

# (first row, end) -> numbers of a column, or times in ns
Series = Callable[[int, int], NDArray[Any]]


@dataclass(kw_only=True)
class SeriesTable(LibraryTable):
    """Table whose columns are functions (Series) that load a range of rows.

    rows: number of rows of every column.
    times: function that loads the times of a range of rows in ns; None if the file has no times.
    damage: description of damage in the file; None if no damage was found.
    """

    rows: int
    times: Series | None = None
    damage: str | None = None

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks)."""
        if self.damage is not None and losses is None:
            raise LogError(self.source, f"is damaged: {self.damage}; {SALVAGE}")
        for first in range(0, self.rows, BLOCK_ROWS):
            end = min(first + BLOCK_ROWS, self.rows)
            columns = {
                name: np.asarray(self.columns[name](first, end), np.float64) for name in wanted
            }
            time = None if self.times is None else np.asarray(self.times(first, end), np.int64)
            yield RowBlock(first, columns, time), self.size * end // self.rows
        if self.damage is not None and losses is not None:
            losses.append(DataLoss((), self.damage))


def loaded(values: NDArray[Any]) -> Series:
    """Return a function (Series) that returns a range of rows of the array `values`."""
    return lambda first, end: values[first:end]
