"""Any log to a `Log` in memory: the canonical MCAP as it is, raw bench files through the bench's mapping. The content tells the format."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.binding import bind, free_topic
from frictool.logs.flow import Flow
from frictool.logs.formats import tables_of
from frictool.logs.log import Log, Stream
from frictool.logs.mcap_layout import COLUMNS, EPOCH_KEY, KIND, NS, TIME, message_path
from frictool.logs.mcap_reader import is_canonical, read_mcap


def read_log(path: Path, bench: Bench | None = None) -> Log:
    """The log at `path`. A raw file needs the bench, which a canonical log ignores.

    Raises LogError where the file cannot be read or mapped.
    """
    return read_mcap(path) if is_canonical(path) else joined(open_raw(path, bench), bench_metadata(bench))


def open_raw(path: Path, bench: Bench | None) -> list[Flow]:
    """The streams of a raw file. Raises LogError as `bind` does."""
    if bench is None:
        raise LogError(path, "is a raw bench file; its columns mean nothing without --bench bench.yaml (or `frictool ingest` it first)")
    return [*bind(tables_of(path), bench)]


def bench_metadata(bench: Bench | None) -> dict[str, dict[str, str]]:
    """What a log that was made with this bench says of it."""
    return {} if bench is None else {KIND: {"kind": "measured", "bench": bench.name, "axis": bench.axis}}


def flow_metadata(flows: list[Flow], origin_ns: int) -> dict[str, dict[str, str]]:
    """Where the samples come from and what dates them, as metadata records. origin_ns: of the clocks, at 0 of the log."""
    columns = {message_path(flow.head.topic, field): text for flow in flows for field, text in flow.columns.items()}
    clocks = {flow.head.topic: flow.clock for flow in flows if flow.clock is not None}
    records = {COLUMNS: columns, TIME: {EPOCH_KEY: str(origin_ns), **clocks} if clocks else {}}
    return {name: entries for name, entries in records.items() if entries}


def joined(flows: list[Flow], metadata: dict[str, dict[str, str]]) -> Log:
    """All samples of all flows, in memory. Raises LogError as the flows do."""
    pieces = [[*flow.samples()] for flow in flows]
    origin = min((int(parts[0].time[0]) for parts, flow in zip(pieces, flows, strict=True) if flow.clock is not None), default=0)
    streams = []
    for flow, parts in zip(flows, pieces, strict=True):
        time = np.concatenate([part.time for part in parts]) - (origin if flow.clock is not None else 0)
        signals = {name: np.concatenate([part.values[place] for part in parts]) for place, name in enumerate(flow.head.fields)}
        streams.append(Stream(flow.head.topic, time / NS, signals, dict(zip(flow.head.fields, flow.head.units, strict=True))))
    warnings = tuple(text for flow in flows for text in flow.warnings)
    return Log(tuple(streams), {**metadata, **flow_metadata(flows, origin)}, flows[0].source, warnings)


def read_logs(paths: list[Path], bench: Bench | None = None) -> Log:
    """Files of one rig as one log: the first as it is, the main stream of each further one as `/axis/STEM`, each on its own time base.

    Raises LogError as `read_log` does.
    """
    first, *others = paths
    log = read_log(first, bench)
    streams, columns, warnings = list(log.streams), dict(log.metadata.get(COLUMNS, {})), list(log.warnings)
    for path in others:
        other = read_log(path, bench)
        topic = free_topic(path.stem, {stream.topic for stream in streams})
        main = other.main
        streams.append(Stream(topic, main.time, main.signals, main.units))
        mapped = other.metadata.get(COLUMNS, {}).items()
        columns |= {topic + key.removeprefix(main.topic): text for key, text in mapped if key.rpartition(".")[0] == main.topic}
        warnings += [f"{path.name}: {text}" for text in other.warnings]
    metadata = {**log.metadata, **({COLUMNS: columns} if columns else {})}
    return Log(tuple(streams), metadata, log.source, tuple(warnings))
