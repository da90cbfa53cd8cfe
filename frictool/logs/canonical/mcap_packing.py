"""Packing of samples of the canonical log into MCAP chunks with their indexes (mcap_layout.py)."""

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
from frictool.logs.raw_table import Nanoseconds
from frictool.typing import Vector

ZSTD = b"zstd"
# a fast level (level 1 takes a third more time to write and to read); matches have at least 7
# bytes, since the heads of all messages are nearly equal
COMPRESSION = zstandard.ZstdCompressionParameters.from_level(-3, min_match=7)

# heads of the chunk record and of the chunk index record
# start, end, plain size, CRC, name of the compression, packed size
_CHUNK = struct.Struct("<BQ QQQI I4s Q")
# start, end, offset, length, {channel: index offset}, size of indexes, compression, packed and
# plain size
_CHUNK_INDEX = struct.Struct("<BQ QQQQ IHQ Q I4s QQ")
_CHANNEL_OFFSET = struct.Struct("<HQ")
_INDEX_ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])


class ChunkSamples(NamedTuple):
    """Samples of one stream that are packed into one chunk.

    stream: index of the stream.
    before: number of samples of this stream that earlier chunks contain.
    time: times (n,) in ns.
    values: one vector (n,) for each field.
    """

    stream: int
    before: int
    time: Nanoseconds
    values: Sequence[Vector]


class PackedChunk(NamedTuple):
    """Chunk record, and the message index record that follows the chunk record.

    span: times of the first and the last sample in ns.
    behind: bytes of the message index record.
    sizes: compressed and uncompressed size of the chunk's content in bytes.
    """

    channel: int
    span: tuple[int, int]
    record: bytes
    behind: bytes
    sizes: tuple[int, int]

    def summed_up(self, start: int) -> bytes:
        """Return the chunk index record for the summary.

        start: position of the chunk in the file, in bytes.
        """
        length, behind = len(self.record), len(self.behind)
        offsets = (_CHANNEL_OFFSET.size, self.channel, start + length)
        index = (*self.span, start, length, *offsets, behind, len(ZSTD), ZSTD, *self.sizes)
        return _CHUNK_INDEX.pack(Opcode.CHUNK_INDEX, _CHUNK_INDEX.size - RECORD_HEAD, *index)


class ChunkPacker:
    """Packer of samples into chunks, for streams with the headers `heads`."""

    def __init__(self, heads: tuple[StreamHeader, ...]) -> None:
        self._blanks = [_blank(number, head) for number, head in enumerate(heads)]
        self._compressor = zstandard.ZstdCompressor(compression_params=COMPRESSION)

    def packed(self, chunk: ChunkSamples) -> PackedChunk:
        """Return the chunk that contains the samples, and the message index of the chunk."""
        channel = chunk.stream + 1
        time = chunk.time
        n = chunk.time.size
        dtype, blank = self._blanks[chunk.stream]
        if len(blank) < n * dtype.itemsize:
            blank = blank[: dtype.itemsize] * n
            self._blanks[chunk.stream] = dtype, blank
        records = np.frombuffer(bytearray(memoryview(blank)[: n * dtype.itemsize]), dtype)
        records["sequence"] = np.arange(chunk.before, chunk.before + n) & 0xFFFFFFFF
        records["log_time"] = records["publish_time"] = time
        for column, vector in enumerate(chunk.values):
            records["values"][:, column] = vector
        packed = self._compressor.compress(records.data)
        plain = records.nbytes
        span = (int(time[0]), int(time[-1]))
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
        entries["time"] = time
        entries["offset"] = np.arange(n) * records.itemsize
        index_head = struct.pack(
            "<BQHI", Opcode.MESSAGE_INDEX, 6 + entries.nbytes, channel, entries.nbytes
        )
        return PackedChunk(
            channel, span, head + packed, index_head + entries.tobytes(), (len(packed), plain)
        )


def _blank(stream: int, head: StreamHeader) -> tuple[np.dtype[np.void], bytes]:
    dtype = message_dtype(len(head.fields))
    record = np.zeros(1, dtype)
    record["opcode"] = MESSAGE_OPCODE
    record["length"] = dtype.itemsize - RECORD_HEAD
    record["channel"] = stream + 1
    record["cdr"] = CDR_HEAD
    return dtype, record.tobytes()
