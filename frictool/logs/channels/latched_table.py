"""Table sampled at the period of bench.yaml; each sample is the latest value of the column.

An oscilloscope samples far faster than the controller of the rig. A logic analyser writes a row
only when a signal changes. The log keeps the values that a controller with the sample period of
bench.yaml would have read from an input register.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from frictool.errors import LogError
from frictool.logs.raw_table import (
    BLOCK_ROWS,
    DataLoss,
    DerivedTable,
    Nanoseconds,
    RawTable,
    RowBlock,
    order_error,
)

NS = 1e9  # ns per s
MOST_HELD = 10_000_000  # maximum number of samples between two rows; a longer pause is an error


class LatchedTable(DerivedTable):
    """Table with one row per `period_ns` that contains the latest value of each column.

    time: (name of the time column, size of its unit in s); None if the blocks have `time_ns`.
    late_ns: delay in ns from each time of the new table until the columns are read. If the delay is
        half a period, a row with a rounded time belongs to the nearest time of the new table.
    """

    def __init__(
        self, table: RawTable, period_ns: int, time: tuple[str, float] | None, late_ns: int = 0
    ) -> None:
        super().__init__(table)
        self._period, self._time, self._late = period_ns, time, late_ns

    def line(self, row: int) -> int | None:
        """Return None, because the rows are not lines of the file."""
        return None

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks); raise LogError if time decreases."""
        read = wanted if self._time is None else tuple(dict.fromkeys([*wanted, self._time[0]]))
        start = before = row = 0
        last: dict[str, float] | None = None
        for block, done in self._table.blocks(read, losses):
            time = row_times(block, self._time)
            if last is None:
                start = int(time[0]) + self._late
                last = {name: float(values[0]) for name, values in block.columns.items()}
                before = int(time[0])
            self._check(block, time, before)
            before = int(time[-1])
            # number of rows that the samples so far determine
            end = int((time[-1] - start) // self._period) + 1
            while row < end:
                rows = np.arange(row, min(end, row + BLOCK_ROWS))
                at = np.searchsorted(time, start + rows * self._period, side="right")
                columns = {
                    name: np.concatenate([[last[name]], values])[at]
                    for name, values in block.columns.items()
                }
                yield self._block(rows, start, columns, wanted), done
                row += rows.size
            last = {name: float(values[-1]) for name, values in block.columns.items()}

    def _check(self, block: RowBlock, time: Nanoseconds, before: int) -> None:
        steps = np.diff(time, prepend=before)
        if np.any(steps < 0):
            row = int(np.argmax(steps < 0))
            damage = order_error(time[row], time[row] - steps[row])
            raise LogError(self.source, damage, line=self._table.line(block.first_row + row))
        row = int(np.argmax(steps))
        if steps[row] > MOST_HELD * self._period:
            pause = (
                f"no row for {steps[row] / NS:.4g} s; allowed: at most {MOST_HELD} samples of "
                "sample_period_s between two rows; check the unit of columns.time"
            )
            raise LogError(self.source, pause, line=self._table.line(block.first_row + row))

    def _block(
        self,
        rows: Nanoseconds,
        start: int,
        columns: dict[str, np.ndarray[tuple[int], np.dtype[np.float64]]],
        wanted: Sequence[str],
    ) -> RowBlock:
        time = start - self._late + rows * self._period
        if self._time is not None:
            name, seconds = self._time
            columns[name] = time / (NS * seconds)
        return RowBlock(
            int(rows[0]),
            {name: columns[name] for name in wanted},
            time if self._time is None else None,
        )


def row_times(block: RowBlock, time: tuple[str, float] | None) -> Nanoseconds:
    """Return the times (n,) in ns of the n rows of a block.

    time: (name of the time column, size of its unit in s); None if the block has `time_ns`.
    """
    if time is None:
        assert block.time_ns is not None
        return block.time_ns
    return np.rint(block.columns[time[0]] * (time[1] * NS)).astype(np.int64)
