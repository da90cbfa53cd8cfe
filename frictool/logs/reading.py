"""Any log to a `Log`: the canonical MCAP as it is, raw bench files through the bench's mapping. The content tells the format."""

from __future__ import annotations

import re
from pathlib import Path

from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.csv_format import read_csv
from frictool.logs.log import MAIN_TOPIC, Log, Stream
from frictool.logs.mapping import COLUMNS, map_channels, wanted_columns
from frictool.logs.mat_format import read_mat
from frictool.logs.mcap_format import read_mcap
from frictool.logs.source import format_of


def read_log(path: Path, bench: Bench | None = None) -> Log:
    """The log at `path`. A raw file (CSV, MATLAB) needs the bench, which a canonical log ignores.

    Raises LogError where the file cannot be read or mapped.
    """
    kind = format_of(path)
    if kind == "mcap":
        return read_mcap(path)
    if kind == "hdf5":
        raise LogError(path, "is MATLAB 7.3 (HDF5); save it with -v7")
    if bench is None:
        raise LogError(path, "is a raw bench file; its columns mean nothing without --bench bench.yaml (or `frictool ingest` it first)")
    read = read_csv if kind == "text" else read_mat
    return map_channels(read(path, wanted_columns(bench)), bench)


def read_logs(paths: list[Path], bench: Bench | None = None) -> Log:
    """Files of one rig as one log: the first as it is, the main stream of each further one as `/axis/STEM`, each on its own time base.

    Raises LogError as `read_log` does.
    """
    first, *others = paths
    log = read_log(first, bench)
    streams, columns, warnings = list(log.streams), dict(log.metadata.get(COLUMNS, {})), list(log.warnings)
    for path in others:
        other = read_log(path, bench)
        topic = _free_topic(path, {stream.topic for stream in streams})
        main = other.main
        streams.append(Stream(topic, main.time, main.signals, main.units))
        mapped = other.metadata.get(COLUMNS, {}).items()
        columns |= {topic + key.removeprefix(main.topic): text for key, text in mapped if key.rpartition(".")[0] == main.topic}
        warnings += [f"{path.name}: {text}" for text in other.warnings]
    metadata = {**log.metadata, **({COLUMNS: columns} if columns else {})}
    return Log(tuple(streams), metadata, log.source, tuple(warnings))


def _free_topic(path: Path, taken: set[str]) -> str:
    """`/axis/STEM`, in letters that ROS 2 allows, with a number where two files have one name."""
    stem = re.sub(r"[^A-Za-z0-9_]+", "_", path.stem)
    topic = f"{MAIN_TOPIC}/{stem if not stem[:1].isdigit() else '_' + stem}"
    number = 2
    while topic in taken:
        topic, number = f"{topic.removesuffix(f'_{number - 1}')}_{number}", number + 1
    return topic
