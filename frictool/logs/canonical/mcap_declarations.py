"""Schemas, channels, metadata and message counts that the records of an MCAP file declare."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema, Statistics

from frictool.logs.canonical.mcap_bounds import RecordBounds

UNREADABLE = (McapError, struct.error, ValueError)  # errors that a damaged record raises


@dataclass
class McapDeclarations:
    """Collector of the declarations in the records of an MCAP file.

    schemas: schemas by their number in the file.
    channels: channels by their number in the file.
    metadata: metadata records by name; each record maps keys to texts.
    counts: number of messages of each channel according to the file's statistics, by channel
        number; None until the statistics are read.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    counts: dict[int, int] | None = None

    def take(self, opcode: int, body: bytes) -> Channel | None:
        """Store what a record declares; return the declared channel, or None for other records.

        Records that declare nothing are ignored. A damaged record raises one of the errors
        UNREADABLE.
        """
        stream = ReadDataStream(io.BytesIO(body))
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            self.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel: Channel = Channel.read(stream)
            self.channels[channel.id] = channel
            return channel
        elif opcode == Opcode.METADATA:
            metadata = Metadata.read(stream)
            self.metadata[metadata.name] = metadata.metadata
        elif opcode == Opcode.STATISTICS:
            self.counts = dict(Statistics.read(stream).channel_message_counts)
        return None


def declared(data: bytes, bounds: RecordBounds) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and body of each schema and channel record in the data of a chunk."""
    for index in np.flatnonzero(
        (bounds.opcode == Opcode.SCHEMA) | (bounds.opcode == Opcode.CHANNEL)
    ).tolist():
        start = int(bounds.start[index])
        yield int(bounds.opcode[index]), data[start : start + int(bounds.length[index])]
