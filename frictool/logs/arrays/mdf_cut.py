"""An MDF file whose end is missing, as a logger leaves it that lost its supply: heads and the first records are there.

asammdf refuses such a file. Here it reads zeros behind the end, and only the records that lie before it are believed.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

ORIGINAL_FILE, PLAIN = 0, 0  # asammdf's codes: data lie where they lay, and are not compressed
VIRTUAL_END = 1 << 40


class Padded(io.BufferedIOBase):
    """A file with zeros behind its end."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("rb")
        self._size = path.stat().st_size
        self._at = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._at

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self._at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: VIRTUAL_END}[whence]
        return self._at

    def read(self, size: int | None = -1, /) -> bytes:
        size = VIRTUAL_END - self._at if size is None or size < 0 else size
        self._file.seek(min(self._at, self._size))
        data = self._file.read(size)
        self._at += size
        return data + bytes(size - len(data))

    def close(self) -> None:
        self._file.close()
        super().close()


def records_before(group: Any, end: int) -> int:
    """How many records of an asammdf group lie before byte `end` of the file. Raises ValueError where they have been moved elsewhere."""
    if group.data_location != ORIGINAL_FILE or group.uses_ld:
        raise ValueError("the records of its groups are mixed or lie by columns")
    found = 0
    for block in group.get_data_blocks():
        there = max(0, min(block.compressed_size, end - block.address))
        if there < block.compressed_size:
            found += there if block.block_type == PLAIN else 0
            break
        found += block.original_size
    size = int(group.channel_group.samples_byte_nr + group.channel_group.invalidation_bytes_nr)
    return int(min(found // max(size, 1), group.channel_group.cycles_nr))
