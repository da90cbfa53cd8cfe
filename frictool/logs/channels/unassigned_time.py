"""Time column that bench.yaml does not assign and that contradicts the stated sample period."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from frictool.documents.quantity import factor_to_si
from frictool.documents.starting_documents import quoted
from frictool.errors import LogError
from frictool.logs.channels.column_names import quantities, unit_in
from frictool.logs.quality.time_base import RATE_NOTED, coarse_period
from frictool.logs.raw_table import RawTable

# possible units of a time without a unit; spreadsheets count days
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "d": 86400.0}
FEWEST_ROWS = 8  # least number of rows from which a period is computed


class RowPeriod(NamedTuple):
    """Mean increase of a column per row, and its error due to rounding, in the column's unit."""

    mean: float
    error: float


def unassigned_time(table: RawTable, period: float) -> str | None:
    """Return a warning if a time column of the table contradicts the sample period; else None.

    A time column increases, and its unit or its name denotes a time. Successive rows may share a
    time, for example in whole seconds, if equally many rows share each time. A column that has no
    unit and increases by 1 per row is a row number and not a time. If one time column agrees with
    the sample period, the result is None.

    table: table whose rows are read at equal intervals, because bench.yaml assigns no time.
    period: sample period [s] of bench.yaml.
    """
    doubt = None
    for name in table.names:
        scales = _scales(table, name)
        found = _row_period(table, name) if scales else None
        if found is None or (len(scales) > 1 and found == (1.0, 0.0)):
            continue
        if any(
            abs(found.mean * scale - period) <= RATE_NOTED * period + found.error * scale
            for scale in scales.values()
        ):
            return None
        unit = min(scales, key=lambda one: abs(math.log(found.mean * scales[one] / period)))
        doubt = doubt or (
            f"rows are read {period:.4g} s apart (sample_period_s), but column {name!r} "
            f"increases by {found.mean * scales[unit]:.4g} s per row; if it is the time, add time: "
            f"{{column: {quoted(name)}, unit: {unit}}} to columns"
        )
    return doubt


def _scales(table: RawTable, name: str) -> dict[str, float]:
    """Return the possible units of a time column with their sizes in s; {} for other columns."""
    unit = table.units.get(name) or unit_in(name)
    if unit is None:
        return UNITS if quantities(name) == ["time"] else {}
    with suppress(ValueError):
        return {unit: factor_to_si(unit, "time", "rotary")}
    return {}


def _row_period(table: RawTable, name: str) -> RowPeriod | None:
    """Return the increase per row of a column in the first block; None if there is no increase."""
    with suppress(LogError):
        if table.find(name) is None:
            return None
        block, _ = next(iter(table.blocks([name], [])), (None, 0))
        values = np.empty(0) if block is None else block.columns[name]
        rows = np.flatnonzero(np.isfinite(values))
        if rows.size == values.size and (coarse := coarse_period(values)) is not None:
            return RowPeriod(*coarse)
        steps = np.diff(values[rows]) / np.diff(rows)
        if rows.size >= FEWEST_ROWS and steps.min() > 0.0:
            count = int(rows[-1] - rows[0])
            return RowPeriod(
                float(values[rows[-1]] - values[rows[0]]) / count, float(np.ptp(steps)) / count
            )
    return None
