"""Guess of the columns, units, sample period and encoder step for a new bench.yaml from a log.

If the unit of a column contradicts a clear name, the column fits no channel and is not used. If the
unit contradicts a less clear name, the unit decides. Missing units, and the choice among several
columns that fit, become questions to the user (column_choice.py).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from frictool.documents.bench import COUNT, LONGEST_PERIOD, OPEN, SHORTEST_PERIOD, Layout
from frictool.documents.quantity import Axis, factor_to_si
from frictool.documents.starting_documents import StartingRig
from frictool.errors import LogError
from frictool.logs.arrays.memory_table import MemoryTable, in_memory
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.canonical.mcap_layout import NS
from frictool.logs.canonical.mcap_reader import is_canonical
from frictool.logs.channels.column_choice import (
    LABEL,
    OfferedColumn,
    changes,
    choose,
    dimension_of,
    is_count,
    names_motion,
)
from frictool.logs.channels.column_names import unit_in, words
from frictool.logs.channels.logger_presets import preset_of
from frictool.logs.channels.mapping import TIME
from frictool.logs.channels.question import ColumnQuestion
from frictool.logs.formats import open_tables
from frictool.logs.log import Log
from frictool.logs.quality.time_base import encoder_step, time_base
from frictool.logs.raw_table import EMPTY_CELL, HOLD, SALVAGE, RawTable
from frictool.logs.recordings.recording_files import sources
from frictool.typing import Vector

AXIS_NAMES: dict[Axis, set[str]] = {
    "rotary": {"angle", "theta", "omega", "rpm"},
    "linear": {"displacement"},
}
ROUND = 1e-3  # relative tolerance for rounding a period to 3 digits
MOST_ROWS = 1 << 18  # maximum number of rows read


@dataclass(frozen=True)
class ColumnGuess:
    """Channels, sample period and encoder step guessed from a file.

    columns: (column, unit) of each channel. A column or unit is OPEN if `questions` asks for it.
    left: names of the columns that are not used. Such a column cannot be read, fits no channel, or
        fits less well than another column.
    unreadable: reason why a column of `left` cannot be read, by column.
    period: sample period in s; None if unknown.
    step: encoder step in rad or m; None if unknown.
    questions: questions to the user about columns and units.
    preset: title of the preset (logger_presets.py) from which units were taken, or None.
    """

    axis: Axis
    columns: dict[str, tuple[str, str]] = field(default_factory=dict)
    left: tuple[str, ...] = ()
    unreadable: dict[str, str] = field(default_factory=dict)
    period: float | None = None
    step: float | None = None
    questions: tuple[ColumnQuestion, ...] = ()
    preset: str | None = None

    def asks(self, channel: str) -> bool:
        """Return True if there is a question about this channel."""
        return any(one.channel == channel for one in self.questions)

    @property
    def drive(self) -> Literal["current", "voltage"] | None:
        """Return "current" or "voltage", whichever channel the file has; None if it has neither.

        If the file has both, the result is "current".
        """
        return (
            "current"
            if "current" in self.columns
            else "voltage"
            if "voltage" in self.columns
            else None
        )


def guess_from(path: Path, axis: Axis | None = None, layout: Layout | None = None) -> ColumnGuess:
    """Guess columns, units, sample period and encoder step from a log or a ROS 2 bag.

    path: the log, or the folder of the bag.
    axis: kind of the axis; None to infer it from the log.
    layout: layout of the log; None to detect it.

    Raises LogError if the file cannot be read, or if the kind of the axis remains unknown.
    """
    (parts,) = sources([path])
    if len(parts) == 1 and is_canonical(parts[0]):
        return guess([_table(read_mcap(parts[0]))], axis)
    return guess(read_start(open_tables(parts, layout)), axis)


def start_from(
    log: Path,
    name: str,
    axis: Axis | None,
    log_path: str | None = None,
    layout: Layout | None = None,
) -> StartingRig:
    """Return the initial documents of a rig, with the columns and values guessed from a log.

    axis: kind of the axis; None to infer it from the log.
    layout: layout of the log; None to detect it.

    Raises LogError if the log cannot be read, or if the kind of the axis remains unknown.
    """
    start = guess_from(log, axis, layout)
    return StartingRig(
        name=name,
        axis=start.axis,
        log=log.name,
        log_path=log_path,
        drive=start.drive,
        columns=start.columns,
        left=start.left,
        unreadable=start.unreadable,
        period=start.period,
        step=start.step,
        axis_source="guessed" if axis is None else "given",
        preset=start.preset,
        layout=layout,
        percent=tuple(one.channel for one in start.questions if one.key == "scale"),
        questions={
            key: "; ".join(one.note for one in start.questions if one.channel == key)
            for key in start.columns
            if start.asks(key)
        },
    )


def read_start(tables: Sequence[RawTable]) -> list[MemoryTable]:
    """Return the first rows of each table with numbers; tables with more columns come first.

    Raises LogError if no table has numbers, or if a text file is in long format.
    """
    starts = [_start(table) for table in sorted(tables, key=lambda one: -len(one.names))]
    memory_tables = [start for start in starts if start is not None]
    if not memory_tables:
        for table in tables:
            if table.names:
                # raises LogError if the rows are invalid or damaged
                next(iter(table.blocks(table.names)), None)
        raise LogError(tables[0].source, "has no column with a finite number in its first rows")
    for table in tables:
        # a CsvTable only, whose import would load numba
        advice: str | None = getattr(table, "pivot_advice", None)
        if advice is not None and not guess(memory_tables, "rotary").columns.keys() - {TIME}:
            raise LogError(table.source, advice)
    return memory_tables


def _start(table: RawTable) -> MemoryTable | None:
    first, _ = next(iter(table.blocks(table.names, [])), (None, 0)) if table.names else (None, 0)
    if first is None:
        return None
    # text columns and columns of time stamps have no finite numbers
    names = [name for name, values in first.columns.items() if np.isfinite(values).any()]
    if not names:
        return None
    others = {name: _column_error(table, name) for name in first.columns if name not in names}
    texts = {name: error for name, error in others.items() if EMPTY_CELL not in str(error)}
    try:
        start = in_memory(table, names, MOST_ROWS)
        damaged = {}
    except LogError:
        start = in_memory(table, names, MOST_ROWS, [])
        damaged = {
            name: _column_error(table, name)
            for name, values in start.columns.items()
            if not np.isfinite(values).all()
        }
        readable = [name for name in names if damaged.get(name) is None]
        if not readable or len(readable) == len(names):
            raise
        # raises LogError if the damage is not confined to these columns
        in_memory(table, readable, MOST_ROWS)
    unreadable = {name: error for name, error in (texts | damaged).items() if error is not None}
    return replace(start, unreadable=unreadable)


def _column_error(table: RawTable, name: str) -> LogError | None:
    try:
        in_memory(table, [name], MOST_ROWS)
    except LogError as error:
        return error
    return None


def _table(log: Log) -> MemoryTable:
    return MemoryTable(
        {TIME: log.main.time, **log.main.signals}, {TIME: "s", **log.main.units}, log.source
    )


def guess(tables: Sequence[MemoryTable], axis: Axis | None = None) -> ColumnGuess:
    """Guess columns, units, sample period and encoder step from the tables of a file.

    Raises LogError if the kind of the axis remains unknown.
    """
    preset = preset_of([name for table in tables for name in table.columns])
    axis = axis or kind_of_axis(tables) or (None if preset is None else "rotary")
    if axis is None:
        wanting = "has no unit or name that shows if the axis is rotary or linear"
        raise LogError(
            tables[0].source, f"{wanting}; give --axis rotary (rad, N m) or --axis linear (m, N)"
        )
    offered = [(name, table) for table in tables for name in _liveliest_first(table)]
    count = Counter(name for name, _ in offered)
    entries = (
        {}
        if preset is None
        else preset.entries({name: table.columns[name] for name, table in offered})
    )
    once = [
        OfferedColumn(name, table, entries.get(name)) for name, table in offered if count[name] == 1
    ]
    chosen = choose(once, axis)
    used = {name for choice in chosen.values() for name in choice.columns}
    left = tuple(
        dict.fromkeys(name for name, table in offered if name not in used and name != table.clock)
    )
    unreadable = {name: error for table in tables for name, error in table.unreadable.items()}
    for choice in chosen.values():
        if choice.column in unreadable:
            error = unreadable[choice.column]
            text = _message(error)
            if "layout." not in text:  # the key of `layout` is the only remedy
                text += "; the guess needs this column: complete or delete this row"
            raise LogError(error.path, text, line=error.line)
    reasons = {name: _reason(error) for name, error in unreadable.items() if name not in used}
    columns = {channel: (choice.column, choice.unit) for channel, choice in chosen.items()}
    homes = {channel: choice.table for channel, choice in chosen.items()}
    main = homes.get("position", next(iter(homes.values()), tables[0]))
    questions = tuple(question for choice in chosen.values() for question in choice.questions)
    return ColumnGuess(
        axis,
        columns,
        tuple(dict.fromkeys((*left, *reasons))),
        reasons,
        _period(main, columns, axis),
        _step(main, columns, axis),
        questions,
        None if preset is None else preset.title,
    )


def _reason(error: LogError) -> str:
    text = _message(error).removesuffix(HOLD)
    return text if error.line is None else f"line {error.line}: {text}"


def _message(error: LogError) -> str:
    """Return the text of an error without file name, line number and advice on `--salvage`."""
    where = error.path if error.line is None else f"{error.path}:{error.line}"
    return str(error).removeprefix(f"{where}: ").removesuffix(f"; {SALVAGE}")


def _liveliest_first(table: MemoryTable) -> list[str]:
    label = {name: match[1] if (match := LABEL.search(name)) else "" for name in table.columns}
    moving = Counter(label[name] for name, values in table.columns.items() if changes(values))
    return sorted(table.columns, key=lambda name: -moving[label[name]])


def kind_of_axis(tables: Sequence[MemoryTable]) -> Axis | None:
    """Return the kind of axis from the units of positions and velocities, else from the names.

    The unit of a column may be the end of its name, as in `angle_deg`; a single letter, as in
    `theta_m`, may be a label and is not used. The result is None if neither units nor names
    indicate the kind, or if the units indicate both kinds. Without units, the result is also None
    if the names indicate both kinds.
    """
    units = [
        unit
        for table in tables
        for name in table.columns
        if (unit := table.units.get(name) or _long_unit(name)) and not is_count(unit)
    ]
    name_words = {word for table in tables for name in table.columns for word in words(name)}
    for axes in (
        {axis for axis in AXIS_NAMES for unit in units if names_motion(unit, axis)},
        {axis for axis, names in AXIS_NAMES.items() if name_words & names},
    ):
        if axes:
            return axes.pop() if len(axes) == 1 else None
    return None


def _long_unit(name: str) -> str | None:
    unit = unit_in(name)
    return unit if unit is not None and len(unit) > 1 else None


def _si(
    table: MemoryTable, columns: dict[str, tuple[str, str]], channel: str, axis: Axis
) -> Vector | None:
    name, unit = columns.get(channel, (OPEN, OPEN))
    if OPEN in (name, unit) or unit == COUNT or name not in table.columns:
        return None
    return table.columns[name] * factor_to_si(unit, dimension_of(channel), axis)


def _period(table: MemoryTable, columns: dict[str, tuple[str, str]], axis: Axis) -> float | None:
    """Return the sample period in s: the mean interval if the log has no gaps, else the median.

    The period is rounded to 3 digits if this changes the period by less than 0.1 %, else to 6
    digits. The result is None if bench.yaml does not allow this period, because the unit of time
    is then probably wrong.
    """
    time = _si(table, columns, TIME, axis)
    if time is None and table.time_ns is not None and table.time_ns.size:
        time = (table.time_ns - table.time_ns[0]) / NS
    if time is None or time.size < 2 or np.any(np.diff(time) <= 0.0):
        return None
    base = time_base(time)
    period = 1.0 / base.rate_hz if base.gaps else base.duration_s / (time.size - 1)
    if not SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
        return None
    short = float(f"{period:.3g}")
    return short if abs(short / period - 1.0) < ROUND else float(f"{period:.6g}")


def _step(table: MemoryTable, columns: dict[str, tuple[str, str]], axis: Axis) -> float | None:
    position = _si(table, columns, "position", axis)
    step = None if position is None else encoder_step(position)
    return None if step is None else float(f"{step:.6g}")
