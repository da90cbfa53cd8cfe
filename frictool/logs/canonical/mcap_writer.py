"""Writer of the canonical log (mcap_layout.py); the same log always gives the same bytes."""

from __future__ import annotations

import zlib
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import BinaryIO

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

from frictool.documents.provenance import readable
from frictool.logs.canonical.mcap_layout import (
    MAGIC,
    MESSAGE_ENCODING,
    PROFILE,
    SCHEMA_ENCODING,
    SCHEMA_NAME,
    SHIFT_KEY,
    TIME,
    UNITS,
    StreamHeader,
    message_path,
    schema_text,
)
from frictool.logs.canonical.mcap_packing import ChunkPacker, ChunkSamples, PackedChunk
from frictool.logs.canonical.sample_chunks import merged
from frictool.logs.raw_table import Nanoseconds
from frictool.logs.stream_source import SampleBlock
from frictool.typing import Vector

LIBRARY = "frictool"
BATCH_BYTES = 1 << 20  # bytes of values packed in one batch: chunks of a slow log are small
MOST_PACKING = 4  # maximum number of batches that wait to be written

Notes = dict[str, dict[str, str]]  # metadata records: name -> key -> text


class CanonicalWriter:
    """Writer of the head, the chunks and the summary of a log.

    stream: binary output, which may be a pipe.
    heads: headers of the streams. The method `chunk` identifies a stream by its index in `heads`.
    metadata: additional metadata records by name; each record maps keys to texts.
    shift_ns: time in ns that is added to every time so that no time is negative. Readers subtract
        this shift.
    """

    def __init__(
        self, stream: BinaryIO, heads: tuple[StreamHeader, ...], metadata: Notes, shift_ns: int = 0
    ) -> None:
        self._stream = stream
        self.shift_ns = shift_ns
        self._offset = 0
        self._crc = 0
        self._schemas, self._channels = _declarations(heads)
        self._packer = ChunkPacker(heads)
        self._counts = [0] * len(heads)
        self._span: tuple[int, int] | None = None
        self._chunks: list[bytes] = []  # chunk index records
        self._metadata: list[MetadataIndex] = []
        self._thread = ThreadPoolExecutor(1)  # compresses while the next samples are read
        self._batch: list[ChunkSamples] = []
        self._held = 0  # bytes in the batch
        self._packing: deque[Future[tuple[list[PackedChunk], bytes]]] = deque()
        self._put(MAGIC)
        for record in (Header(PROFILE, LIBRARY), *self._schemas, *self._channels):
            self._put(_bytes(record))
        units = {
            message_path(h.topic, name): unit
            for h in heads
            for name, unit in zip(h.fields, h.units, strict=True)
        }
        shift = {TIME: {**metadata.get(TIME, {}), SHIFT_KEY: str(shift_ns)}} if shift_ns else {}
        for name, entries in {**metadata, UNITS: units, **shift}.items():
            self.describe(name, entries)

    def chunk(self, index: int, time: Nanoseconds, values: Sequence[Vector]) -> None:
        """Append a chunk of samples of the stream `heads[index]`.

        time: times (n,) in ns, not negative.
        values: one vector (n,) for each field.
        """
        self._batch.append(ChunkSamples(index, self._counts[index], time, values))
        self._counts[index] += time.size
        first, last = int(time[0]), int(time[-1])
        self._span = (
            (first, last)
            if self._span is None
            else (min(self._span[0], first), max(self._span[1], last))
        )
        self._held += time.nbytes * (1 + len(values))
        if self._held >= BATCH_BYTES:
            self._submit()

    def _submit(self) -> None:
        self._packing.append(self._thread.submit(self._pack, self._batch))
        self._batch = []
        self._held = 0
        if len(self._packing) > MOST_PACKING:
            self._put_chunks(*self._packing.popleft().result())

    def _pack(self, batch: list[ChunkSamples]) -> tuple[list[PackedChunk], bytes]:
        chunks = [self._packer.packed(one) for one in batch]
        return chunks, b"".join(part for one in chunks for part in (one.record, one.behind))

    def _put_chunks(self, chunks: list[PackedChunk], together: bytes) -> None:
        start = self._offset
        self._put(together)
        for one in chunks:
            self._chunks.append(one.summed_up(start))
            start += len(one.record) + len(one.behind)

    def finish(self) -> None:
        """Write the end of the data, the summary and the footer; leave the output open."""
        self._drain()
        self._thread.shutdown()
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
            offsets += (
                _bytes(SummaryOffset(opcode, start + len(summary), len(group))) if group else b""
            )
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
        """Write the metadata record `name` with the texts `entries`, by key."""
        self._drain()
        record = _bytes(Metadata(name, {key: readable(text) for key, text in entries.items()}))
        self._metadata.append(MetadataIndex(self._offset, len(record), name))
        self._put(record)

    def _put(self, data: bytes) -> None:
        self._stream.write(data)
        self._crc = zlib.crc32(data, self._crc)
        self._offset += len(data)


def write_streams(
    writer: CanonicalWriter, streams: list[Iterator[SampleBlock]], last: Callable[[], Notes] = dict
) -> None:
    """Write the chunks of all streams in order of time, then the end of the file.

    streams: blocks of samples of each stream; the writer's `shift_ns` is added to their times.
    last: function that is called after all samples have been read, and returns additional metadata
        records.
    """
    for index, piece in merged(streams):
        writer.chunk(index, piece.time + writer.shift_ns, piece.values)
    for name, entries in last().items():
        writer.describe(name, entries)
    writer.finish()


def _declarations(heads: tuple[StreamHeader, ...]) -> tuple[list[Schema], list[Channel]]:
    schemas: dict[tuple[str, ...], Schema] = {}
    channels = []
    for number, head in enumerate(heads, start=1):
        identity = len(schemas) + 1
        name = SCHEMA_NAME if identity == 1 else f"{SCHEMA_NAME}{identity}"
        schema = schemas.setdefault(
            head.fields, Schema(identity, schema_text(head.fields).encode(), SCHEMA_ENCODING, name)
        )
        channels.append(Channel(number, head.topic, MESSAGE_ENCODING, {}, schema.id))
    if len({channel.topic for channel in channels}) < len(channels):
        raise ValueError("two streams have the same topic")
    return list(schemas.values()), channels


def _bytes(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # the library types no result here
    return data
