"""The bytes of a file one after the other, and the CRC of those taken: read and summed in large
pieces, whatever is taken."""

from __future__ import annotations

import zlib
from typing import BinaryIO

PIECE = 1 << 19


class CountedBytes:
    """Takes bytes off a stream of `size` bytes; `offset` is where it stands. Raises OSError."""

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream, self._size = stream, size
        self._held = memoryview(bytearray(PIECE))
        self._place = self._end = (
            0  # in what is held: where the next byte is, and behind the last one that was read
        )
        self._crc: int | None = 0
        self._counted = 0  # in what is held: up to where the CRC counts
        self.offset = 0

    def take(self, length: int) -> bytes:
        """The next bytes; fewer where the file ends."""
        if self._place + length > self._end:
            length = min(length, self._size - self.offset)
            if length > PIECE:
                return self._taken_at_once(length)
            self._fill()
        data = bytes(self._held[self._place : min(self._place + length, self._end)])
        self._place += len(data)
        self.offset += len(data)
        return data

    def peek(self, length: int) -> bytes:
        """The same without going on, of at most PIECE bytes."""
        data = self.take(length)
        self._place -= len(data)
        self.offset -= len(data)
        return data

    def crc(self) -> int | None:
        """Of what was taken since it was begun; None once bytes were stepped over."""
        self._count(self._place)
        return self._crc

    def begin_crc(self) -> None:
        self._crc, self._counted = 0, self._place

    def step_to(self, offset: int) -> None:
        """Goes on at `offset`, wherever the stream stands."""
        self._stream.seek(offset)
        self._place, self._end, self._crc, self._counted, self.offset = 0, 0, None, 0, offset

    def _fill(self) -> None:
        """Reads on behind what is left."""
        self._count(self._place)
        left = self._end - self._place
        self._held[:left] = self._held[self._place : self._end]
        self._place, self._end, self._counted = 0, left, 0
        more = self._held[left : min(PIECE, left + self._size - self.offset)]
        self._end += self._stream.readinto(more)  # type: ignore[attr-defined]  # a buffered file has it, the protocol does not say so

    def _taken_at_once(self, length: int) -> bytes:
        """More than is ever held."""
        self._count(self._end)
        left = self._held[self._place : self._end]
        more = self._stream.read(length - len(left))
        data = b"".join((left, more))
        self._crc = None if self._crc is None else zlib.crc32(more, self._crc)
        self._place = self._end = self._counted = 0
        self.offset += len(data)
        return data

    def _count(self, place: int) -> None:
        if self._crc is not None and place > self._counted:
            self._crc = zlib.crc32(self._held[self._counted : place], self._crc)
            self._counted = place
