"""Assembly of the files of one rig into one log, without holding all samples in memory.

files ──▶ streams ──▶ common time ──▶ window ──▶ optional resampling
      ──▶ chunks in order of time ──▶ CanonicalWriter
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import BinaryIO, NamedTuple

from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.provenance import readable
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import (
    COLUMNS,
    EPOCH_KEY,
    KIND,
    NS,
    TIME,
    StreamHeader,
    message_path,
)
from frictool.logs.canonical.mcap_reader import is_canonical, open_mcap
from frictool.logs.canonical.mcap_writer import CanonicalWriter, Notes, write_streams
from frictool.logs.canonical.sample_chunks import chunked, join_blocks
from frictool.logs.channels.column_binding import bind, topic_for
from frictool.logs.channels.instruments import view_of
from frictool.logs.channels.mapping import EFFORT
from frictool.logs.channels.table_preparation import FindingTexts, prepare_tables
from frictool.logs.clocks.alignment import CLOCK_OFFSET, aligned
from frictool.logs.clocks.resampling import RESAMPLED, grid, resampled
from frictool.logs.clocks.sample_intervals import SampleIntervals
from frictool.logs.formats import open_tables, refuse_document
from frictool.logs.log import Log, Stream
from frictool.logs.losses import LOST, LossList, losses_of, record_of
from frictool.logs.open_file import head_of
from frictool.logs.quality.time_base import TimeBase
from frictool.logs.raw_table import (
    LAYOUT,
    DataLoss,
    DetectedLayout,
    LostColumnError,
    RawTable,
)
from frictool.logs.recordings.recording_files import sources
from frictool.logs.stream_source import SampleBlock, StreamSource


class TimeWindow(NamedTuple):
    """Time window in the log's time [ns], including both ends; None at an end means no limit."""

    start: int | None = None
    end: int | None = None

    @classmethod
    def between(cls, start: float | None = None, end: float | None = None) -> TimeWindow:
        """Return the window from `start` to `end` [s]; None means no limit."""
        return cls(*(None if at is None else round(at * NS) for at in (start, end)))

    def cut(self, pieces: Iterator[SampleBlock]) -> Iterator[SampleBlock]:
        """Yield the samples within the window; stop reading after its end."""
        for piece in pieces:
            low = 0 if self.start is None else int(piece.time.searchsorted(self.start))
            high = (
                piece.time.size
                if self.end is None
                else int(piece.time.searchsorted(self.end, side="right"))
            )
            if low < high:
                yield piece.part(low, high)
            if high < piece.time.size:
                return

    def __str__(self) -> str:
        return " ".join(
            f"{word} {at / NS:.9g} s"
            for word, at in (("from", self.start), ("to", self.end))
            if at is not None
        )


EVERYTHING = TimeWindow()


@dataclass
class LogAssembly:
    """Streams, metadata and losses of a log that is to be written.

    flows: streams in the order of the files.
    notes: metadata records.
    lost: losses that were noticed when the files were opened.
    earlier_losses: losses that the metadata of an already canonical input file reports.
    origin: clock time in ns at time 0 of the log; None until `start_streams` has set it.
    ahead: for each topic, time in ns by which the stream's clock leads the log's clock.
    findings: for each raw table, a function that returns its warnings.
    salvage: True if unreadable data is left out; False if it raises LogError.
    """

    flows: list[StreamSource] = field(default_factory=list)
    notes: Notes = field(default_factory=dict)
    lost: list[DataLoss] = field(default_factory=list)
    earlier_losses: list[DataLoss] = field(default_factory=list)
    origin: int | None = None
    ahead: dict[str, int] = field(default_factory=dict)
    findings: list[FindingTexts] = field(default_factory=list)
    salvage: bool = False

    @property
    def progress(self) -> float:
        """Return the processed fraction of all bytes of the files, 0 to 1."""
        return sum(flow.done for flow in self.flows) / max(1, sum(flow.size for flow in self.flows))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return the warnings about the samples; complete after all samples have been read."""
        several = len({flow.source for flow in self.flows}) > 1
        odd = tuple(
            (f"{Path(flow.source).name}: " if several else "") + text
            for flow in self.flows
            for text in flow.warnings
        )
        return (*odd, *(text for one in self.findings for text in one()))

    def start(self, flow: StreamSource) -> int:
        """Return the time [ns] that the clock of a stream shows at time 0 of the log."""
        return (self.origin or 0 if flow.clock is not None else 0) + self.ahead.get(
            flow.head.topic, 0
        )

    @property
    def losses(self) -> list[DataLoss]:
        """Return all losses except `earlier_losses`; complete after all samples have been read.

        The times of the losses are times of the log.
        """
        collected = LossList()
        for loss in self.lost:
            collected.append(loss)
        for flow in self.flows:
            origin = self.start(flow) / NS
            for loss in flow.losses:
                start, end = (
                    None if at is None else round(at - origin, 9)
                    for at in (loss.start_s, loss.end_s)
                )
                collected.append(replace(loss, start_s=start, end_s=end))
        return collected


def assemble(paths: Sequence[Path], bench: Bench | None, salvage: bool = False) -> LogAssembly:
    """Open the files of one log and return their streams.

    The streams of the first file keep their topics. The first stream of each other file becomes
    `/axis/STEM`; the remaining streams of this file become `/axis/STEM_NAME`. STEM is the file's
    name without suffix, or the name of the file's instrument in bench.yaml; NAME is the stream's
    name within the file.

    salvage: if True, unreadable data is left out; if False, it raises LogError.

    Raises LogError if a file cannot be read or does not fit bench.yaml, or if a raw file is read
    without a bench.
    """
    made = LogAssembly(salvage=salvage)
    for parts in sources(paths):
        path = parts[0]
        stem = path.stem if made.flows else ""
        if len(parts) == 1 and is_canonical(path):
            _add_canonical(made, path, stem)
            continue
        if bench is None:
            refuse_document(path, head_of(path))
            missing = (
                "is a raw log file; give --bench bench.yaml, which describes its columns, or "
                "convert it with `frictool ingest`"
            )
            raise LogError(path, missing)
        view = view_of(path, bench)
        layout = view.bench.layout
        tables = open_tables(parts, layout)
        _describe(made, path, tables)
        add_tables(made, tables, view.bench, (view.name or stem) if stem else "", view.ahead_ns)
        if view.estimate is not None:
            reference, flow = made.flows[0], made.flows[-1]
            _set_ahead(
                made,
                [flow],
                *aligned(reference, flow, view.estimate, made.ahead.get(reference.head.topic, 0)),
            )
    return made


def add_tables(
    made: LogAssembly, tables: Sequence[RawTable], bench: Bench, stem: str = "", ahead_ns: int = 0
) -> None:
    """Add the streams of a raw file; raise LogError if a column does not fit bench.yaml.

    If only the column of the reference is missing, as in a test of drive ramps, the result is a
    warning, not an error.

    stem: "" for the first file of the log; for any other file, its name without suffix or the name
        of its instrument.
    ahead_ns: time in ns by which the file's clock leads the log's clock.
    """
    ready, findings = prepare_tables(tables, bench)
    if _lacks_reference(ready, bench):
        column = bench.columns["reference"].column
        name = Path(ready[0].source).name
        text = f"{name} has no column {column!r}, and is read without the reference"
        findings = [*findings, lambda: (text,)]
        others = {name: one for name, one in bench.columns.items() if name != "reference"}
        bench = structs.replace(bench, columns=others)
    flows = bind(
        ready,
        bench,
        stem,
        [flow.head.topic for flow in made.flows],
        made.lost if made.salvage else None,
    )
    made.flows += flows
    made.findings += findings
    if ahead_ns:
        _set_ahead(made, flows, ahead_ns, "given")
    made.notes.setdefault(KIND, {"kind": "measured", "bench": bench.name, "axis": bench.axis})


def _lacks_reference(tables: Sequence[RawTable], bench: Bench) -> bool:
    """Return True if a table has the position's column, but no table has the reference's column."""
    reference, position = (bench.columns.get(name) for name in ("reference", "position"))
    if reference is None or position is None:
        return False
    try:
        found = [table.find(reference.column) for table in tables]
        moving = [table.find(position.column) for table in tables]
    except LostColumnError:
        return False
    return not any(name is not None for name in found) and any(name is not None for name in moving)


def _describe(made: LogAssembly, path: Path, tables: Sequence[RawTable]) -> None:
    for table in tables:
        if isinstance(table, DetectedLayout):
            made.notes.setdefault(LAYOUT, {})[readable(path.name)] = table.description


def _set_ahead(made: LogAssembly, flows: Sequence[StreamSource], ahead_ns: int, how: str) -> None:
    for flow in flows:
        made.ahead[flow.head.topic] = ahead_ns
        made.notes.setdefault(CLOCK_OFFSET, {})[flow.head.topic] = f"{ahead_ns / NS:.9g} s, {how}"


def _add_canonical(made: LogAssembly, path: Path, stem: str) -> None:
    streams, notes, lost = open_mcap(path, made.salvage)
    taken = [flow.head.topic for flow in made.flows]
    renamed = {}
    for number, stream in enumerate(streams):
        topic = stream.head.topic
        if stem:
            topic = topic_for(
                stem, stream.head.topic.removeprefix("/axis") if number else "", taken
            )
        taken.append(topic)
        renamed[stream.head.topic] = topic
        made.flows.append(replace(stream, head=replace(stream.head, topic=topic)))
    if not stem:
        made.notes = {
            name: entries for name, entries in notes.items() if name not in (LOST, COLUMNS, TIME)
        }
        made.origin = streams[0].epoch
    made.lost += [_renamed(loss, renamed) for loss in lost]
    made.earlier_losses += [_renamed(loss, renamed) for loss in losses_of(notes, path)]


def _renamed(loss: DataLoss, topics: dict[str, str]) -> DataLoss:
    paths = [path.rpartition(".") for path in loss.channels]
    return replace(
        loss,
        channels=tuple(message_path(topics.get(topic, topic), name) for topic, _, name in paths),
    )


@dataclass
class PendingStream:
    """Stream that is ready to be written.

    samples: samples within the window, in log time.
    first: log time in ns of the first sample.
    intervals: statistics of the sample intervals, filled while the samples are written.
    """

    head: StreamHeader
    samples: Iterator[SampleBlock]
    first: int
    intervals: SampleIntervals = field(default_factory=SampleIntervals)

    def seen(self) -> Iterator[SampleBlock]:
        """Yield the samples; add the times of each block to `intervals`."""
        for piece in self.samples:
            self.intervals.add(piece.time)
            yield piece


def write(
    made: LogAssembly,
    stream: BinaryIO,
    notes: Notes,
    window: TimeWindow = EVERYTHING,
    period_ns: int | None = None,
    tick: Callable[[float], None] = lambda part: None,
) -> list[tuple[StreamHeader, TimeBase]]:
    """Write all streams within the window, and return their headers and time bases.

    notes: additional metadata records.
    period_ns: sample period in ns of the single stream to which all streams are resampled; None if
        they are not resampled.
    tick: callback that receives the completed fraction, 0 to 1.

    Raises LogError if a sample cannot be read, or if no sample is in the window.
    """
    ready = start_streams(made, window)
    records = {**made.notes, **origins(made, [one.head.topic for one in ready]), **notes}
    if period_ns is not None:
        ready, records[RESAMPLED] = _on_grid(made, ready, period_ns)
    shift = max(0, -min(one.first for one in ready))
    writer = CanonicalWriter(stream, tuple(one.head for one in ready), records, shift)

    def last() -> Notes:
        lost = [*made.earlier_losses, *made.losses]
        return {LOST: record_of(lost)} if lost else {}

    write_streams(writer, [_ticking(chunked(one.seen()), made, tick) for one in ready], last)
    return [(one.head, one.intervals.base()) for one in ready]


def _ticking(
    pieces: Iterator[SampleBlock], made: LogAssembly, tick: Callable[[float], None]
) -> Iterator[SampleBlock]:
    for piece in pieces:
        tick(made.progress)
        yield piece


def assemble_log(made: LogAssembly) -> Log:
    """Return the assembled log in memory; raise LogError if a sample cannot be read."""
    ready = start_streams(made)
    streams = []
    for one in ready:
        samples = join_blocks([*one.samples])
        signals = dict(zip(one.head.fields, samples.values, strict=True))
        units = dict(zip(one.head.fields, one.head.units, strict=True))
        streams.append(Stream(one.head.topic, samples.time / NS, signals, units))
    notes = {**made.notes, **origins(made, [one.head.topic for one in ready])}
    return Log(tuple(streams), notes, made.flows[0].source, made.warnings)


def start_streams(made: LogAssembly, window: TimeWindow = EVERYTHING) -> list[PendingStream]:
    """Set the origin of the log's time, and return the streams that have a sample in the window.

    Raises LogError if no stream has a sample in the window.
    """
    begun = []
    for flow in made.flows:
        pieces = flow.samples(made.salvage)
        first = next(pieces, None)
        if first is not None:
            begun.append((flow, chain([first], pieces), int(first.time[0])))
    if made.origin is None:
        clocked = (
            first - made.ahead.get(flow.head.topic, 0)
            for flow, _, first in begun
            if flow.clock is not None
        )
        made.origin = min(clocked, default=None)
    ready = []
    for flow, pieces, _ in begun:
        cut = window.cut(_since(pieces, made.start(flow)))
        first = next(cut, None)
        if first is not None:
            ready.append(PendingStream(flow.head, chain([first], cut), int(first.time[0])))
    if not ready:
        raise LogError(made.flows[0].source, f"has no samples {window}".rstrip())
    return ready


def _since(pieces: Iterator[SampleBlock], origin: int) -> Iterator[SampleBlock]:
    for piece in pieces:
        yield SampleBlock(piece.time - origin, piece.values) if origin else piece


def origins(made: LogAssembly, topics: list[str]) -> Notes:
    """Return the metadata records with the raw columns and clocks of the streams `topics`."""
    flows = [flow for flow in made.flows if flow.head.topic in topics]
    columns = {
        message_path(flow.head.topic, name): text
        for flow in flows
        for name, text in flow.columns.items()
    }
    clocks = {flow.head.topic: flow.clock for flow in flows if flow.clock is not None}
    records = {COLUMNS: columns, TIME: {EPOCH_KEY: str(made.origin), **clocks} if clocks else {}}
    return {name: entries for name, entries in records.items() if entries}


def _on_grid(
    made: LogAssembly, ready: list[PendingStream], period_ns: int
) -> tuple[list[PendingStream], dict[str, str]]:
    derived = [
        flow.head.topic
        for flow in made.flows
        if EFFORT in flow.head.fields and EFFORT not in flow.columns
    ]
    on = grid([one.head for one in ready], derived, period_ns)
    samples = resampled([one.samples for one in ready], on)
    first = next(samples, None)
    if first is None:
        raise LogError(
            made.flows[0].source,
            "its streams have no time in common, so that nothing can be resampled",
        )
    following = next(samples, None)
    if following is None and first.time.size < 2:
        raise LogError(
            made.flows[0].source,
            f"is shorter than the resampling period of {period_ns / NS:g} s; give a shorter period",
        )
    begin = [first] if following is None else [first, following]
    return [PendingStream(on.head, chain(begin, samples), int(first.time[0]))], on.note
