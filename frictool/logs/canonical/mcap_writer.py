"""Writes the canonical log: the layout is in mcap_layout.py. The same log gives the same bytes."""

from __future__ import annotations

import struct
import zlib
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import BinaryIO, NamedTuple

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from frictool.errors import LogError
from frictool.logs.canonical.chunks import chunked, merged
from frictool.logs.canonical.mcap_layout import (
    CDR_HEAD,
    LATEST,
    MAGIC,
    MESSAGE_ENCODING,
    MESSAGE_OPCODE,
    NS,
    PROFILE,
    RECORD_HEAD,
    SCHEMA_ENCODING,
    SCHEMA_NAME,
    SHIFT_KEY,
    TIME,
    UNITS,
    Head,
    message_dtype,
    message_path,
    schema_text,
)
from frictool.logs.flow import Samples
from frictool.logs.log import Log, Stream, Vector
from frictool.logs.table import Nanoseconds

LIBRARY = "frictool"
ZSTD_LEVEL = -3  # a fast one: level 1 is 14 % smaller and takes a third more time to write and to read
BATCH_BYTES = 1 << 20  # of values that are packed at once: chunks of a slow log are small
MOST_PACKING = 4  # batches that wait to be written

ZSTD = b"zstd"

# two records that are many; what is behind each is as long as it says
_CHUNK = struct.Struct("<BQ QQQI I4s Q")  # start, end, plain size, CRC, name of the compression, packed size
_CHUNK_INDEX = struct.Struct("<BQ QQQQ IHQ Q I4s QQ")  # start, end, offset, length, {channel: its index}, all indexes, name, packed, plain
_CHANNEL_OFFSET = struct.Struct("<HQ")
_INDEX_ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])
Notes = dict[str, dict[str, str]]  # metadata records: name -> key -> text


class _Chunk(NamedTuple):
    """Samples on their way into the file: of which stream, how many were before them, and themselves."""

    stream: int
    before: int
    time: Nanoseconds
    values: Sequence[Vector]


class _Packed(NamedTuple):
    """A chunk and its index behind it, as they are written. span: first and last time. sizes: of the content, compressed and plain."""

    channel: int
    span: tuple[int, int]
    record: bytes
    behind: bytes
    sizes: tuple[int, int]


class CanonicalWriter:
    """Writes the head of a log, then one chunk after the other, then the summary.

    Args:
        stream: where the bytes go; only written to, so that it may be a pipe.
        heads: the streams; `chunk` names one by its position here.
        metadata: further metadata records, name -> key -> text.
        shift_ns: what was added to every time to make it positive; the reader subtracts it.
    """

    def __init__(self, stream: BinaryIO, heads: tuple[Head, ...], metadata: Notes, shift_ns: int = 0) -> None:
        self._stream = stream
        self.shift_ns = shift_ns
        self._offset = 0
        self._crc = 0
        self._schemas, self._channels = _declarations(heads)
        self._blanks = [_blank(number, head) for number, head in enumerate(heads)]
        self._counts = [0] * len(heads)
        self._span: tuple[int, int] | None = None
        self._chunks: list[bytes] = []  # their indexes
        self._metadata: list[MetadataIndex] = []
        self._compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL)
        self._packer = ThreadPoolExecutor(1)  # compresses while the next samples are read
        self._batch: list[_Chunk] = []
        self._held = 0  # bytes in the batch
        self._packing: deque[Future[tuple[list[_Packed], bytes]]] = deque()
        self._put(MAGIC)
        for record in (Header(PROFILE, LIBRARY), *self._schemas, *self._channels):
            self._put(_bytes(record))
        units = {message_path(h.topic, name): unit for h in heads for name, unit in zip(h.fields, h.units, strict=True)}
        shift = {TIME: {**metadata.get(TIME, {}), SHIFT_KEY: str(shift_ns)}} if shift_ns else {}
        for name, entries in {**metadata, UNITS: units, **shift}.items():
            self.describe(name, entries)

    def chunk(self, index: int, time: Nanoseconds, values: Sequence[Vector]) -> None:
        """Appends samples of stream `index`: time (n,) in ns, not negative; one vector (n,) for each of its fields."""
        self._batch.append(_Chunk(index, self._counts[index], time, values))
        self._counts[index] += time.size
        first, last = int(time[0]), int(time[-1])
        self._span = (first, last) if self._span is None else (min(self._span[0], first), max(self._span[1], last))
        self._held += time.nbytes * (1 + len(values))
        if self._held >= BATCH_BYTES:
            self._submit()

    def _submit(self) -> None:
        self._packing.append(self._packer.submit(self._pack, self._batch))
        self._batch, self._held = [], 0
        if len(self._packing) > MOST_PACKING:
            self._put_chunks(*self._packing.popleft().result())

    def _pack(self, batch: list[_Chunk]) -> tuple[list[_Packed], bytes]:
        chunks = [self._packed(one) for one in batch]
        return chunks, b"".join(part for one in chunks for part in (one.record, one.behind))

    def _packed(self, chunk: _Chunk) -> _Packed:
        channel, time, n = chunk.stream + 1, chunk.time, chunk.time.size
        dtype, blank = self._blanks[chunk.stream]
        if len(blank) < n * dtype.itemsize:
            blank = blank[: dtype.itemsize] * n
            self._blanks[chunk.stream] = dtype, blank
        records = np.frombuffer(bytearray(memoryview(blank)[: n * dtype.itemsize]), dtype)
        records["sequence"] = np.arange(chunk.before, chunk.before + n) & 0xFFFFFFFF
        records["log_time"] = records["publish_time"] = time
        for column, vector in enumerate(chunk.values):
            records["values"][:, column] = vector
        packed, plain, span = self._compressor.compress(records.data), records.nbytes, (int(time[0]), int(time[-1]))
        length = _CHUNK.size - RECORD_HEAD + len(packed)
        head = _CHUNK.pack(Opcode.CHUNK, length, *span, plain, zlib.crc32(records.data), len(ZSTD), ZSTD, len(packed))
        entries = np.empty(n, _INDEX_ENTRY)
        entries["time"], entries["offset"] = time, np.arange(n) * records.itemsize
        index_head = struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6 + entries.nbytes, channel, entries.nbytes)
        return _Packed(channel, span, head + packed, index_head + entries.tobytes(), (len(packed), plain))

    def _put_chunks(self, chunks: list[_Packed], together: bytes) -> None:
        start = self._offset
        self._put(together)
        for one in chunks:
            length, behind = len(one.record), len(one.behind)
            offsets = (_CHANNEL_OFFSET.size, one.channel, start + length)
            index = (*one.span, start, length, *offsets, behind, len(ZSTD), ZSTD, *one.sizes)
            self._chunks.append(_CHUNK_INDEX.pack(Opcode.CHUNK_INDEX, _CHUNK_INDEX.size - RECORD_HEAD, *index))
            start += length + behind

    def finish(self) -> None:
        """Writes the end of the data, the summary and the footer. The stream stays open."""
        self._drain()
        self._packer.shutdown()
        self._put(_bytes(DataEnd(self._crc)))
        start = self._offset
        groups = (
            (Opcode.SCHEMA, map(_bytes, self._schemas)),
            (Opcode.CHANNEL, map(_bytes, self._channels)),
            (Opcode.STATISTICS, [_bytes(self._statistics())]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.METADATA_INDEX, map(_bytes, self._metadata)),
        )
        summary, offsets = b"", b""
        for opcode, records in groups:
            group = b"".join(records)
            offsets += _bytes(SummaryOffset(opcode, start + len(summary), len(group))) if group else b""
            summary += group
        footer = _bytes(Footer(start, start + len(summary), 0))
        crc = zlib.crc32(summary + offsets + footer[:-4])
        self._put(summary + offsets + footer[:-4] + crc.to_bytes(4, "little") + MAGIC)

    def _drain(self) -> None:
        if self._batch:
            self._submit()
        while self._packing:
            self._put_chunks(*self._packing.popleft().result())

    def _statistics(self) -> Statistics:
        first, last = self._span or (0, 0)
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts={number + 1: count for number, count in enumerate(self._counts)},
            chunk_count=len(self._chunks),
            message_count=sum(self._counts),
            message_end_time=last,
            message_start_time=first,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def describe(self, name: str, entries: dict[str, str]) -> None:
        """Writes a metadata record."""
        self._drain()
        record = _bytes(Metadata(name, entries))
        self._metadata.append(MetadataIndex(self._offset, len(record), name))
        self._put(record)

    def _put(self, data: bytes) -> None:
        self._stream.write(data)
        self._crc = zlib.crc32(data, self._crc)
        self._offset += len(data)


def write_mcap(log: Log, stream: BinaryIO) -> None:
    """Writes a log as canonical MCAP. Times are rounded to ns; a log that starts before 0 is shifted, and the reader shifts it back.

    Raises LogError where a stream is empty, a value is not finite, or times do not increase by at least 1 ns; ValueError where a topic
    or a signal has a name that ROS 2 tools would refuse.
    """
    heads = tuple(_head(one) for one in log.streams)
    times = [_nanoseconds(log.source, one) for one in log.streams]
    shift = max([0, *(-int(time[0]) for time in times)])
    metadata = {name: entries for name, entries in log.metadata.items() if name != UNITS}
    streams = [
        Samples(time, tuple(one.signals[name] for name in head.fields)) for one, head, time in zip(log.streams, heads, times, strict=True)
    ]
    write_streams(CanonicalWriter(stream, heads, metadata, shift), [chunked(iter([one])) for one in streams])


def write_streams(writer: CanonicalWriter, streams: list[Iterator[Samples]], last: Callable[[], Notes] = dict) -> None:
    """Writes the chunks of all streams in the order of time, and the file's end. Times are in ns, before the writer's shift.

    last: gives metadata records that are known only when all samples have been read.
    """
    for place, piece in merged(streams):
        writer.chunk(place, piece.time + writer.shift_ns, piece.values)
    for name, entries in last().items():
        writer.describe(name, entries)
    writer.finish()


def _head(stream: Stream) -> Head:
    return Head(stream.topic, tuple(stream.signals), tuple(stream.units[name] for name in stream.signals))


def _nanoseconds(source: str, stream: Stream) -> Nanoseconds:
    if not stream.time.size or not stream.signals:
        raise LogError(source, f"stream {stream.topic} has no {'signals' if stream.time.size else 'samples'}; nothing to write")
    for name, values in {"time": stream.time, **stream.signals}.items():
        if not np.isfinite(values).all():
            sample = int(np.flatnonzero(~np.isfinite(values))[0])
            raise LogError(source, f"stream {stream.topic}, {name}: sample {sample + 1} is {values[sample]}; allowed: finite numbers")
    if np.abs(stream.time).max() > LATEST:
        raise LogError(source, f"stream {stream.topic}: time {stream.time[-1]:g} s is beyond {LATEST:g} s; is its unit right?")
    time = np.rint(stream.time * NS).astype(np.int64)
    if time.size > 1 and np.diff(time).min() <= 0:
        sample = int(np.flatnonzero(np.diff(time) <= 0)[0]) + 1
        raise LogError(source, f"stream {stream.topic}: time does not increase by 1 ns or more at sample {sample + 1}")
    return time


def _blank(stream: int, head: Head) -> tuple[np.dtype[np.void], bytes]:
    """The layout of a stream's messages, and the bytes of one with what is the same in all of them."""
    dtype = message_dtype(len(head.fields))
    record = np.zeros(1, dtype)
    record["opcode"], record["length"], record["channel"] = MESSAGE_OPCODE, dtype.itemsize - RECORD_HEAD, stream + 1
    record["cdr"] = CDR_HEAD
    return dtype, record.tobytes()


def _declarations(heads: tuple[Head, ...]) -> tuple[list[Schema], list[Channel]]:
    """One schema per distinct set of fields, one channel per stream."""
    schemas: dict[tuple[str, ...], Schema] = {}
    channels = []
    for number, head in enumerate(heads, start=1):
        identity = len(schemas) + 1
        name = SCHEMA_NAME if identity == 1 else f"{SCHEMA_NAME}{identity}"
        schema = schemas.setdefault(head.fields, Schema(identity, schema_text(head.fields).encode(), SCHEMA_ENCODING, name))
        channels.append(Channel(number, head.topic, MESSAGE_ENCODING, {}, schema.id))
    if len({channel.topic for channel in channels}) < len(channels):
        raise ValueError("two streams of one topic")
    return list(schemas.values()), channels


def _bytes(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # the library types no result here
    return data
