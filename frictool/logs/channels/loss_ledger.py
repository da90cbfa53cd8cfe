"""Collection of the losses of one stream while the stream is read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.logs.canonical.mcap_layout import NS
from frictool.logs.losses import LossList
from frictool.logs.raw_table import DataLoss, Nanoseconds

Rows = NDArray[np.intp]  # indices into a block


class DroppedRows(NamedTuple):
    """Indices of rows of a block that are left out of all channels, and the reason."""

    reason: str
    rows: Rows


class LossLedger:
    """Collector of the losses of a stream, which are appended to `losses`.

    A loss is a gap in the data. Unless its times are known, the loss begins at the last sample
    before the gap and ends at the first sample after it.

    named: for each column, paths of the channels made from this column.
    every: paths of all channels.
    """

    def __init__(
        self, losses: LossList, named: Mapping[str, tuple[str, ...]], every: tuple[str, ...]
    ) -> None:
        self._losses, self._named, self._every = losses, named, every
        self._open: list[DataLoss] = []  # losses whose end is still unknown

    def take(self, inbox: list[DataLoss] | None, before: int | None) -> None:
        """Record the losses that the table has appended to `inbox` before its next block.

        before: time in ns of the last sample read; None before the first sample.
        """
        for loss in inbox or ():
            open_ended = loss.start_s is None and loss.end_s is None
            start = before / NS if open_ended and before is not None else loss.start_s
            named = replace(loss, channels=self._paths(loss.channels), start_s=start)
            (self._open if open_ended else self._losses).append(named)
        if inbox:
            inbox.clear()

    def reach(self, after: int) -> None:
        """Set the unknown ends of losses to `after` [ns], the time of the next sample."""
        for loss in self._open:
            self._losses.append(replace(loss, end_s=after / NS))
        self._open.clear()

    def drop(
        self, dropped: list[DroppedRows], kept: Rows, time: Nanoseconds, before: int | None
    ) -> None:
        """Record rows of a block that are left out.

        kept: indices of the rows that are kept.
        time: times of the kept rows in ns.
        before: time in ns of the last sample before the block; None before the first sample.
        """
        for reason, rows in dropped:
            for run in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
                low, high = np.searchsorted(kept, (run[0], run[-1]))
                start = int(time[low - 1]) if low else before
                loss = DataLoss(
                    self._every,
                    reason,
                    None if start is None else start / NS,
                    samples=int(run.size),
                )
                if high < kept.size:
                    self._losses.append(replace(loss, end_s=int(time[high]) / NS))
                else:
                    self._open.append(loss)

    def close(self) -> None:
        """Record the losses that last until the end of the stream."""
        for loss in self._open:
            self._losses.append(loss)
        self._open.clear()

    def _paths(self, columns: tuple[str, ...]) -> tuple[str, ...]:
        paths = tuple(
            dict.fromkeys(path for column in columns for path in self._named.get(column, (column,)))
        )
        return paths or self._every
