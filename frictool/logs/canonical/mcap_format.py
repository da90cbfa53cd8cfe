"""Reading and writing of a whole canonical log in memory; mcap_layout.py describes its layout."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import numpy as np

from frictool.errors import LogError
from frictool.logs.canonical.canonical_reader import CanonicalReader
from frictool.logs.canonical.growing_vector import GrowingVector
from frictool.logs.canonical.mcap_layout import LATEST, NS, UNITS, StreamHeader
from frictool.logs.canonical.mcap_metadata import heads, notes, shift_ns
from frictool.logs.canonical.mcap_reader import checked_pieces
from frictool.logs.canonical.mcap_writer import CanonicalWriter, write_streams
from frictool.logs.canonical.sample_chunks import chunked
from frictool.logs.log import Log, Stream
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import Nanoseconds
from frictool.logs.stream_source import SampleBlock


def read_mcap(path: Path) -> Log:
    """Return the canonical log at `path`, with time in s and signals in SI.

    The streams have the order of their channel numbers. The memory needed depends on the actual
    content of the file, not on the sizes that the file declares.

    Raises LogError if the file is missing, not MCAP, truncated or damaged (every CRC is checked).
    The message gives the byte and the time up to which the file could be read. If the MCAP file is
    not a canonical log, the LogError names the channel.
    """
    with open_log(path) as stream:
        walk = CanonicalReader(path, stream)
        vectors: dict[int, list[GrowingVector]] = {}  # channel -> time, fields
        for piece in checked_pieces(walk):
            parts = (piece.samples.time, *piece.samples.values)
            grown = vectors.setdefault(
                piece.channel,
                [GrowingVector(part.dtype, walk.size // part.itemsize) for part in parts],
            )
            for vector, part in zip(grown, parts, strict=True):
                vector.append(part, walk.done / walk.size)
    shift = shift_ns(path, walk.metadata)
    streams = []
    for number, head in zip(
        walk.channels, heads(path, walk.metadata, walk.channels.values()), strict=True
    ):
        time, *values = (vector.whole() for vector in vectors[number])
        signals = dict(zip(head.fields, values, strict=True))
        streams.append(
            Stream(
                head.topic,
                (time - shift) / NS,
                signals,
                dict(zip(head.fields, head.units, strict=True)),
            )
        )
    return Log(tuple(streams), notes(walk.metadata), str(path))


def write_mcap(log: Log, stream: BinaryIO) -> None:
    """Write a log as canonical MCAP to a binary stream.

    Times are rounded to ns. MCAP allows no negative times. If a log starts before time 0, its times
    are shifted, and `read_mcap` removes the shift.

    Raises LogError if a stream is empty, a value is not finite, a time exceeds LATEST, or times do
    not increase by at least 1 ns. Raises ValueError if the name of a topic or signal is not allowed
    in ROS 2.
    """
    written = tuple(_head(one) for one in log.streams)
    times = [_nanoseconds(log.source, one) for one in log.streams]
    shift = max([0, *(-int(time[0]) for time in times)])
    metadata = {name: entries for name, entries in log.metadata.items() if name != UNITS}
    streams = [
        SampleBlock(time, tuple(one.signals[name] for name in head.fields))
        for one, head, time in zip(log.streams, written, times, strict=True)
    ]
    write_streams(
        CanonicalWriter(stream, written, metadata, shift), [chunked(iter([one])) for one in streams]
    )


def _head(stream: Stream) -> StreamHeader:
    return StreamHeader(
        stream.topic, tuple(stream.signals), tuple(stream.units[name] for name in stream.signals)
    )


def _nanoseconds(source: str, stream: Stream) -> Nanoseconds:
    if not stream.time.size or not stream.signals:
        raise LogError(
            source,
            f"stream {stream.topic} has no {'signals' if stream.time.size else 'samples'}; "
            "nothing to write",
        )
    for name, values in {"time": stream.time, **stream.signals}.items():
        if not np.isfinite(values).all():
            sample = int(np.flatnonzero(~np.isfinite(values))[0])
            raise LogError(
                source,
                f"stream {stream.topic}, {name}: sample {sample + 1} is {values[sample]}; "
                "allowed: finite numbers",
            )
    farthest = stream.time[np.argmax(np.abs(stream.time))]
    if abs(farthest) > LATEST:
        raise LogError(
            source,
            f"stream {stream.topic}: time {farthest:g} s is beyond {LATEST:g} s; check its unit",
        )
    time = np.rint(stream.time * NS).astype(np.int64)
    if time.size > 1 and np.diff(time).min() <= 0:
        sample = int(np.flatnonzero(np.diff(time) <= 0)[0]) + 1
        raise LogError(
            source,
            f"stream {stream.topic}: time does not increase by 1 ns or more at sample {sample + 1}",
        )
    return time
