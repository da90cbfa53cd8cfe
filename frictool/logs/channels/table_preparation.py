"""Preparation of tables as bench.yaml requires: zero offsets, quadrature decoding, sample period.

RawTable ──▶ ZeroedTable ──▶ QuadratureTable ──▶ LatchedTable ──▶ mapping
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import factor_to_si
from frictool.errors import LogError
from frictool.logs.channels.deadband import deadband_doubts
from frictool.logs.channels.latched_table import NS, LatchedTable, row_times
from frictool.logs.channels.mapping import RATE_REFUSED, TIME
from frictool.logs.channels.quadrature_table import QuadratureTable
from frictool.logs.channels.zeroed_table import zeroed
from frictool.logs.raw_table import RawTable

# least share of intervals equal to the bench's period; a file with a row per change may have this
# period on average only
REGULAR = 0.9

FindingTexts = Callable[[], tuple[str, ...]]


def prepare_tables(
    tables: Sequence[RawTable], bench: Bench
) -> tuple[tuple[RawTable, ...], list[FindingTexts]]:
    """Return the prepared tables, and functions that return warnings.

    The functions must be called after the tables have been read. If bench.yaml has encoders in
    `quadrature`, LogError is raised if a channel of an encoder is missing, or if the file has
    several tables. If `layout.hold` is true, LogError is raised if most rows share their time with
    another row.
    """
    ready = tuple(zeroed(table, bench.columns) for table in tables)
    if not bench.quadrature:
        if bench.layout is not None and bench.layout.hold:
            ready = tuple(_latched(table, bench, held=True) for table in ready)
        doubts = tuple(text for table in ready for text in deadband_doubts(table, bench))
        return ready, [lambda: doubts]
    if len(ready) > 1:
        raise LogError(
            ready[0].source,
            f"has {len(ready)} tables with different times; allowed with `quadrature`: one table",
        )
    counted = QuadratureTable(ready[0], bench.quadrature)
    return (_latched(counted, bench),), [counted.findings]


def _latched(table: RawTable, bench: Bench, *, held: bool = False) -> RawTable:
    """Return the table resampled to one row per sample period.

    The table is returned unchanged if it already has such rows, or if it has no times.

    held: True if the file has a row only when a value changes.
    """
    time = None
    column = bench.columns.get("time")
    name = None if column is None else table.find(column.column)
    if column is not None and name is not None and name != table.clock:
        try:
            time = name, column.scale * factor_to_si(column.unit, TIME, bench.axis)
        except ValueError as error:
            raise LogError(
                table.source, f"columns.time.unit of bench {bench.name!r}: {error}"
            ) from None
    elif table.clock is None:
        return table  # rows without times are one bench period apart
    first, _ = next(
        iter(table.blocks([name] if time is not None and name else table.names[:1], [])), (None, 0)
    )
    period = bench.sample_period_s
    if first is not None:
        steps = np.diff(row_times(first, time)) / NS
        if held and steps.size and np.median(steps) == 0.0:
            raise LogError(
                table.source,
                "most rows share their time with another row; allowed with layout.hold: times "
                "that differ between rows; if the rows are equidistant, write layout.period_s",
            )
        if (
            not held
            and steps.size
            and np.mean(np.abs(steps / period - 1.0) <= RATE_REFUSED) > REGULAR
        ):
            return table
    period_ns = round(period * NS)
    return LatchedTable(table, period_ns, time, period_ns // 2 if held else 0)
