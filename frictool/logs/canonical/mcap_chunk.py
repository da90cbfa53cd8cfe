"""Decompression of MCAP chunks up to their declared size, with a check of their CRC."""

from __future__ import annotations

import struct
import threading
import zlib

import zstandard

LARGEST = 256_000_000  # bytes, maximum plain size of a chunk; frictool writes at most 4 million
PIECE = 1 << 16  # bytes decompressed in one call
# start, end, uncompressed size, CRC, length of the compression's name
_FIXED = struct.Struct("<QQQII")
_U64 = struct.Struct("<Q")


class _ThreadDecompressor(threading.local):
    def __init__(self) -> None:
        self.zstd = zstandard.ZstdDecompressor()


_per_thread = _ThreadDecompressor()


def chunk_data(body: bytes) -> bytes:
    """Return the uncompressed records in a chunk.

    body: body of the chunk record.

    Raises ValueError if the data does not have the declared size, cannot be decompressed, or has a
    wrong CRC. A CRC of 0 means that the file has no CRC for the chunk.
    """
    _, _, size, crc, name_length = _FIXED.unpack_from(body)
    name_end = _FIXED.size + name_length
    compression = body[_FIXED.size : name_end].decode()
    (length,) = _U64.unpack_from(body, name_end)
    packed = memoryview(body)[name_end + _U64.size :]
    if length != len(packed):
        raise ValueError(f"a chunk declares {length} bytes, but {len(packed)} follow")
    if size > LARGEST:
        raise ValueError(f"a chunk declares {size} bytes; allowed: at most {LARGEST}")
    data = _decompress(compression, packed, size)
    if len(data) != size:
        raise ValueError(f"a chunk contains {len(data)} bytes, but declares {size}")
    if crc not in (0, zlib.crc32(data)):
        raise ValueError("the CRC of a chunk is wrong")
    return data


def plain_size(body: bytes) -> int:
    """Return the uncompressed size in bytes that a chunk declares, limited to LARGEST.

    body: body of the chunk record.

    The result is 0 if the head of the chunk is truncated.
    """
    return min(int(_FIXED.unpack_from(body)[2]), LARGEST) if len(body) >= _FIXED.size else 0


def _decompress(compression: str, packed: memoryview, size: int) -> bytes:
    if compression == "":
        return bytes(packed)
    if compression == "zstd":
        try:
            if zstandard.frame_content_size(packed) not in (-1, size):  # -1: size not declared
                raise ValueError("a chunk and its zstd frame declare different sizes")
            return _per_thread.zstd.decompress(packed, max_output_size=size)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from None
    if compression == "lz4":
        import lz4.frame

        try:
            data: bytes = lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size + 1)
        except RuntimeError as error:
            raise ValueError(str(error)) from None
        return data
    raise ValueError(f"unknown compression {compression!r}; allowed: zstd, lz4, none")


def chunk_prefix(rest: bytes) -> bytes:
    """Return the beginning of a truncated chunk, decompressed as far as possible.

    rest: those bytes of the chunk record's body that the file contains.

    The last record in the result may be incomplete. Raises ValueError if the head of the chunk is
    truncated.
    """
    if len(rest) < _FIXED.size + _U64.size:
        raise ValueError("the head of a chunk is truncated")
    _, _, size, _, name_length = _FIXED.unpack_from(rest)
    name_end = _FIXED.size + name_length
    compression = rest[_FIXED.size : name_end]
    packed = rest[name_end + _U64.size :]
    size = min(size, LARGEST)
    if compression == b"zstd":
        pieces = []
        try:
            with _per_thread.zstd.stream_reader(packed) as stream:
                while size > 0 and (piece := stream.read(min(size, PIECE))):
                    pieces.append(piece)
                    size -= len(piece)
        except zstandard.ZstdError:  # damaged after a valid start
            pass
        return b"".join(pieces)
    if compression == b"lz4":
        import lz4.frame

        try:
            data: bytes = lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size)
        except RuntimeError:
            return b""
        return data
    return packed
