"""Empty cells that mean an unchanged value, as in the export of a process historian."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from frictool.logs.raw_table import RowBlock


class HeldCells:
    """Filler that gives each empty cell the last number of its column, block by block.

    Rows at the start are left out until each column has a number. This rule ignores columns without
    a number in the first block of the file.
    """

    def __init__(self) -> None:
        self._last: dict[str, float] = {}

    def fill(self, block: RowBlock) -> RowBlock | None:
        """Return the block with all cells filled; None if no row is complete."""
        missing = {name: np.isnan(values) for name, values in block.columns.items()}
        first = 0
        if not self._last:
            empty = [mask for mask in missing.values() if not mask.all()]
            if not empty:
                return None
            first = max(int(np.argmin(mask)) for mask in empty)
        columns = {}
        for name, values in block.columns.items():
            at = np.maximum.accumulate(np.where(missing[name], -1, np.arange(values.size)))
            held = np.where(at < 0, self._last.get(name, np.nan), values[at])
            self._last[name] = float(held[-1])
            columns[name] = held[first:]
        time, recorded = (
            None if one is None else one[first:] for one in (block.time_ns, block.recorded_ns)
        )
        return replace(
            block,
            first_row=block.first_row + first,
            columns=columns,
            time_ns=time,
            recorded_ns=recorded,
        )
