"""What a bench file tells about its rig by itself: which column is which channel, its unit, the period, the encoder's step.

A unit is believed before a name. What is found is a guess, to be checked by who knows the rig; what fits nothing is left out.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from frictool.documents.bench import LONGEST_PERIOD, SHORTEST_PERIOD
from frictool.documents.quantity import CHANNEL_DIMENSIONS, Axis, factor_to_si, si_unit
from frictool.documents.starter import Start
from frictool.errors import LogError
from frictool.logs.formats import tables_of
from frictool.logs.log import Log, Vector
from frictool.logs.mapping import COUNT, TIME
from frictool.logs.mcap_layout import NS
from frictool.logs.mcap_reader import is_canonical, read_mcap
from frictool.logs.memory_table import MemoryTable, in_memory
from frictool.logs.quality import encoder_step, time_base
from frictool.logs.table import Table

# the first channel that a name fits is taken: a "position reference" is a reference
NAMES: dict[str, str] = {
    TIME: r"t|time|times|timestamp|temps|zeit",
    "reference": r"ref|reference|setpoint|target|desired|command|cmd|qg|consigne|sollwert",
    "voltage": r"u|v|vir|volt|voltage|tension|spannung",
    "current": r"i|iq|amp|amps|current|courant|strom",
    "velocity": r"vel|velocity|speed|omega|rpm|qd|dq|vitesse",
    "effort": r"effort|torque|force|tau|couple",
    "position": r"pos|position|angle|theta|encoder|enc|counter|count|counts|q|qm|x|y|displacement",
}
AXIS_NAMES: dict[Axis, set[str]] = {"rotary": {"angle", "theta", "omega", "rpm"}, "linear": {"displacement"}}
_ANGLE = re.compile(r"rad|deg|°|rev|rpm|turn|cycle", re.IGNORECASE)
ROUND = 1e-3
COUNTS = (COUNT, "counts", "ticks", "inc", "increments")


@dataclass(frozen=True)
class Guess:
    """columns: channel -> (column, unit). left: columns that fit no channel. period [s], step [SI]: None where the file does not tell."""

    axis: Axis
    columns: dict[str, tuple[str, str]] = field(default_factory=dict)
    left: tuple[str, ...] = ()
    period: float | None = None
    step: float | None = None

    @property
    def drive(self) -> Literal["current", "voltage"] | None:
        """What drives the axis, where the file has it."""
        return "current" if "current" in self.columns else "voltage" if "voltage" in self.columns else None


def guess_from(path: Path, axis: Axis | None = None) -> Guess:
    """What the log at `path` (CSV, MATLAB, canonical MCAP) tells; `axis` where it is known.

    Raises LogError where it cannot be read, and where neither `axis` nor the log tells the kind of axis.
    """
    if is_canonical(path):
        return guess(_table(read_mcap(path)), axis)
    table = max(tables_of(path), key=lambda one: len(one.names))  # of several time bases, the one with most columns
    return guess(in_memory(table, _numeric(table)), axis)


def start_from(log: Path, name: str, axis: Axis | None, log_path: str | None = None) -> Start:
    """A rig's documents to start from, with what the log tells. Raises LogError as `guess_from` does."""
    found = guess_from(log, axis)
    return Start(
        name=name,
        axis=found.axis,
        log=log.name,
        log_path=log_path,
        drive=found.drive,
        columns=found.columns,
        left=found.left,
        period=found.period,
        step=found.step,
        axis_source="guessed" if axis is None else "given",
    )


def _numeric(table: Table) -> list[str]:
    """The columns with numbers at their start: the others hold texts, or date the rows."""
    first, _ = next(iter(table.blocks(table.names, [])), (None, 0))
    if first is None:
        raise LogError(table.source, "has no row that can be read")
    return [name for name, values in first.columns.items() if np.isfinite(values).any()]


def _table(log: Log) -> MemoryTable:
    """The main stream of a canonical log."""
    return MemoryTable({TIME: log.main.time, **log.main.signals}, {TIME: "s", **log.main.units}, log.source)


def guess(table: MemoryTable, axis: Axis | None = None) -> Guess:
    """The guess for a table that has been read. Raises LogError where nothing tells the kind of axis."""
    axis = axis or _axis(table)
    if axis is None:
        wanting = "has no unit or name that tells a rotary from a linear axis"
        raise LogError(table.source, f"{wanting}; give --axis rotary (rad, N m) or --axis linear (m, N)")
    columns: dict[str, tuple[str, str]] = {}
    for name in table.columns:
        channel = _channel(name, table.units.get(name), axis, columns)
        if channel is not None:
            columns[channel] = (name, _unit(table, name, channel, axis))
    left = tuple(name for name in table.columns if name not in [column for column, _ in columns.values()])
    return Guess(axis, columns, left, _period(table, columns, axis), _step(table, columns, axis))


def _axis(table: MemoryTable) -> Axis | None:
    """The kind of axis that the units of positions and velocities tell, else the names; None where nothing tells, or both are told."""
    units = [unit for unit in table.units.values() if unit and not _is_count(unit)]
    words = {word for name in table.columns for word in re.split(r"[^a-z]+", name.lower())}
    for told in (
        {axis for axis in AXIS_NAMES for unit in units if _tells(unit, axis)},
        {axis for axis, names in AXIS_NAMES.items() if words & names},
    ):
        if told:
            return told.pop() if len(told) == 1 else None
    return None


def _tells(unit: str, axis: Axis) -> bool:
    """Whether only this kind of axis has positions or velocities in the unit; a per cent or a hertz would pass for an angle's."""
    named = axis == "linear" or _ANGLE.search(unit) is not None
    return named and any(_fits(unit, kind, axis) for kind in ("position", "velocity"))


def _is_count(unit: str) -> bool:
    return unit.lower() in COUNTS


def _fits(unit: str, dimension: str, axis: Axis) -> bool:
    if _is_count(unit):
        return dimension == "position"
    try:
        factor_to_si(unit, dimension, axis)
    except ValueError:
        return False
    return True


def _channel(name: str, unit: str | None, axis: Axis, taken: dict[str, tuple[str, str]]) -> str | None:
    """The channel of a column: its name's where the unit does not contradict it, else the only one left that has its unit."""
    fitting = [channel for channel in NAMES if channel not in taken and (unit is None or _fits(unit, _dimension(channel), axis))]
    words = set(re.split(r"[^a-z]+", name.lower()))
    named = [channel for channel in fitting if words & set(NAMES[channel].split("|"))]
    if named:
        return named[0]
    candidates = [channel for channel in fitting if channel != "reference"]
    return candidates[0] if unit is not None and len(candidates) == 1 else None


def _dimension(channel: str) -> str:
    return CHANNEL_DIMENSIONS.get(channel, TIME)


def _unit(table: MemoryTable, name: str, channel: str, axis: Axis) -> str:
    """The file's unit; without one, counts where a position has whole numbers only, else SI."""
    unit = table.units.get(name)
    if unit is not None:
        return COUNT if _is_count(unit) else unit
    values = table.columns[name]
    if _dimension(channel) == "position" and np.array_equal(values, np.rint(values)):
        return COUNT
    return si_unit(_dimension(channel), axis)


def _si(table: MemoryTable, columns: dict[str, tuple[str, str]], channel: str, axis: Axis) -> Vector | None:
    """A channel in SI, or None where the file does not have it in a unit that says so."""
    name, unit = columns.get(channel, ("", COUNT))
    return None if unit == COUNT else table.columns[name] * factor_to_si(unit, _dimension(channel), axis)


def _period(table: MemoryTable, columns: dict[str, tuple[str, str]], axis: Axis) -> float | None:
    """The sample period: the mean interval of a log without gaps, else the median; 3 digits where they say it within 0.1 %, else 6.

    None where no bench could have it: the time is in another unit than it seems.
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
