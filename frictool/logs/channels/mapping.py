"""Conversion of raw columns to channels in SI, block by block.

`bench.columns` names the column and the unit of each channel. The value of a channel is (scale *
raw + offset) in that unit. A position in the unit `count` is first converted to unbounded counts
(encoder.py). Its value is multiplied by the encoder's resolution and direction. Wraps of positions
and references are removed (unwrapping.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from frictool.documents.bench import COUNT, Bench, Column
from frictool.documents.quantity import CHANNEL_DIMENSIONS, UnitScale, si_unit, unit_scale
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import LATEST, NS, StreamHeader, message_path
from frictool.logs.channels.column_names import PERCENT
from frictool.logs.channels.encoder import EncoderCounter, outside
from frictool.logs.channels.loss_ledger import DroppedRows, LossLedger, Rows
from frictool.logs.channels.unassigned_time import unassigned_time
from frictool.logs.channels.unwrapping import POSITION, Unwrapping
from frictool.logs.clocks.clock_drift import ClockPair
from frictool.logs.clocks.longest_increasing import increasing
from frictool.logs.clocks.sample_intervals import SampleIntervals
from frictool.logs.losses import LossList
from frictool.logs.quality.drive_range import beyond_limit
from frictool.logs.quality.jumps import JUMPS
from frictool.logs.quality.motion_check import motion_doubts
from frictool.logs.quality.opening_samples import OpeningSamples
from frictool.logs.quality.sign_check import sign_of
from frictool.logs.quality.time_base import RATE_NOTED, TimeBase, coarse_period
from frictool.logs.quality.wrap_line import shortest
from frictool.logs.raw_table import (
    SALVAGE,
    DataLoss,
    Nanoseconds,
    RawTable,
    RowBlock,
    fail_at,
    order_error,
)
from frictool.logs.stream_source import SampleBlock
from frictool.logs.text.header_units import ISO_8601
from frictool.typing import Vector

TIME = "time"
LARGEST = 1e100  # largest raw number, so that converted values stay finite
EFFORT = "effort"

MOST_COUNTS = 2.0**53  # largest count up to which a double represents every integer
ROUNDED = (
    "times are so large that a double resolves only {:.2g} s; count times from the start, or "
    "write ISO 8601"
)
# largest rounding error of a time without a warning, divided by the period; far below the jitter of
# common loggers
LARGEST_ROUNDING = 1e-3
# relative difference between the periods of log and bench above which there is an error if the
# periods have to agree
RATE_REFUSED = 0.2
# largest ratio of two periods of one bench; a larger ratio points to a mistaken unit of time
MOST_RATIO = 30.0


class ChannelSource(NamedTuple):
    """Raw column of a channel.

    channel: name of the channel, or `time`.
    name: name of the column in the file.
    column: entry of the channel in bench.yaml.
    scale: conversion of the unit to SI.
    """

    channel: str
    name: str
    column: Column
    scale: UnitScale

    def si(self, raw: Vector) -> Vector:
        """Convert raw values (n,) to SI."""
        return self.scale.si(raw * self.column.scale + self.column.offset)


class ChannelMapper:
    """Mapping of a table's columns to one stream (implements StreamSource).

    table: table of the raw file.
    bench: bench with the `columns` to map.
    columns: (entry in `bench.columns`, name of the table's column) of each channel and of `time`.
    topic: topic of the resulting stream.
    derive: True if `effort` is to be computed from the drive signal (current or voltage).
    period: expected sample period in s; None to accept any period.

    Raises LogError if a unit in bench.yaml contradicts the unit in the file.
    """

    def __init__(
        self,
        table: RawTable,
        bench: Bench,
        columns: Mapping[str, tuple[Column, str]],
        topic: str,
        derive: bool,
        period: float | None,
    ) -> None:
        self._table, self._bench, self._period = table, bench, period
        sources = [
            ChannelSource(channel, name, one, _scale(table, bench, channel, name, one))
            for channel, (one, name) in columns.items()
        ]
        self._time = next((one for one in sources if one.channel == TIME), None)
        self._sources = [one for one in sources if one.channel != TIME]
        self._wanted = tuple(dict.fromkeys(one.name for one in sources))
        self._drive = bench.actuator.drive if derive else None
        fields = [one.channel for one in self._sources] + ([EFFORT] if self._drive else [])
        self.head = StreamHeader(
            topic,
            tuple(fields),
            tuple(si_unit(CHANNEL_DIMENSIONS[name], bench.axis) for name in fields),
        )
        self.columns: Mapping[str, str] = {
            one.channel: f"{one.name} [{one.column.unit}]" for one in sources
        }
        self.source = table.source
        self.clock = table.clock if self._time is None else None
        self.size = table.size
        self.warnings: tuple[str, ...] = ()
        self._paths = {
            one.name: tuple(
                message_path(topic, other.channel) for other in sources if other.name == one.name
            )
            for one in sources
        }
        self._begin()

    def _begin(self) -> None:
        self.done, self.losses, self.warnings = 0, LossList(), ()
        self._counter = EncoderCounter(self._bench)
        self._intervals = SampleIntervals()
        self._opening = OpeningSamples(self.head)
        count = next(
            (one.scale.factor * one.column.scale for one in self._sources if _in_counts(one)), None
        )
        columns = {one.channel: one.name for one in self._sources}
        self._unwrapping = Unwrapping(self.source, self._bench, columns, count)
        self._clocks = ClockPair()
        self._rounding = 0.0  # s, spacing of doubles at the raw times of the file
        self._ledger = LossLedger(
            self.losses,
            self._paths,
            tuple(message_path(self.head.topic, name) for name in self.head.fields),
        )

    def samples(self, salvage: bool = False) -> Iterator[SampleBlock]:
        """Yield the samples in blocks (see StreamSource).

        In addition, raises LogError if times do not increase, if there are fewer than 2 samples, or
        if actual and expected period differ by more than a factor of 30.
        """
        self._begin()
        inbox: list[DataLoss] | None = [] if salvage else None
        for block, done in self._table.blocks(self._wanted, inbox):
            self._ledger.take(inbox, self._last)
            rows, dropped = self._finite(block, salvage)
            rows, time, unordered = self._in_order(block, rows, self._times(block, rows), salvage)
            if time.size:
                mapped = self._mapped(block, rows, time)
                self._ledger.reach(int(time[0]))
            self._ledger.drop([*dropped, *unordered], rows, time, self._last)
            self._intervals.add(time)
            self.done = done
            if block.time_ns is not None and block.recorded_ns is not None:
                self._clocks.take(block.time_ns, block.recorded_ns)
            if time.size:
                self._opening.take(mapped)
                if POSITION in self.head.fields:
                    self._unwrapping.check(
                        time / NS, mapped.values[self.head.fields.index(POSITION)]
                    )
                yield mapped
        self._ledger.take(inbox, self._last)
        self._ledger.close()
        self._unwrapping.finish()
        if self._intervals.samples < 2:
            raise LogError(
                self.source,
                f"has {self._intervals.samples} row{'s' * (not self._intervals.samples)}; "
                "allowed: at least 2",
            )
        opening = self._opening.stream
        sign = sign_of(opening).text(self._bench)
        # an effort that is computed from the drive signal is not in the file
        signals = {n: one for n, one in opening.signals.items() if n in self.columns}
        unit_doubt = beyond_limit(
            signals, {one.channel: one.name for one in self._sources}, self._bench
        )
        base = self._intervals.base()
        rate = check_rate(self.source, base, self._period)
        drift = self._clocks.finding(self.clock, 1.0 / base.rate_hz)
        share = self._rounding * base.rate_hz
        rounded = (ROUNDED.format(self._rounding),) if share > LARGEST_ROUNDING else ()
        equidistant = self._time is None and self.clock is None
        doubt = unassigned_time(self._table, self._bench.sample_period_s) if equidistant else None
        question = self._unwrapping.question
        counter = [
            text
            for text in self._counter.findings()
            if question is None or not text.startswith(JUMPS)
        ]
        self.warnings = (
            *self._idle_direction(),
            *rate,
            *rounded,
            *counter,
            *(text for text in (question, doubt, drift, sign, unit_doubt) if text),
            *motion_doubts(opening, self._bench),
        )

    def _idle_direction(self) -> tuple[str, ...]:
        position = next((one for one in self._sources if one.channel == POSITION), None)
        if self._bench.encoder.direction == 1 or position is None or _in_counts(position):
            return ()
        return (
            f"encoder.direction: -1 has no effect on columns.position in {position.column.unit}, "
            "only on counts and exported C; state the sign of the column in columns.position.scale",
        )

    @property
    def _last(self) -> int | None:
        return self._intervals.last_ns if self._intervals.samples else None

    def _finite(self, block: RowBlock, salvage: bool) -> tuple[Rows, list[DroppedRows]]:
        bad = {name: ~(np.abs(block.columns[name]) <= LARGEST) for name in self._wanted}
        bad = {name: mask for name, mask in bad.items() if mask.any()}
        if not bad:
            return np.arange(next(iter(block.columns.values())).size), []
        if not salvage:
            name, mask = next(iter(bad.items()))
            row = int(np.argmax(mask))
            error = (
                f"column {name!r}: found {block.columns[name][row]}; allowed: a finite number of "
                f"at most {LARGEST:g}; {SALVAGE}"
            )
            raise fail_at(self._table, block.first_row + row, error)
        dropped = []
        left = np.ones(next(iter(bad.values())).size, np.bool_)
        for name, mask in bad.items():
            rows = np.flatnonzero(mask & left)  # a row that lacks several numbers is counted once
            if rows.size:
                dropped.append(
                    DroppedRows(
                        f"column {name!r} has no finite number in this part of the log", rows
                    )
                )
            left &= ~mask
        return np.flatnonzero(left), dropped

    def _times(self, block: RowBlock, rows: Rows) -> Nanoseconds:
        if self._time is None and block.time_ns is not None:
            return block.time_ns[rows]
        if self._time is None:
            seconds = (block.first_row + rows) * self._bench.sample_period_s
        else:
            raw = block.columns[self._time.name][rows]
            seconds = self._time.si(raw)
            if raw.size:
                self._rounding = max(
                    self._rounding,
                    float(
                        np.spacing(np.abs(raw[-1]))
                        * abs(self._time.column.scale)
                        * self._time.scale.factor
                    ),
                )
        if seconds.size and np.abs(seconds).max() > LATEST:
            worst = int(np.argmax(np.abs(seconds)))
            error = (
                f"time: found {seconds[worst]:g} s; allowed: a magnitude of at most {LATEST:g} s; "
                "check its unit"
            )
            raise fail_at(self._table, block.first_row + int(rows[worst]), error)
        time: Nanoseconds = np.rint(seconds * NS).astype(np.int64)
        return time

    def _in_order(
        self, block: RowBlock, rows: Rows, time: Nanoseconds, salvage: bool
    ) -> tuple[Rows, Nanoseconds, list[DroppedRows]]:
        back = np.flatnonzero(time[1:] <= time[:-1]) + 1
        if time.size and self._last is not None and time[0] <= self._last:
            back = np.insert(back, 0, 0)
        if not back.size:
            return rows, time, []
        if not salvage:
            row = int(back[0])
            before = time[row - 1] if row else self._last or 0
            error = (
                f"{order_error(time[row], before)}; {self._order_remedy(time, time[row] == before)}"
            )
            raise fail_at(self._table, block.first_row + int(rows[row]), error)
        kept = increasing(time, self._last)
        return (
            rows[kept],
            time[kept],
            [DroppedRows("time does not increase", np.delete(rows, kept))],
        )

    def _order_remedy(self, time: Nanoseconds, equal: bool) -> str:
        """Return advice on times (n,) that do not increase; `equal`: True if a time is repeated."""
        coarse = coarse_period(time / NS)
        if coarse is not None and self._time is None:
            period, error = coarse
            _, text = shortest(period - error, period + error)
            return f"the times are too coarse: write layout.period_s: {text} in bench.yaml"
        if equal and self._time is not None:
            return f"if the times are too coarse, remove columns.time; {SALVAGE}"
        return SALVAGE

    def _mapped(self, block: RowBlock, rows: Rows, time: Nanoseconds) -> SampleBlock:
        every = rows.size == next(iter(block.columns.values())).size
        values: dict[str, Vector] = {}
        for one in self._sources:
            raw = block.columns[one.name] if every else block.columns[one.name][rows]
            if _in_counts(one):
                values[one.channel] = one.si(
                    self._counted(block, one, rows, time, self._unwrapping.follow(one.channel, raw))
                )
            else:
                values[one.channel] = self._unwrapping.follow(one.channel, one.si(raw))
        if self._drive is not None:
            values[EFFORT] = self._bench.actuator.constant.value * values[self._drive]
        return SampleBlock(time, tuple(values.values()))

    def _counted(
        self, block: RowBlock, source: ChannelSource, rows: Rows, time: Nanoseconds, raw: Vector
    ) -> Vector:
        bits = self._bench.encoder.wrap_bits
        if bits is None:
            allowed = "at most 2^53 counts"
            bad = next(iter(np.flatnonzero(np.abs(raw) > MOST_COUNTS).tolist()), None)
        else:
            allowed = f"a counter of encoder.wrap_bits = {bits}"
            bad = outside(raw, bits)
        if bad is not None:
            error = f"column {source.name!r}: found {raw[bad]:.17g}; allowed: {allowed}"
            raise fail_at(self._table, block.first_row + int(rows[bad]), error)
        return self._counter.follow(time / NS, raw)


def _in_counts(source: ChannelSource) -> bool:
    return source.channel == POSITION and source.column.unit == COUNT


def _scale(table: RawTable, bench: Bench, channel: str, name: str, column: Column) -> UnitScale:
    unit = column.unit
    declared = table.units.get(name)
    dimension = CHANNEL_DIMENSIONS.get(channel, TIME)
    key = f"columns.{channel}.unit of bench {bench.name!r}"
    if declared == ISO_8601:
        dates = "contains dates, which are already the times of the rows; remove it from columns"
        raise LogError(
            table.source,
            f"column {name!r} {dates} (found in columns.{channel} of bench {bench.name!r})",
        )
    if unit == COUNT and dimension == "position":
        scale = UnitScale(bench.encoder.position_per_count)
        agrees = declared is None or declared.lower() in (COUNT, "counts")
    else:
        try:
            scale = unit_scale(unit, dimension, bench.axis)
        except ValueError as error:
            raise LogError(table.source, f"{key}: {error}") from None
        agrees = declared in (None, unit) or _same(str(declared), dimension, bench, scale)
    if not agrees and column.scale == 1.0:  # a scale may convert one unit to the other
        remedy = "correct one of them"
        if declared == PERCENT:
            remedy = f"write scale: (full scale in {unit}) / 100; if this gives 1, use another unit"
        raise LogError(
            table.source, f"column {name!r} is in {declared!r}, but {key} is {unit!r}; {remedy}"
        )
    return scale


def _same(unit: str, dimension: str, bench: Bench, scale: UnitScale) -> bool:
    try:
        other = unit_scale(unit, dimension, bench.axis)
        return all(
            math.isclose(*pair, rel_tol=1e-9, abs_tol=1e-9 * abs(scale.zero))
            for pair in zip(other, scale, strict=True)
        )
    except ValueError:
        return False


def check_rate(
    source: str, base: TimeBase, wanted: float | None, *, same: bool = False
) -> tuple[str, ...]:
    """Return warnings about a stream's times; raise LogError if the period is wrong.

    wanted: expected period in s; None to accept any period.
    same: if True, the period may differ from the expected period by at most 20 %. If False, the two
        periods may differ by at most a factor of 30.
    """
    period = 1.0 / base.rate_hz
    noted = []
    if wanted is not None:
        difference = abs(period / wanted - 1.0)
        rates = f"the period is {period:.6g} s, but sample_period_s in bench.yaml is {wanted:.6g} s"
        if same and difference > RATE_REFUSED:
            raise LogError(
                source,
                f"{rates}; allowed: a difference of at most {RATE_REFUSED:.0%}; "
                "check the unit of time",
            )
        if max(period / wanted, wanted / period) > MOST_RATIO:
            raise LogError(
                source,
                f"{rates}; allowed: a factor of at most {MOST_RATIO:g}; check the unit of time",
            )
        if difference > RATE_NOTED:
            noted.append(rates)
    if base.gaps:
        noted.append(
            f"{base.gaps} gap{'s' * (base.gaps != 1)} in time, "
            f"the longest {base.longest_gap_s:.6g} s"
        )
    return tuple(noted)
