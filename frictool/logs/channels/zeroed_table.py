"""Subtraction of a column's zero offset, the mean of the column's first samples.

An example is the offset of an amplifier, recorded while nothing moves.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from frictool.documents.bench import Channel, Column
from frictool.errors import LogError
from frictool.logs.raw_table import DataLoss, DerivedTable, LostColumnError, RawTable, RowBlock


class ZeroedTable(DerivedTable):
    """Table whose columns in `counts` have their zero offsets subtracted.

    counts: for each column, number of finite values at its start; their mean is the offset.
    """

    def __init__(self, table: RawTable, counts: Mapping[str, int]) -> None:
        super().__init__(table)
        self._counts = counts

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks), with the zero offsets subtracted."""
        zeros = {name: self._zero(name, losses) for name in wanted if name in self._counts}
        for block, done in self._table.blocks(wanted, losses):
            columns = {
                name: values - zeros[name] if name in zeros else values
                for name, values in block.columns.items()
            }
            yield replace(block, columns=columns), done

    def _zero(self, name: str, losses: list[DataLoss] | None) -> float:
        """Return the mean of the first values of a column.

        If there are too few values, their mean is returned and a note is appended to `losses`; if
        `losses` is None, LogError is raised. Without any value, LogError is raised in both cases.
        """
        wanted = self._counts[name]
        samples = np.empty(0)
        for block, _ in self._table.blocks([name], []):
            values = block.columns[name]
            samples = np.concatenate(
                [samples, values[np.isfinite(values)][: wanted - samples.size]]
            )
            if samples.size == wanted:
                return float(samples.mean())
        if losses is None or not samples.size:
            raise LogError(
                self.source,
                f"column {name!r} has {samples.size} samples, fewer than its zero_first_samples, "
                f"{wanted}",
            )
        losses.append(
            DataLoss(
                (name,),
                f"its zero is the mean of {samples.size} samples instead of {wanted}",
                samples=0,
            )
        )
        return float(samples.mean())


def zeroed(table: RawTable, columns: Mapping[Channel, Column]) -> RawTable:
    """Subtract the zero offsets that bench.yaml requests (`zero_first_samples`) from a table.

    A column that may be in the damaged part of the file is not changed; `bind` reports such a
    column.
    """
    counts: dict[str, int] = {}
    for one in columns.values():
        if one.zero_first_samples is not None:
            with suppress(LostColumnError):
                name = table.find(one.column)
                counts |= {} if name is None else {name: one.zero_first_samples}
    return ZeroedTable(table, counts) if counts else table
