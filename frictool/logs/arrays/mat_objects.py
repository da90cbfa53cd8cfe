"""Reader of tables and timetables in MATLAB files, with mat-io (extra `matlab`).

The times of the rows are the row times of a timetable, or a column of dates or durations. The units
come from MATLAB's `VariableUnits`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictool.logs.arrays.library_series import SeriesTable, loaded
from frictool.logs.arrays.reader_process import LibraryTable
from frictool.logs.text.header_units import is_unit, spelled

UNITS = ("VariableUnits", "varUnits")  # names of the units of a table and of a timetable
TIMES = "Mm"  # dtype kinds of dates and durations


def can_read() -> bool:
    """Return True if mat-io is installed."""
    return find_spec("matio") is not None


def open_objects(path: Path) -> Sequence[LibraryTable]:
    """Return the tables and timetables of a file, without those that contain no numbers.

    This function runs in a child process, because mat-io may crash on a damaged file.
    """
    import matio
    import pandas

    variables: Mapping[str, Any] = matio.load_from_mat(str(path), add_table_attrs=True)
    frames = {
        name: value for name, value in variables.items() if isinstance(value, pandas.DataFrame)
    }
    tables = (_table(path, name, frame) for name, frame in frames.items())
    return [table for table in tables if table is not None]


def _table(path: Path, topic: str, frame: Any) -> SeriesTable | None:
    numbers = {str(name): frame[name].to_numpy() for name in frame if _kind(frame[name]) in "iufb"}
    dated = [(str(name), frame[name]) for name in frame if _kind(frame[name]) in TIMES]
    if _kind(frame.index) in TIMES:
        dated.insert(0, (str(frame.index.name), frame.index))
    if not numbers or not len(frame):
        return None
    texts = next((frame.attrs[key] for key in UNITS if frame.attrs.get(key)), ())
    given = dict(zip(map(str, frame.columns), texts, strict=False))
    units = {name: given.get(name, "") for name in numbers}
    clock, times = dated[0] if dated else (None, None)
    return SeriesTable(
        source=str(path),
        topic=topic,
        columns={name: loaded(values) for name, values in numbers.items()},
        units={name: spelled(unit) if is_unit(unit) else None for name, unit in units.items()},
        others={
            str(name): "no column of numbers"
            for name in frame
            if str(name) not in numbers and str(name) != clock
        },
        clock=clock,
        rows=len(frame),
        times=None if times is None else loaded(_nanoseconds(times)),
    )


def _kind(series: Any) -> str:
    return str(getattr(series.dtype, "kind", "O"))


def _nanoseconds(times: Any) -> NDArray[np.int64]:
    values = times.to_numpy()
    return np.asarray(values.astype(f"{values.dtype.kind}8[ns]").astype(np.int64))
