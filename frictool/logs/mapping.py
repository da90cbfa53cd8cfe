"""Raw columns to channels: `bench.columns` says which column is what, in which unit; here it becomes SI.

A channel is (scale * raw + offset) in the unit of the bench. In `count`, it is times the encoder's resolution and direction, and a
position is unwrapped first where the counter wraps.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.documents.bench import Bench, Column
from frictool.documents.quantity import CHANNEL_DIMENSIONS, factor_to_si, si_unit
from frictool.errors import LogError
from frictool.logs.log import MAIN_TOPIC, Log, Stream, Vector
from frictool.logs.mcap_layout import message_path
from frictool.logs.quality import time_base
from frictool.logs.raw_table import RawTable, Wanted, pick

TIME = "time"
COUNT = "count"
RATE_NOTED = 0.01  # relative difference of the log's period from the bench's
RATE_REFUSED = 0.2
KIND = "log"  # metadata record: what kind of log this is
COLUMNS = "columns"  # metadata record: MESSAGE PATH -> the raw column that it was made from


class Source(NamedTuple):
    """Where a channel comes from: the column of the file by its name, and what the bench says of it."""

    channel: str
    name: str
    column: Column

    @property
    def dimension(self) -> str:
        return CHANNEL_DIMENSIONS.get(self.channel, TIME)


def wanted_columns(bench: Bench) -> Wanted:
    """The columns that the bench maps."""
    return [column.column for column in bench.columns.values()]


def map_channels(table: RawTable, bench: Bench) -> Log:
    """The stream `/axis` of a raw table, in SI, with `effort` = actuator constant times drive where no column gives it.

    Raises LogError (with the line where the file has lines) where a column is missing, its unit contradicts the bench, a value is not
    finite, time does not increase, or the rate differs from the bench's by more than 20 %; less than that is a warning of the log.
    """
    if not bench.columns.keys() - {TIME}:
        raise LogError(table.source, f"bench {bench.name!r} maps no channel: columns needs at least one of {', '.join(CHANNEL_DIMENSIONS)}")
    names = table.names or tuple(table.columns)
    sources = [Source(channel, pick(names, column.column, table.source), column) for channel, column in bench.columns.items()]
    size = _common_size(table, sources)
    converted = {source.channel: _channel(table, bench, source) for source in sources}
    time: Vector = converted.pop(TIME) if TIME in converted else np.arange(size, dtype=np.float64) * bench.sample_period_s
    warnings = _check_time(table, bench, time)
    units = {channel: si_unit(CHANNEL_DIMENSIONS[channel], bench.axis) for channel in converted}
    drive = bench.actuator.drive
    if "effort" not in converted and drive in converted:
        converted["effort"] = bench.actuator.constant.value * converted[drive]
        units["effort"] = si_unit("effort", bench.axis)
    stream = Stream(MAIN_TOPIC, time, converted, units)
    metadata = {
        KIND: {"kind": "measured", "bench": bench.name, "axis": bench.axis},
        COLUMNS: {message_path(MAIN_TOPIC, source.channel): f"{source.name} [{source.column.unit}]" for source in sources},
    }
    return Log((stream,), metadata, table.source, warnings)


def _common_size(table: RawTable, sources: list[Source]) -> int:
    """The number of samples. Raises LogError where columns differ in it, or where there are fewer than 2."""
    first, *others = (source.name for source in sources)
    size = table.columns[first].size
    for name in others:
        if table.columns[name].size != size:
            found = f"{first!r} has {size} samples, {name!r} has {table.columns[name].size}"
            raise LogError(table.source, f"{found}; the columns of one log have one time base")
    if size < 2:
        raise LogError(table.source, f"has {size} row; a log has at least 2")
    return size


def _channel(table: RawTable, bench: Bench, source: Source) -> Vector:
    """One channel in SI."""
    name, column, raw = source.name, source.column, table.columns[source.name]
    bad = np.flatnonzero(~np.isfinite(raw))
    if bad.size:
        raise table.fail_at(int(bad[0]), f"column {name!r}: found {raw[bad[0]]}; allowed: a finite number")
    factor = _factor(table, bench, source)
    if source.channel == "position" and column.unit == COUNT and bench.encoder.wrap_bits is not None:
        raw = _unwrapped(table, name, raw, bench.encoder.wrap_bits)
    values: Vector = (raw * column.scale + column.offset) * factor
    return values


def _factor(table: RawTable, bench: Bench, source: Source) -> float:
    """What the scaled numbers of a channel are multiplied by to be in SI, checked against the unit in the file."""
    unit, given = source.column.unit, table.units.get(source.name)
    key = f"columns.{source.channel}.unit of bench {bench.name!r}"
    if unit == COUNT and source.dimension == "position":
        factor = bench.encoder.resolution * bench.encoder.direction
        agrees = given is None or given.lower() in (COUNT, "counts")
    else:
        try:
            factor = factor_to_si(unit, source.dimension, bench.axis)
        except ValueError as error:
            raise LogError(table.source, f"{key}: {error}") from None
        agrees = given in (None, unit) or _same(str(given), source.dimension, bench, factor)
    if not agrees and source.column.scale == 1.0:  # a scale may be what turns one unit into the other
        raise LogError(table.source, f"column {source.name!r} is in {given!r}, but {key} says {unit!r}; make them agree")
    return factor


def _same(unit: str, dimension: str, bench: Bench, factor: float) -> bool:
    try:
        return math.isclose(factor_to_si(unit, dimension, bench.axis), factor, rel_tol=1e-9)
    except ValueError:
        return False


def _unwrapped(table: RawTable, name: str, counts: Vector, bits: int) -> Vector:
    """Counts of a counter of `bits` bits, signed or unsigned, without its jumps; a real step is less than half its range."""
    modulus = 2.0**bits
    outside = np.flatnonzero(np.abs(counts) >= modulus)
    if outside.size:
        row = int(outside[0])
        raise table.fail_at(row, f"column {name!r}: found {counts[row]:.17g}; allowed: a counter of encoder.wrap_bits = {bits}")
    steps = np.diff(counts, prepend=counts[:1])
    unwrapped: Vector = counts[0] + np.cumsum(steps - modulus * np.rint(steps / modulus))
    return unwrapped


def _check_time(table: RawTable, bench: Bench, time: Vector) -> tuple[str, ...]:
    """Raises LogError where time does not increase or the rate is another; returns what is merely odd about it."""
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if back.size:
        row = int(back[0]) + 1
        raise table.fail_at(row, f"time does not increase: {time[row]:.9g} s after {time[row - 1]:.9g} s")
    return check_rate(table.source, time, bench)


def check_rate(source: str, time: Vector, bench: Bench) -> tuple[str, ...]:
    """Raises LogError where the period of increasing times (n,) in s is not the bench's; returns what is merely odd about them."""
    base = time_base(time)
    period = 1.0 / base.rate_hz
    difference = abs(period / bench.sample_period_s - 1.0)
    rates = f"the period is {period:.6g} s, the bench's sample_period_s {bench.sample_period_s:.6g} s"
    if difference > RATE_REFUSED:
        raise LogError(source, f"{rates}; allowed: within {RATE_REFUSED:.0%}; is the unit of time right?")
    noted = [rates] if difference > RATE_NOTED else []
    if base.gaps:
        noted.append(f"{base.gaps} gaps in time, the longest {base.longest_gap_s:.6g} s")
    return tuple(noted)
