"""Log of a raw file without bench.yaml: columns known by name and unit, not converted to SI."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import OPEN, Layout
from frictool.documents.quantity import Axis, factor_to_si
from frictool.errors import LogError
from frictool.logs.arrays.memory_table import MemoryTable
from frictool.logs.canonical.mcap_layout import COLUMNS, NS, message_path
from frictool.logs.channels.column_guess import ColumnGuess, guess, kind_of_axis, read_start
from frictool.logs.channels.mapping import TIME
from frictool.logs.formats import open_tables
from frictool.logs.log import MAIN_TOPIC, Log, Stream
from frictool.logs.losses import LOST, LossList, record_of
from frictool.logs.raw_table import DataLoss
from frictool.logs.recordings.recording_files import sources
from frictool.typing import Vector

GIVE = "give --bench bench.yaml (`frictool ingest --guess` proposes one)"


@dataclass(frozen=True)
class GuessedLog:
    """Log of a raw file, and the guessed assignment of its columns to channels."""

    log: Log
    guess: ColumnGuess


def guess_log(path: Path, layout: Layout | None = None) -> GuessedLog:
    """Return a log of the first rows of a raw file, in the units of the file.

    If the file has several tables, the table that contains the position is read. If no table
    contains a position, a table that contains another channel is read.

    layout: layout of the file; None to detect it.

    Raises LogError if the file cannot be read, gives no times, or has no recognisable channel.
    """
    (parts,) = sources([path])
    tables = read_start(open_tables(parts, layout))
    # default if neither units nor names decide; no unit here depends on the kind of axis
    axis: Axis = kind_of_axis(tables) or "rotary"
    guessed = guess(tables, axis)
    named = {channel: column for channel, (column, _) in guessed.columns.items() if column != OPEN}
    home = named.get(
        "position", next((column for channel, column in named.items() if channel != TIME), None)
    )
    if home is None:
        several = next((one for one in guessed.questions if one.key == "column"), None)
        if several is not None:
            raise LogError(path, f"columns.{several.channel}: {several.note}; {GIVE}")
        raise LogError(path, f"has no column with the name or the unit of a channel; {GIVE}")
    table = next(one for one in tables if home in one.columns)
    chosen = {channel: column for channel, column in named.items() if column in table.columns}
    time = _time(table, guessed, chosen.pop(TIME, None), axis)
    finite = {channel: np.isfinite(table.columns[column]) for channel, column in chosen.items()}
    rows = np.logical_and.reduce(list(finite.values())) & np.isfinite(time)
    lost = _lost(
        time,
        rows,
        {f"column {chosen[channel]!r}": mask for channel, mask in finite.items()}
        | {"its time": np.isfinite(time)},
    )
    time = time[rows]
    if time.size < 2 or (np.diff(time) <= 0.0).any():
        raise LogError(path, f"has no times that increase from row to row; {GIVE}")
    units = {channel: guessed.columns[channel][1] for channel in chosen}
    stream = Stream(
        MAIN_TOPIC,
        time,
        {channel: table.columns[column][rows] for channel, column in chosen.items()},
        units,
    )
    columns = {
        message_path(MAIN_TOPIC, channel): f"{column} [{units[channel]}]"
        for channel, column in chosen.items()
    }
    return GuessedLog(
        Log((stream,), {COLUMNS: columns} | ({LOST: record_of(lost)} if lost else {}), str(path)),
        guessed,
    )


def _lost(
    time: Vector, rows: NDArray[np.bool_], finite: dict[str, NDArray[np.bool_]]
) -> list[DataLoss]:
    lost = LossList()
    edges = np.flatnonzero(np.diff(rows.astype(np.int8), prepend=1, append=1))
    for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        names = [name for name, mask in finite.items() if not mask[first:end].all()]
        before, after = time[:first][rows[:first]][-1:], time[end:][rows[end:]][:1]
        start, stop = (float(one[0]) if one.size else None for one in (before, after))
        lost.append(
            DataLoss((), f"{' and '.join(names)}: no finite number", start, stop, end - first)
        )
    return lost


def _time(table: MemoryTable, guess: ColumnGuess, column: str | None, axis: Axis) -> Vector:
    if table.time_ns is not None and table.time_ns.size:
        return np.asarray((table.time_ns - table.time_ns[0]) / NS)
    unit = guess.columns[TIME][1] if column is not None else OPEN
    if column is None or unit == OPEN:
        raise LogError(table.source, f"does not contain the times of the rows; {GIVE}")
    return np.asarray(table.columns[column] * factor_to_si(unit, TIME, axis))
