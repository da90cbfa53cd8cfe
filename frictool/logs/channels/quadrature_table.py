"""Table with encoder counts computed from the two recorded channels of an incremental encoder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from frictool.documents.bench import Quadrature
from frictool.logs.raw_table import DataLoss, DerivedTable, RawTable, RowBlock, pick


class QuadratureTable(DerivedTable):
    """Table with an additional column for the counts of each encoder in `encoders`."""

    def __init__(self, table: RawTable, encoders: Mapping[str, Quadrature]) -> None:
        super().__init__(table)
        self.names = (*table.names, *encoders)
        self.units = {**table.units, **dict.fromkeys(encoders, "count")}
        self._channels = {
            name: (self._channel_name(one.a), self._channel_name(one.b), one)
            for name, one in encoders.items()
        }
        self._illegal = dict.fromkeys(encoders, (0, 0))

    def _channel_name(self, wanted: str | int) -> str:
        name = self._table.find(wanted)
        return pick(self._table.names, wanted, self.source) if name is None else name

    def find(self, wanted: str | int) -> str | None:
        """Return the encoder or column `wanted` (name, or number from 1); None if missing."""
        if isinstance(wanted, str) and wanted in self._channels:
            return wanted
        return super().find(wanted)

    def findings(self) -> tuple[str, ...]:
        """Return a warning for each encoder whose two channels changed in the same sample."""
        return tuple(
            f"quadrature {name!r}: {bad} of {moves} transitions change both channels together; "
            "check that the sample rate exceeds four times the line rate, and that the threshold "
            "is between the levels"
            for name, (bad, moves) in self._illegal.items()
            if bad
        )

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks), with the counts of the requested encoders."""
        from frictool.logs.kernels.quadrature import ILLEGAL, UNKNOWN, count_quadrature

        made = [name for name in wanted if name in self._channels]
        plain = [name for name in wanted if name not in self._channels]
        raw = dict.fromkeys(
            [*plain, *(channel for name in made for channel in self._channels[name][:2])]
        )
        states = {name: np.array([UNKNOWN, UNKNOWN, 0, 0]) for name in made}
        moves = dict.fromkeys(made, 0)
        for block, done in self._table.blocks(tuple(raw), losses):
            columns = {name: block.columns[name] for name in plain if name in block.columns}
            for name in made:
                a, b, one = self._channels[name]
                half = one.hysteresis / 2.0
                before = float(states[name][2])
                counts = np.empty(block.columns[a].size)
                levels = block.columns[a] * one.probe, block.columns[b] * one.probe
                count_quadrature(
                    *levels, one.threshold - half, one.threshold + half, states[name], counts
                )
                moves[name] += int(np.count_nonzero(np.diff(counts, prepend=before)))
                bad = int(states[name][ILLEGAL])
                self._illegal[name] = bad, moves[name] + bad
                columns[name] = counts
            yield RowBlock(block.first_row, columns, block.time_ns), done
