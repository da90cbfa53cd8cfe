"""Reads the canonical log (mcap_layout.py): every chunk is viewed as one NumPy array, and every CRC is checked.

What another tool made of a canonical log is read as well, as long as the messages are the same: other chunks, several streams in one
chunk, lz4 or no compression, no chunks, no summary. An MCAP with other messages is refused.
"""

from __future__ import annotations

import io
import os
import re
import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NoReturn

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema, Statistics
from numpy.typing import NDArray

from frictool.errors import LogError
from frictool.logs.log import Log, Stream, Vector
from frictool.logs.mcap_chunk import chunk_data
from frictool.logs.mcap_layout import (
    CDR_HEAD,
    MAGIC,
    MESSAGE_ENCODING,
    MESSAGE_OPCODE,
    NS,
    RECORD_HEAD,
    SCHEMA_ENCODING,
    SHIFT_KEY,
    TIME,
    TOPIC,
    UNITS,
    message_dtype,
    message_path,
    schema_fields,
)
from frictool.logs.source import open_log

RECORD_BYTES = 1 << 30  # no record of a canonical log comes near
_HEAD = struct.Struct("<BQ")
_SHIFT = re.compile(r"-?[0-9]{1,18}")


@dataclass
class _Channel:
    """One stream as far as it has been read: a block of times and a block of values (fields, n) for each chunk."""

    number: int
    topic: str
    fields: tuple[str, ...]
    times: list[NDArray[np.int64]] = field(default_factory=list)
    blocks: list[Vector] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.dtype = message_dtype(len(self.fields))

    def take(self, data: bytes) -> bool:
        """Appends message records of this channel; False where they are not of its layout."""
        if len(data) % self.dtype.itemsize:
            return False
        records = np.frombuffer(data, self.dtype)
        like = (records["opcode"] == MESSAGE_OPCODE) & (records["length"] == self.dtype.itemsize - RECORD_HEAD)
        if not (like & (records["channel"] == self.number) & (records["cdr"] == CDR_HEAD)).all():
            return False
        self.times.append(records["log_time"].astype(np.int64))
        self.blocks.append(np.ascontiguousarray(records["values"].T))
        return True

    def column(self, index: int) -> Vector:
        return np.concatenate([block[index] for block in self.blocks])


class _Reader:
    """The records of one file, in order."""

    def __init__(self, path: Path, stream: BinaryIO) -> None:
        self.path = path
        self.stream = stream
        self.size = os.fstat(stream.fileno()).st_size
        self.offset = 0
        self.crc = 0
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, _Channel] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.declared: int | None = None

    def fail(self, message: str) -> NoReturn:
        raise LogError(self.path, message)

    def damaged(self, what: str) -> NoReturn:
        last = max((int(channel.times[-1][-1]) for channel in self.channels.values() if channel.times), default=None)
        after = "before any sample" if last is None else f"after {last / NS:.6g} s of log"
        self.fail(f"is damaged or cut off at byte {self.offset} of {self.size}, {after}: {what}")

    def read(self, length: int) -> bytes:
        if length > self.size - self.offset:
            self.damaged(f"{length} bytes are announced, {self.size - self.offset} remain")
        data = self.stream.read(length)
        if len(data) != length:
            self.damaged(f"{length} bytes are announced, {len(data)} remain")
        self.offset += length
        return data

    def run(self) -> None:
        """Reads the whole file."""
        if self.read(min(len(MAGIC), self.size)) != MAGIC:
            self.fail("is no MCAP file of version 0 (its first bytes are others)")
        self.crc = zlib.crc32(MAGIC)
        opcode = Opcode.HEADER
        while opcode != Opcode.FOOTER:
            head = self.read(RECORD_HEAD)
            opcode, length = _HEAD.unpack(head)
            if length > RECORD_BYTES:
                self.damaged(f"a record of {length} bytes is announced")
            body = self.read(length)
            self.check(opcode, head, body)
            try:
                self.record(opcode, body)
            except (McapError, struct.error, ValueError) as error:
                self.damaged(f"record {opcode:#04x} cannot be decoded ({str(error) or type(error).__name__})")
        if self.read(min(len(MAGIC), self.size - self.offset)) != MAGIC or self.offset != self.size:
            self.damaged("the closing magic is not at the end of the file")

    def check(self, opcode: int, head: bytes, body: bytes) -> None:
        """Follows the CRC of the data section up to its end, then that of the summary up to the footer."""
        if opcode in (Opcode.DATA_END, Opcode.FOOTER):
            covered = b"" if opcode == Opcode.DATA_END else head + body[:-4]
            wanted = int.from_bytes(body[-4:] if opcode == Opcode.FOOTER else body[:4], "little")
            if wanted not in (0, zlib.crc32(covered, self.crc)):
                self.damaged(f"the CRC of the {'data' if opcode == Opcode.DATA_END else 'summary'} is wrong")
            self.crc = 0
            return
        self.crc = zlib.crc32(body, zlib.crc32(head, self.crc))

    def record(self, opcode: int, body: bytes) -> None:
        """Takes in one record; kinds that say nothing of the samples are skipped."""
        if opcode == Opcode.CHUNK:
            self.messages(chunk_data(body))
        elif opcode == Opcode.MESSAGE:
            self.messages(_HEAD.pack(opcode, len(body)) + body)
        elif opcode == Opcode.SCHEMA:
            schema = Schema.read(ReadDataStream(io.BytesIO(body)))
            self.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self.channel(Channel.read(ReadDataStream(io.BytesIO(body))))
        elif opcode == Opcode.METADATA:
            metadata = Metadata.read(ReadDataStream(io.BytesIO(body)))
            self.metadata[metadata.name] = metadata.metadata
        elif opcode == Opcode.STATISTICS:
            self.declared = Statistics.read(ReadDataStream(io.BytesIO(body))).message_count

    def channel(self, channel: Channel) -> None:
        """Declares a stream. Raises LogError where it is none of a canonical log."""
        schema = self.schemas.get(channel.schema_id)
        text = schema.data.decode() if schema is not None and schema.encoding == SCHEMA_ENCODING else ""
        fields = schema_fields(text)
        if channel.message_encoding != MESSAGE_ENCODING or fields is None or not TOPIC.fullmatch(channel.topic):
            kind = schema.name if schema is not None else "no schema"
            self.fail(
                f"is no canonical log: channel {channel.topic!r} carries {kind} in {channel.message_encoding or 'no encoding'}; "
                "allowed: /axis and /axis/NAME with flat float64 fields in cdr, as `frictool ingest` and `simulate` write them"
            )
        known = self.channels.setdefault(channel.id, _Channel(channel.id, channel.topic, fields))
        if (known.topic, known.fields) != (channel.topic, fields):
            self.damaged(f"channel {channel.id} is declared twice, as {known.topic} and as {channel.topic}")

    def messages(self, data: bytes) -> None:
        """Message records, as they stand in a chunk: usually of one channel and nothing else."""
        if len(data) > RECORD_HEAD + 2 and data[0] == MESSAGE_OPCODE:
            channel = self.channels.get(int.from_bytes(data[RECORD_HEAD : RECORD_HEAD + 2], "little"))
            if channel is not None and channel.take(data):
                return
        self.walk(data)

    def walk(self, data: bytes) -> None:
        """The same, record by record, for what another tool has put together."""
        found: dict[int, bytearray] = {}
        position = 0
        while position < len(data):
            opcode, length = _HEAD.unpack_from(data, position)
            end = position + RECORD_HEAD + length
            if end > len(data):
                raise ValueError(f"a record of {length} bytes in a chunk with {len(data) - position} left")
            if opcode == MESSAGE_OPCODE:
                number = int.from_bytes(data[position + RECORD_HEAD : position + RECORD_HEAD + 2], "little")
                found.setdefault(number, bytearray()).extend(data[position:end])
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):  # a chunk holds nothing else, and above all no chunk
                self.record(opcode, data[position + RECORD_HEAD : end])
            position = end
        for number, records in found.items():
            if number not in self.channels or not self.channels[number].take(bytes(records)):
                raise ValueError(f"messages of channel {number} are not as its schema says")

    def log(self) -> Log:
        """The log of what was read."""
        count = sum(time.size for channel in self.channels.values() for time in channel.times)
        if self.declared not in (None, count):
            self.damaged(f"{count} messages are there, the statistics count {self.declared}")
        if not self.channels:
            self.fail("is no canonical log: it has no channel")
        units = self.metadata.get(UNITS, {})
        shift = self.metadata.get(TIME, {}).get(SHIFT_KEY, "0")
        if not _SHIFT.fullmatch(shift):
            self.fail(f"metadata {TIME}.{SHIFT_KEY}: found {shift!r}; allowed: a whole number")
        streams = tuple(self.log_stream(channel, units, int(shift)) for channel in self.channels.values())
        return Log(streams, {name: entries for name, entries in self.metadata.items() if name not in (UNITS, TIME)}, str(self.path))

    def log_stream(self, channel: _Channel, units: dict[str, str], shift: int) -> Stream:
        if not channel.times:
            self.fail(f"stream {channel.topic} has no samples")
        stamps = np.concatenate(channel.times)
        if stamps.size > 1 and np.diff(stamps).min() <= 0:
            sample = int(np.flatnonzero(np.diff(stamps) <= 0)[0]) + 1
            self.fail(f"stream {channel.topic}: time does not increase at sample {sample + 1}, {stamps[sample] / NS:.9g} s")
        missing = [name for name in channel.fields if message_path(channel.topic, name) not in units]
        if missing:
            self.fail(f"is no canonical log: metadata {UNITS!r} has no {message_path(channel.topic, missing[0])!r}")
        signals = {name: channel.column(index) for index, name in enumerate(channel.fields)}
        for name, values in signals.items():
            if not np.isfinite(values).all():
                self.fail(f"stream {channel.topic}: {name} is not finite at sample {int(np.flatnonzero(~np.isfinite(values))[0]) + 1}")
        return Stream(channel.topic, (stamps - shift) / NS, signals, {name: units[message_path(channel.topic, name)] for name in signals})


def read_mcap(path: Path) -> Log:
    """The canonical log at `path`: streams in the order of their channels, time in s, signals in SI as written.

    Raises LogError, naming the byte and the time reached, where the file is missing, no MCAP, cut off, or damaged (every CRC is checked);
    and where it is an MCAP that is not canonical, naming the channel. Memory is bounded by what the file really holds.
    """
    with open_log(path) as stream:
        reader = _Reader(path, stream)
        try:
            reader.run()
        except OSError as error:
            reader.fail(f"cannot be read: {error.strerror or error}")
        return reader.log()
