"""Samples as a chunk of the canonical log and the index behind it, as their bytes stand in the file
(mcap_layout.py)."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import zstandard
from mcap.opcode import Opcode

from frictool.logs.canonical.mcap_layout import (
    CDR_HEAD,
    MESSAGE_OPCODE,
    RECORD_HEAD,
    StreamHeader,
    message_dtype,
)
from frictool.logs.log import Vector
from frictool.logs.table import Nanoseconds

ZSTD = b"zstd"
# a fast level (1 takes a third more time to write and to read), and no match that is shorter than
# the head that all messages share
COMPRESSION = zstandard.ZstdCompressionParameters.from_level(-3, min_match=7)

# two records that are many; what is behind each is as long as it says
_CHUNK = struct.Struct(
    "<BQ QQQI I4s Q"
)  # start, end, plain size, CRC, name of the compression, packed size
_CHUNK_INDEX = struct.Struct(
    "<BQ QQQQ IHQ Q I4s QQ"
)  # start, end, offset, length, {channel: its index}, all indexes, name, packed, plain
_CHANNEL_OFFSET = struct.Struct("<HQ")
_INDEX_ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])


class ChunkSamples(NamedTuple):
    """Samples on their way into the file: of which stream, how many were before them, and
    themselves."""

    stream: int
    before: int
    time: Nanoseconds
    values: Sequence[Vector]


class PackedChunk(NamedTuple):
    """A chunk and its index behind it, as they are written. span: first and last time. sizes: of
    the content, compressed and plain."""

    channel: int
    span: tuple[int, int]
    record: bytes
    behind: bytes
    sizes: tuple[int, int]

    def summed_up(self, start: int) -> bytes:
        """The record that says in the file's summary where the chunk is: at byte `start`."""
        length, behind = len(self.record), len(self.behind)
        offsets = (_CHANNEL_OFFSET.size, self.channel, start + length)
        index = (*self.span, start, length, *offsets, behind, len(ZSTD), ZSTD, *self.sizes)
        return _CHUNK_INDEX.pack(Opcode.CHUNK_INDEX, _CHUNK_INDEX.size - RECORD_HEAD, *index)


class ChunkPacker:
    """Packs the samples of the streams `heads`, one chunk at a time."""

    def __init__(self, heads: tuple[StreamHeader, ...]) -> None:
        self._blanks = [_blank(number, head) for number, head in enumerate(heads)]
        self._compressor = zstandard.ZstdCompressor(compression_params=COMPRESSION)

    def packed(self, chunk: ChunkSamples) -> PackedChunk:
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
        packed, plain, span = (
            self._compressor.compress(records.data),
            records.nbytes,
            (int(time[0]), int(time[-1])),
        )
        length = _CHUNK.size - RECORD_HEAD + len(packed)
        head = _CHUNK.pack(
            Opcode.CHUNK,
            length,
            *span,
            plain,
            zlib.crc32(records.data),
            len(ZSTD),
            ZSTD,
            len(packed),
        )
        entries = np.empty(n, _INDEX_ENTRY)
        entries["time"], entries["offset"] = time, np.arange(n) * records.itemsize
        index_head = struct.pack(
            "<BQHI", Opcode.MESSAGE_INDEX, 6 + entries.nbytes, channel, entries.nbytes
        )
        return PackedChunk(
            channel, span, head + packed, index_head + entries.tobytes(), (len(packed), plain)
        )


def _blank(stream: int, head: StreamHeader) -> tuple[np.dtype[np.void], bytes]:
    """The layout of a stream's messages, and the bytes of one with what is the same in all of
    them."""
    dtype = message_dtype(len(head.fields))
    record = np.zeros(1, dtype)
    record["opcode"], record["length"], record["channel"] = (
        MESSAGE_OPCODE,
        dtype.itemsize - RECORD_HEAD,
        stream + 1,
    )
    record["cdr"] = CDR_HEAD
    return dtype, record.tobytes()
