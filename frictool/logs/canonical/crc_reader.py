"""Buffered reader of a file that computes the CRC of the returned bytes."""

from __future__ import annotations

import zlib
from typing import BinaryIO

PIECE = 1 << 19  # bytes of the buffer


class CountedBytes:
    """Buffered reader of a file of `size` bytes, with a CRC of the bytes that `take` returns.

    offset: position in the file of the next byte.

    All methods that read may raise OSError.
    """

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream, self._size = stream, size
        self._held = memoryview(bytearray(PIECE))
        self._place = self._end = 0  # buffer index of the next byte, and of the end of the data
        self._crc: int | None = 0
        self._counted = 0  # buffer index up to which the CRC has been computed
        self.offset = 0

    def take(self, length: int) -> bytes:
        """Return the next `length` bytes, or all remaining bytes if fewer remain."""
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
        """Return the next `length` bytes, at most PIECE, without moving the read position."""
        data = self.take(length)
        self._place -= len(data)
        self.offset -= len(data)
        return data

    def crc(self) -> int | None:
        """Return the CRC of the bytes read since `begin_crc`; None after a call of `step_to`."""
        self._count(self._place)
        return self._crc

    def begin_crc(self) -> None:
        """Start a new CRC at the next byte."""
        self._crc = 0
        self._counted = self._place

    def step_to(self, offset: int) -> None:
        """Move the read position to byte `offset` of the file.

        The CRC is unknown until the next call of `begin_crc`.
        """
        self._stream.seek(offset)
        self._place = 0
        self._end = 0
        self._crc = None
        self._counted = 0
        self.offset = offset

    def _fill(self) -> None:
        self._count(self._place)
        left = self._end - self._place
        self._held[:left] = self._held[self._place : self._end]
        self._place = 0
        self._end = left
        self._counted = 0
        more = self._held[left : min(PIECE, left + self._size - self.offset)]
        self._end += self._stream.readinto(more)  # type: ignore[attr-defined]  # a binary file has it

    def _taken_at_once(self, length: int) -> bytes:
        self._count(self._end)
        left = self._held[self._place : self._end]
        more = self._stream.read(length - len(left))
        data = b"".join((left, more))
        self._crc = None if self._crc is None else zlib.crc32(more, self._crc)
        self._place = self._end = self._counted = 0
        self.offset += len(data)
        return data

    def _count(self, end: int) -> None:
        if self._crc is not None and end > self._counted:
            self._crc = zlib.crc32(self._held[self._counted : end], self._crc)
            self._counted = end
