"""What a table goes through before its columns are mapped, where the bench asks for it: zeros, quadrature, the bench's period.

Table ──▶ Zeroed ──▶ Counted ──▶ Latched ──▶ mapping
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import factor_to_si
from frictool.errors import LogError
from frictool.logs.channels.latched import NS, Latched, row_times
from frictool.logs.channels.mapping import RATE_REFUSED, TIME
from frictool.logs.channels.quadrature import Counted
from frictool.logs.channels.zeroed import zeroed
from frictool.logs.table import Table

REGULAR = 0.9  # of the intervals: a file with a row where a channel changes may have the bench's period on average

Findings = Callable[[], tuple[str, ...]]


def prepared(tables: Sequence[Table], bench: Bench) -> tuple[tuple[Table, ...], list[Findings]]:
    """The tables as the bench wants them, and what tells of each, when it has been read, what was odd.

    Raises LogError where a channel of an encoder is in no table, or in a file of several.
    """
    ready = tuple(zeroed(table, bench.columns) for table in tables)
    if not bench.quadrature:
        return ready, []
    if len(ready) > 1:
        raise LogError(ready[0].source, f"has {len(ready)} time bases; quadrature is made of files of one")
    counted = Counted(ready[0], bench.quadrature)
    return (_latched(counted, bench),), [counted.findings]


def _latched(table: Table, bench: Bench) -> Table:
    """The table at the bench's period, unless it has that already."""
    time = None
    column = bench.columns.get("time")
    name = None if column is None else table.find(column.column)
    if column is not None and name is not None and name != table.clock:
        try:
            time = name, column.scale * factor_to_si(column.unit, TIME, bench.axis)
        except ValueError as error:
            raise LogError(table.source, f"columns.time.unit of bench {bench.name!r}: {error}") from None
    elif table.clock is None:
        return table  # rows that nothing dates are the bench's period apart
    first, _ = next(iter(table.blocks([name] if time is not None and name else table.names[:1], [])), (None, 0))
    period = bench.sample_period_s
    if first is not None:
        steps = np.diff(row_times(first, time)) / NS
        if steps.size and np.mean(np.abs(steps / period - 1.0) <= RATE_REFUSED) > REGULAR:
            return table
    return Latched(table, round(period * NS), time)
