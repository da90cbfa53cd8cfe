"""What the records of an MCAP file declare: schemas, channels, metadata, and how many messages
there should be."""

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

UNREADABLE = (McapError, struct.error, ValueError)  # what a damaged record raises


@dataclass
class McapDeclarations:
    """Gathered record by record. counts: of messages by the statistics, channel -> how many; None
    where there are none."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    counts: dict[int, int] | None = None

    def take(self, opcode: int, body: bytes) -> Channel | None:
        """Takes in a record; kinds that declare nothing are skipped. Returns the channel if it is
        one. Raises UNREADABLE."""
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
    """The schemas and channels among the records of a chunk, each with its kind: it holds no other
    declaration, and above all no chunk."""
    for place in np.flatnonzero(
        (bounds.opcode == Opcode.SCHEMA) | (bounds.opcode == Opcode.CHANNEL)
    ).tolist():
        start = int(bounds.start[place])
        yield int(bounds.opcode[place]), data[start : start + int(bounds.length[place])]
