"""Stream of motion blocks from a log of any format; only parts of the log are in memory.

    file ──logs/log_assembly.py──▶ samples of one stream, SI ──▶ MotionBlock, MotionBlock, ...

The columns of a raw log are mapped by the model's bench; a canonical log needs no mapping. A gap is
an interval between two samples that differs from the period by more than a tenth. A block ends at a
gap, and the next block has `follows` False.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.canonical.sample_chunks import join_blocks
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log import MAIN_TOPIC, Log, Stream
from frictool.logs.log_assembly import (
    EVERYTHING,
    LogAssembly,
    PendingStream,
    TimeWindow,
    assemble,
    start_streams,
)
from frictool.logs.losses import loss_count_text
from frictool.logs.quality.opening_samples import OpeningSamples
from frictool.logs.quality.sign_check import sign_of
from frictool.logs.quality.time_base import RATE_NOTED, time_base
from frictool.logs.raw_table import DataLoss, pick
from frictool.logs.stream_source import SampleBlock
from frictool.observe.motion_block import MotionBlock
from frictool.typing import Vector

JITTER = 0.1  # relative deviation from the period above which an interval is a gap
MOST_BROKEN = 0.2  # largest fraction of gaps among the intervals of a uniform clock
FEWEST = 3  # smallest number of samples of a stream that is observed
LARGEST = 1e12  # largest absolute value of a signal, SI
# smallest number of samples of a block, except the last; each block costs a fixed computing time
PIECE_SAMPLES = 1 << 14
# largest number of first samples of a log that are compared with the bench
OPENING_SAMPLES = 1 << 16


@dataclass
class SampleStream:
    """Stream of samples of a log; the fields are complete when the iterator `pieces` has ended.

    - made: streams of the log, as read from the file
    - bench: bench with which the log is read
    - topic: name of the stream
    - period: sample period [s] of the bench, or of the log if the two differ by more than 1 %
    - truth: True if the velocity in the log comes from a simulation
    - gaps, longest_gap: number of gaps, and length [s] of the longest gap
    - first, last: times of the first and the last sample [s]
    - coldest, hottest: range of the temperature [degC]; coldest > hottest if the log contains no
      temperature
    """

    made: LogAssembly
    bench: Bench
    topic: str
    period: float
    truth: bool
    warnings: tuple[str, ...]
    _blocks: Iterator[SampleBlock]
    _fields: tuple[str, ...]
    _effort: tuple[str, float]
    _beginning: OpeningSamples
    samples: int = 0
    gaps: int = 0
    longest_gap: float = 0.0
    first: float = 0.0
    last: float = 0.0
    coldest: float = math.inf
    hottest: float = -math.inf

    @property
    def source(self) -> str:
        """Return the file name of the log for messages."""
        return self.made.flows[0].source

    @property
    def duration(self) -> float:
        """Return the time from the first sample to one period after the last [s]."""
        return self.last - self.first + self.period if self.samples else 0.0

    @property
    def losses(self) -> list[DataLoss]:
        """Return the parts of the log that could not be read."""
        return self.made.losses

    def remarks(self) -> tuple[str, ...]:
        """Return the warnings about the log, one line each; call this after `pieces` has ended."""
        odd = [
            text
            for text in (*self.warnings, *self.made.warnings)
            if " in time, the longest " not in text
        ]
        if self.made.earlier_losses:
            odd.append(
                "data was lost when this log was made: "
                f"{loss_count_text(self.made.earlier_losses)}; `frictool info` lists them"
            )
        sign = sign_of(self._beginning.stream).text(self.bench) if self.samples else None
        odd += [] if sign is None else [sign]
        if self.gaps:
            odd.append(
                f"{self.gaps} gap{'s' * (self.gaps != 1)} in time, "
                f"the longest {self.longest_gap:.6g} s"
            )
        return tuple(dict.fromkeys(odd))

    def pieces(self) -> Iterator[MotionBlock]:
        """Yield the blocks of the log; the log can be read only once.

        Raises LogError if the log is damaged or has too many gaps.
        """
        before: int | None = None
        for samples in _grouped(self._blocks):
            signals = dict(zip(self._fields, samples.values, strict=True))
            name, constant = self._effort
            self._check(samples)
            self._beginning.take(samples)
            effort = signals[name] if constant == 1.0 else constant * signals[name]
            position = signals["position"]
            velocity, temperature = signals.get("velocity"), signals.get("temperature")
            self._heat(temperature)
            for low, high, follows in self._parts(samples, before):
                known, warm = (
                    None if values is None else values[low:high]
                    for values in (velocity, temperature)
                )
                yield MotionBlock(
                    samples.time[low:high] / NS,
                    position[low:high],
                    effort[low:high],
                    follows,
                    known,
                    warm,
                )
            before = int(samples.time[-1])

    def _heat(self, temperature: Vector | None) -> None:
        if temperature is not None:
            self.coldest = min(self.coldest, float(temperature.min()))
            self.hottest = max(self.hottest, float(temperature.max()))

    def _parts(self, samples: SampleBlock, before: int | None) -> Iterator[tuple[int, int, bool]]:
        """Yield (start, end, follows) of each gap-free part of a block of samples.

        `before`: time stamp [ns] of the last sample of the previous block; None without such a
        block. `follows` is True if the part continues the previous block without a gap.
        """
        steps = np.diff(samples.time, prepend=samples.time[0] if before is None else before) / NS
        broken = np.abs(steps - self.period) > JITTER * self.period
        broken[0] = before is not None and broken[0]
        self._count(samples, steps[broken])
        starts = [0, *(edge for edge in np.flatnonzero(broken).tolist() if edge)]
        ends = [*starts[1:], samples.time.size]
        for low, high in zip(starts, ends, strict=True):
            yield low, high, low == 0 and before is not None and not broken[0]

    def _check(self, samples: SampleBlock) -> None:
        """Raise LogError for a sample above LARGEST, since sums of squares could overflow."""
        for name, values in zip(self._fields, samples.values, strict=True):
            most = int(np.argmax(np.abs(values)))
            if not abs(values[most]) <= LARGEST:
                largest = f"{name} is {values[most]:g} at {samples.time[most] / NS:.9g} s"
                raise LogError(
                    self.source,
                    f"stream {self.topic}: {largest}; allowed: at most {LARGEST:g}; check the unit",
                )

    def _count(self, samples: SampleBlock, jumps: Vector) -> None:
        self.first = self.first if self.samples else float(samples.time[0]) / NS
        self.samples = self.samples + samples.time.size
        self.last = float(samples.time[-1]) / NS
        self.gaps += jumps.size
        self.longest_gap = max(self.longest_gap, float(jumps.max(initial=0.0)))
        if self.gaps > MOST_BROKEN * self.samples and self.samples > FEWEST:
            _refuse_clock(self.source, self.gaps / self.samples, self.period)


def open_stream(
    path: Path,
    bench: Bench,
    window: TimeWindow = EVERYTHING,
    topic: str | None = None,
    salvage: bool = False,
) -> SampleStream:
    """Open one stream of a log within a time window.

    `topic` names the stream; the default is /axis or the only stream of the log. Raises LogError if

    - the file cannot be read, or does not contain the columns of the bench,
    - the stream is missing, or has no position or no drive,
    - the kind of axis differs from the bench's, or the sample period differs from the bench's by
      more than 20 %,
    - the stream has no uniform clock.
    """
    made = assemble([path], bench, salvage)
    chosen = _topic(made, topic)
    # with a known origin, the times of this stream do not depend on other streams
    if made.origin is not None:
        made.flows = [flow for flow in made.flows if flow.head.topic == chosen]
    ready = next((one for one in start_streams(made, window) if one.head.topic == chosen), None)
    if ready is None:
        raise LogError(made.flows[0].source, f"stream {chosen} has no samples {window}".rstrip())
    return _started(made, ready, bench)


def _topic(made: LogAssembly, wanted: str | None) -> str:
    topics = [flow.head.topic for flow in made.flows]
    source = made.flows[0].source
    if wanted is not None:
        return pick(topics, wanted, source, "stream")
    if MAIN_TOPIC in topics or len(topics) == 1:
        return MAIN_TOPIC if MAIN_TOPIC in topics else topics[0]
    raise LogError(
        source, f"has no stream {MAIN_TOPIC}; name one with --stream: {', '.join(topics)}"
    )


def _started(made: LogAssembly, ready: PendingStream, bench: Bench) -> SampleStream:
    source = made.flows[0].source
    drive = bench.actuator.drive
    fields = ready.head.fields
    _require(source, ready, made, bench)
    opening = _opening(ready, drive)
    beginning = _stream(ready, opening)
    base = time_base(beginning.time)
    _check_clock(source, beginning.time)
    metadata = {**made.notes, **_columns(made, ready)}
    agreed = match_bench(Log((beginning,), metadata, source), bench, same_period=True)
    remade = drive in fields and agreed.main.signals.get("effort") is not beginning.signals.get(
        "effort"
    )
    effort = (
        ("effort", 1.0)
        if "effort" in fields and not remade
        else (drive, bench.actuator.constant.value)
    )
    measured_period = 1.0 / base.rate_hz
    apart = abs(measured_period / bench.sample_period_s - 1.0) > RATE_NOTED
    kept = tuple(
        dict.fromkeys(
            name for name in ("position", effort[0], "velocity", "temperature") if name in fields
        )
    )
    indices = [fields.index(name) for name in kept]
    blocks = (
        SampleBlock(one.time, tuple(one.values[index] for index in indices))
        for one in chain(opening, ready.samples)
    )
    truth = made.notes.get("log", {}).get("kind") == "simulated"
    period = measured_period if apart else bench.sample_period_s
    first_samples = OpeningSamples(
        StreamHeader(ready.head.topic, kept, tuple(ready.head.units[index] for index in indices))
    )
    return SampleStream(
        made,
        bench,
        ready.head.topic,
        period,
        truth,
        agreed.warnings,
        blocks,
        kept,
        effort,
        first_samples,
    )


def _require(source: str, ready: PendingStream, made: LogAssembly, bench: Bench) -> None:
    """Raise LogError if a stream lacks the position, or both the drive and the effort."""
    fields, drives = ready.head.fields, (bench.actuator.drive, "effort")
    missing = [] if "position" in fields else ["position"]
    missing += (
        []
        if any(name in fields for name in drives)
        else [f"{drives[0]} (the bench's drive) or effort"]
    )
    if not missing:
        return
    has = f"stream {ready.head.topic} has no {' and no '.join(missing)}; it has {', '.join(fields)}"
    others = [flow.head.topic for flow in made.flows if flow.head.topic != ready.head.topic]
    hint = (
        f"; if another stream ({', '.join(others[:3])}) has it, join the streams with "
        "`frictool ingest --resample S`"
        if others
        else ""
    )
    raise LogError(source, has + hint)


def _opening(ready: PendingStream, drive: str) -> list[SampleBlock]:
    """Return the first blocks of a stream, enough samples to check clock and drive.

    Blocks are read until they contain FEWEST samples and a nonzero drive, at most until they
    contain OPENING_SAMPLES samples.
    """
    index = ready.head.fields.index(drive) if drive in ready.head.fields else None
    opening: list[SampleBlock] = []
    seen = 0
    for block in ready.samples:
        opening.append(block)
        seen += block.time.size
        if (
            (index is None or block.values[index].any()) and seen >= FEWEST
        ) or seen >= OPENING_SAMPLES:
            break
    return opening


def _stream(ready: PendingStream, opening: list[SampleBlock]) -> Stream:
    whole = join_blocks(opening)
    signals = dict(zip(ready.head.fields, whole.values, strict=True))
    units = dict(zip(ready.head.fields, ready.head.units, strict=True))
    return Stream(MAIN_TOPIC, whole.time / NS, signals, units)


def _columns(made: LogAssembly, ready: PendingStream) -> dict[str, dict[str, str]]:
    flow = next(one for one in made.flows if one.head.topic == ready.head.topic)
    return (
        {"columns": {f"{MAIN_TOPIC}.{name}": text for name, text in flow.columns.items()}}
        if flow.columns
        else {}
    )


def _check_clock(source: str, time: Vector) -> None:
    """Raise LogError if the first times (n,) are too few or not uniform."""
    if time.size < FEWEST:
        raise LogError(
            source,
            f"has {time.size} sample{'s' * (time.size != 1)} to observe; "
            f"at least {FEWEST} are needed",
        )
    steps = np.diff(time)
    period = float(np.median(steps))
    broken = float(np.mean(np.abs(steps - period) > JITTER * period))
    if broken > MOST_BROKEN:
        _refuse_clock(source, broken, period)


def _refuse_clock(source: str, broken: float, period: float) -> None:
    reason = (
        f"{100 * broken:.0f} % of the intervals differ by more than {JITTER:.0%} from the median "
        f"period {period:.6g} s"
    )
    raise LogError(
        source,
        f"{reason}; resample the log first: "
        f"`frictool ingest {Path(source).name} --resample {period:.6g}`",
    )


def _grouped(blocks: Iterator[SampleBlock]) -> Iterator[SampleBlock]:
    """Join blocks to at least PIECE_SAMPLES samples each; the last block may be shorter."""
    waiting: list[SampleBlock] = []
    for block in blocks:
        waiting.append(block)
        if sum(one.time.size for one in waiting) >= PIECE_SAMPLES:
            yield join_blocks(waiting)
            waiting = []
    if waiting:
        yield join_blocks(waiting)
