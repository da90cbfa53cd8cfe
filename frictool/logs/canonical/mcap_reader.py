"""Reads the canonical log (mcap_layout.py): whole into memory, or stream by stream without holding it."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from frictool.errors import LogError
from frictool.logs.canonical.mcap_chunk import chunk_data
from frictool.logs.canonical.mcap_layout import COLUMNS, MAGIC, NS, TIME, Head, message_path
from frictool.logs.canonical.mcap_records import FileRecords, Record, whole_records
from frictool.logs.canonical.mcap_streams import Lost, Piece, axis_fields
from frictool.logs.canonical.mcap_walk import Walk
from frictool.logs.flow import Samples
from frictool.logs.log import Log, Stream
from frictool.logs.losses import Losses
from frictool.logs.source import head_of, open_log
from frictool.logs.table import Loss


def read_mcap(path: Path) -> Log:
    """The canonical log at `path`: streams in the order of their channels, time in s, signals in SI as written.

    Raises LogError, naming the byte and the time reached, where the file is missing, no MCAP, cut off, or damaged (every CRC is checked);
    and where it is an MCAP that is not canonical, naming the channel. Memory is bounded by what the file really holds.
    """
    with open_log(path) as stream:
        walk = Walk(path, stream)
        pieces: dict[int, list[Samples]] = {}
        for piece in _guarded(walk):
            pieces.setdefault(piece.channel, []).append(piece.samples)
    shift, streams = walk.shift(), []
    for number, head in zip(walk.channels, walk.heads(), strict=True):
        parts = pieces[number]
        time = (np.concatenate([part.time for part in parts]) - shift) / NS
        signals = {name: np.concatenate([part.values[place] for part in parts]) for place, name in enumerate(head.fields)}
        streams.append(Stream(head.topic, time, signals, dict(zip(head.fields, head.units, strict=True))))
    return Log(tuple(streams), walk.notes(), str(path))


def open_mcap(path: Path, salvage: bool = False) -> tuple[list[CanonicalStream], dict[str, dict[str, str]], list[Loss]]:
    """The streams of a canonical log, its metadata records, and what cannot be read of it: the file has been read once, and checked.

    Raises LogError as `read_mcap` does; with `salvage` only where nothing can be read.
    """
    lost: list[Lost] | None = [] if salvage else None
    chunks: dict[int, set[int]] = {}
    with open_log(path) as stream:
        walk = Walk(path, stream, lost)
        for piece in _guarded(walk):
            chunks.setdefault(piece.channel, set()).add(piece.at)
    if salvage:
        walk.channels = {number: one for number, one in walk.channels.items() if one.samples}
    shift, notes, epoch = walk.shift(), walk.notes(), walk.epoch()
    streams = []
    for number, head in zip(walk.channels, walk.heads(), strict=True):
        stored = {name: notes.get(COLUMNS, {}).get(message_path(head.topic, name)) for name in ("time", *head.fields)}
        columns = {name: text for name, text in stored.items() if text is not None}
        clock = None if epoch is None else notes[TIME].get(head.topic, "unknown")
        streams.append(CanonicalStream(str(path), head, columns, number, frozenset(chunks[number]), shift, walk.size, epoch, clock))
    return streams, notes, [_loss(one, walk, shift) for one in lost or ()]


@dataclass
class CanonicalStream:
    """One stream of a canonical log that has been checked (a Flow). chunks: where those begin that hold its samples.

    epoch: what its clock showed at 0 of the log, in ns, where a clock dates it.
    """

    source: str
    head: Head
    columns: Mapping[str, str]
    number: int
    chunks: frozenset[int]
    shift: int
    size: int
    epoch: int | None = None
    clock: str | None = None
    done: int = 0
    losses: Losses = field(default_factory=Losses)
    warnings: tuple[str, ...] = ()

    def samples(self, salvage: bool = False) -> Iterator[Samples]:
        """See Flow. What is damaged has been told by `open_mcap`."""
        path = Path(self.source)
        with open_log(path) as stream:
            walk = Walk(path, stream, [] if salvage else None, self.chunks)
            for piece in _guarded(walk):
                self.done = walk.records.offset
                if piece.channel == self.number:
                    yield Samples(piece.samples.time + ((self.epoch or 0) - self.shift), piece.samples.values)


def is_canonical(path: Path) -> bool:
    """Whether an MCAP file is a log of frictool's own: its first channel tells; one without any is taken for one.

    False for what is no MCAP. Raises LogError where the file cannot be read.
    """
    if not head_of(path).startswith(MAGIC[:5]):
        return False
    with open_log(path) as stream:
        try:
            schemas: dict[int, Schema] = {}
            for opcode, body in _declarations(stream, path.stat().st_size):
                if opcode == Opcode.SCHEMA:
                    schema = Schema.read(ReadDataStream(BytesIO(body)))
                    schemas[schema.id] = schema
                else:
                    channel = Channel.read(ReadDataStream(BytesIO(body)))
                    return axis_fields(channel, schemas.get(channel.schema_id)) is not None
        except (McapError, struct.error, ValueError):
            return True
        except OSError as error:
            raise LogError(path, f"cannot be read: {error.strerror or error}") from None
    return True


def _declarations(stream: BinaryIO, size: int) -> Iterator[tuple[int, bytes]]:
    """The schemas and channels of a file, in its order."""
    wanted = (Opcode.SCHEMA, Opcode.CHANNEL)
    for item in FileRecords(stream, size):
        if not isinstance(item, Record):
            continue
        if item.opcode in wanted:
            yield item.opcode, item.body
        elif item.opcode == Opcode.CHUNK:
            data = chunk_data(item.body)
            bounds, _ = whole_records(data)
            for opcode, start, length in zip(bounds.opcode.tolist(), bounds.start.tolist(), bounds.length.tolist(), strict=True):
                if opcode in wanted:
                    yield opcode, data[start : start + length]


def _guarded(walk: Walk) -> Iterator[Piece]:
    """The pieces of a walk. Raises LogError where the system refuses to read on."""
    try:
        yield from walk.pieces()
    except OSError as error:
        walk.fail(f"cannot be read: {error.strerror or error}")


def _loss(one: Lost, walk: Walk, shift: int) -> Loss:
    """What is lost, in the log's time and by its channels."""
    of = walk.channels.values() if one.channel not in walk.channels else [walk.channels[one.channel]]
    paths = tuple(message_path(declared.topic, name) for declared in of for name in declared.fields)
    first, last = (None if at is None else (at - shift) / NS for at in (one.first, one.last))
    return Loss(paths, one.reason, first, last, one.samples)
