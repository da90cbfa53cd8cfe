"""Streams of the bytes in a part of a file, as stored or decompressed.

A stream does not raise an error when it reaches damaged bytes. The stream ends there and states the
reason in `damage`, so that everything before the damage can be salvaged.
"""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import IO

PIECE = 1 << 16  # bytes in one read


class ByteStream:
    """Stream of at most `length` bytes of a file, from byte `start` on.

    position: number of bytes returned or skipped so far.
    damage: why the stream ended early; None if no damage has been found.
    """

    def __init__(self, path: Path, start: int, length: int) -> None:
        self._file: IO[bytes] = path.open("rb")
        self._file.seek(start)
        self._left = length
        self.position = 0
        self.damage: str | None = None

    def __enter__(self) -> ByteStream:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def read(self, size: int, /) -> bytes:
        """Return the next `size` bytes.

        If the stream ends early, fewer bytes are returned and `damage` states the reason.
        """
        parts = []
        while size > 0 and self.damage is None:
            part = self._piece(size)
            if not part:
                self.damage = self.damage or f"is cut off: {size} bytes are missing"
            parts.append(part)
            size -= len(part)
            self.position += len(part)
        return b"".join(parts)

    def skip(self, size: int) -> None:
        """Skip `size` bytes."""
        while size > 0 and self.damage is None:
            size -= len(self.read(min(size, PIECE)))

    def check(self) -> None:
        """Verify the checksum at the end of the stream, if any; set `damage` if it is wrong."""

    def _piece(self, most: int) -> bytes:
        try:
            part = self._file.read(min(most, self._left))
        except OSError as error:
            self.damage = f"cannot be read: {error.strerror or error}"
            return b""
        self._left -= len(part)
        return part


class FileBytes(ByteStream):
    """Stream of a file's bytes without conversion; skipped bytes are not read."""

    def skip(self, size: int) -> None:
        """Skip `size` bytes; set `damage` if the file ends earlier."""
        step = max(0, min(size, self._left))
        self._file.seek(step, 1)
        self._left -= step
        self.position += step
        if step < size:
            self.damage = self.damage or f"is cut off: {size - step} bytes are missing"


class InflatedBytes(ByteStream):
    """Stream of the decompressed content of a zlib stream; `check` verifies its checksum."""

    def __init__(self, path: Path, start: int, length: int) -> None:
        super().__init__(path, start, length)
        self._inflater = zlib.decompressobj()

    def check(self) -> None:
        """Read to the end; set `damage` if bytes of the stream are damaged or missing."""
        while self.damage is None and self._piece(PIECE):
            pass
        if not self._inflater.eof:
            self.damage = self.damage or "is cut off"

    def _piece(self, most: int) -> bytes:
        while self.damage is None and not self._inflater.eof:
            packed = self._inflater.unconsumed_tail or super()._piece(PIECE)
            if not packed:
                break
            try:
                part = self._inflater.decompress(packed, most)
            except zlib.error as error:
                self.damage = f"has damaged compressed bytes ({error})"
                break
            if part:
                return part
        return b""


class ArchiveBytes(ByteStream):
    """Stream that another library decodes and verifies, such as a member of a zip archive."""

    def __init__(self, opened: IO[bytes], length: int) -> None:
        self._file = opened
        self._left = length
        self.position = 0
        self.damage: str | None = None

    def check(self) -> None:
        """Read to the end; set `damage` if bytes of the stream are damaged."""
        while self.damage is None and self._piece(PIECE):
            pass

    def _piece(self, most: int) -> bytes:
        try:
            return super()._piece(most)
        except Exception as error:  # zipfile raises BadZipFile, and errors of zlib, lzma and others
            self.damage = f"is in a damaged archive ({str(error) or type(error).__name__})"
            return b""
