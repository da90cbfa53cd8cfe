"""Reading of an MDF file whose end is missing because its logger lost power.

asammdf rejects such a file, although the file contains the heads and the first records. Therefore
the file is opened as a `ZeroPaddedFile`, and only the records before the real end are used.
"""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

# asammdf's codes for data in the original file, and for uncompressed data
ORIGINAL_FILE, PLAIN = 0, 0
VIRTUAL_END = 1 << 40  # bytes, size that the file pretends to have
HEADER = 64  # offset of block HD of version 4, whose links lead to all other blocks
# blocks that describe the channels, from the file to the single channel
DESCRIBING = (b"##HD", b"##DG", b"##CG", b"##CN")
MOST_BLOCKS = 100_000
_BLOCK = struct.Struct("<4s4xQQ")  # kind, length, number of links; the links follow


class ZeroPaddedFile(io.BufferedIOBase):
    """File that can be read beyond its end, where all bytes are zero."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("rb")
        self._size = path.stat().st_size
        self._at = 0

    def readable(self) -> bool:
        """Return True: the file can be read."""
        return True

    def seekable(self) -> bool:
        """Return True: the position can be set."""
        return True

    def tell(self) -> int:
        """Return the position in bytes."""
        return self._at

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Set the position and return it; SEEK_END is relative to VIRTUAL_END."""
        self._at = (
            offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: VIRTUAL_END}[whence]
        )
        return self._at

    def read(self, size: int | None = -1, /) -> bytes:
        """Return up to `size` bytes; zeros replace the bytes after the end of the file."""
        size = VIRTUAL_END - self._at if size is None or size < 0 else size
        self._file.seek(min(self._at, self._size))
        data = self._file.read(size)
        self._at += size
        return data + bytes(size - len(data))

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()


def records_before(group: Any, end: int) -> int:
    """Return how many records of an asammdf channel group lie before byte `end` of the file.

    Raises ValueError if the records are not stored in order in the file.
    """
    if group.data_location != ORIGINAL_FILE or group.uses_ld:
        raise ValueError("records of several channel groups are mixed, or are stored by columns")
    preceding = 0
    for block in group.get_data_blocks():
        there = max(0, min(block.compressed_size, end - block.address))
        if there < block.compressed_size:
            preceding += there if block.block_type == PLAIN else 0
            break
        preceding += block.original_size
    size = int(group.channel_group.samples_byte_nr + group.channel_group.invalidation_bytes_nr)
    return int(min(preceding // max(size, 1), group.channel_group.cycles_nr))


def described_at(path: Path) -> int | None:
    """Return the offset of a missing or incomplete MDF block that describes channels.

    The result is None if the file contains all such blocks completely. The file must have MDF
    version 4.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        waiting = [HEADER]
        seen = {HEADER}
        while waiting and len(seen) < MOST_BLOCKS:
            at = waiting.pop()
            stream.seek(at)
            head = stream.read(_BLOCK.size)
            if at + _BLOCK.size > size:
                return at
            kind, length, count = _BLOCK.unpack(head)
            if kind not in DESCRIBING or not _BLOCK.size + 8 * count <= length <= size:
                continue
            if at + length > size:
                return at
            links = struct.unpack(f"<{count}Q", stream.read(8 * count))
            # the first link leads to the next block of this kind, the second to the first block of
            # the next kind, the others to texts, data and tools
            new = {
                link for link in links[: 1 if at == HEADER else 2] if link
            } - seen  # the head HD has no next block
            seen |= new
            waiting += new
    return None
