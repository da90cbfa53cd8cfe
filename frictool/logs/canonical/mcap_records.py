"""Iterator over the records of an MCAP file; it checks each record and skips damaged bytes.

    file ──▶ FileRecord, FileRecord, DamagedBytes, FileRecord, LooseMessages, ...

A DamagedBytes object reports bytes that are not a valid record, a wrong CRC, or a missing end of
the file. Reading continues at the next position where a record seems to begin.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

import numpy as np
from mcap.opcode import Opcode

from frictool.logs.canonical.crc_reader import PIECE, CountedBytes
from frictool.logs.canonical.mcap_bounds import whole_records
from frictool.logs.canonical.mcap_layout import MAGIC, RECORD_HEAD

RECORD_BYTES = 1 << 30  # bytes, maximum length of a record that is read whole
LONGEST_REST = 64_000_000  # bytes, largest truncated chunk at the end of the file that is read
PEEKED = 64  # first bytes of a body, which contain its lengths
# bytes of a message's head: channel (2), sequence (4), log time (8), publish time (8)
MESSAGE_HEAD = 22
# records whose length can be checked with the lengths in their body
FRAMED = (Opcode.CHUNK, Opcode.MESSAGE_INDEX)
FOOTER_LENGTH = 20  # bytes
CHECKED = (Opcode.DATA_END, Opcode.FOOTER)  # records with a CRC of the bytes before them
_HEAD = struct.Struct("<BQ")
_LENGTH = struct.Struct("<Q")
# start, end, uncompressed size, CRC, length of the compression's name
_CHUNK = struct.Struct("<QQQII")
_INDEX = struct.Struct("<HI")  # channel, bytes of entries
_CANDIDATE = re.compile(rb"[\x01-\x0f].{5}\0\0\0", re.DOTALL)  # an opcode and a length below 1 TB
_COMPRESSIONS = (b"", b"lz4", b"zstd")
_KINDS = frozenset(int(opcode) for opcode in Opcode)


class FileRecord(NamedTuple):
    """Record of kind `opcode` that begins at byte `offset` of the file."""

    opcode: int
    body: bytes
    offset: int


class LooseMessages(NamedTuple):
    """Consecutive complete message records outside of chunks; the first is at byte `offset`."""

    data: bytes
    offset: int


class DamagedBytes(NamedTuple):
    """Bytes `start` to `end` of the file that cannot be read, and the reason.

    rest: first bytes of a chunk that the end of the file cuts off; else empty.
    bare: True if only the head of a chunk is lost. The records of the chunk are then yielded one by
        one.
    """

    start: int
    end: int
    reason: str
    rest: bytes = b""
    bare: bool = False


class FileRecords:
    """Iterator over the records of a file of `size` bytes."""

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream = stream
        self.size = self._size = size
        self._bytes = CountedBytes(stream, size)
        self._doubtful: int | None = None  # offset of the last message, if it was read last

    @property
    def offset(self) -> int:
        """Return the read position, in bytes from the start of the file."""
        return self._bytes.offset

    def __iter__(self) -> Iterator[FileRecord | LooseMessages | DamagedBytes]:
        """Yield the records up to the footer, except attachments.

        Raises OSError if the file cannot be read.
        """
        take = self._bytes.take
        if take(len(MAGIC)) != MAGIC:
            yield DamagedBytes(0, len(MAGIC), "it does not begin like an MCAP file of version 0")
        opcode = 0
        while opcode != Opcode.FOOTER:
            start = self.offset
            head = self._bytes.peek(RECORD_HEAD)
            if not head:
                yield DamagedBytes(start, start, "the file ends without a footer")
                return
            opcode, length = _HEAD.unpack(head) if len(head) == RECORD_HEAD else (0, 1)
            before = self._bytes.crc() if opcode in CHECKED else None
            take(RECORD_HEAD)
            fits = self._may_be(opcode, length)
            if fits and opcode == Opcode.ATTACHMENT:
                self._skip(length)
                continue
            if fits and opcode == Opcode.MESSAGE:
                self._doubtful = start
                yield LooseMessages(head + take(length) + self._following(), start)
                continue
            body = take(length) if fits else b""
            fits &= opcode != Opcode.HEADER or _is_header(body)
            if not fits or (opcode in FRAMED and not _coherent(opcode, length, body[:PEEKED])):
                yield self._stepped_over(start, opcode, length)
                if self.offset == self._size:
                    return
                opcode = 0
                continue
            self._doubtful = None
            if opcode in CHECKED and (wrong := self._wrong_crc(opcode, head, body, before)):
                yield DamagedBytes(start, start, wrong)
            yield FileRecord(opcode, body, start)
        if take(len(MAGIC) + 1) != MAGIC:
            yield DamagedBytes(
                self.offset, self._size, "the closing magic is not at the end of the file"
            )

    def _following(self) -> bytes:
        bounds, end = whole_records(self._bytes.peek(PIECE))
        others = np.flatnonzero((bounds.opcode != Opcode.MESSAGE) | (bounds.length < MESSAGE_HEAD))
        if others.size:
            end = int(bounds.start[others[0]]) - RECORD_HEAD
            bounds = bounds.first(int(others[0]))
        if bounds.start.size:
            self._doubtful = self.offset + int(bounds.start[-1]) - RECORD_HEAD
        return self._bytes.take(end)

    def _skip(self, length: int) -> None:
        end = self.offset + length
        while self.offset < end and self._bytes.take(min(PIECE, end - self.offset)):
            pass

    def _may_be(self, opcode: int, length: int) -> bool:
        known = opcode in _KINDS or opcode >= 0x80  # opcodes from 0x80 on are private
        fits = length <= self._size - self.offset and (
            length <= RECORD_BYTES or opcode == Opcode.ATTACHMENT
        )
        fits &= opcode != Opcode.MESSAGE or length >= MESSAGE_HEAD
        fits &= opcode != Opcode.FOOTER or self._is_last(length)
        return known and fits

    def _is_last(self, length: int) -> bool:
        after = self._bytes.peek(FOOTER_LENGTH + len(MAGIC))[FOOTER_LENGTH:]
        return length == FOOTER_LENGTH and after == MAGIC[: len(after)]

    def _wrong_crc(self, opcode: int, head: bytes, body: bytes, before: int | None) -> str | None:
        if len(body) < 4:
            return None
        self._bytes.begin_crc()
        section, wanted, covered = (
            ("data", body[:4], b"")
            if opcode == Opcode.DATA_END
            else ("summary", body[-4:], head + body[:-4])
        )
        right = before is None or int.from_bytes(wanted, "little") in (
            0,
            zlib.crc32(covered, before),
        )
        return None if right else f"the CRC of the {section} is wrong"

    def _stepped_over(self, start: int, opcode: int, length: int) -> DamagedBytes:
        """Skip to the next valid record and return the skipped bytes as damaged.

        If a message was read last, the search begins inside this message, because the declared
        length of the message may be wrong.
        """
        record = self._next_record((start if self._doubtful is None else self._doubtful) + 1)
        self._doubtful = None
        bare = opcode == Opcode.CHUNK and record == start + RECORD_HEAD + _CHUNK.size + _LENGTH.size
        end = self._size if record is None else record
        rest = b""
        if record is None and opcode == Opcode.CHUNK and end - start <= LONGEST_REST:
            self._stream.seek(start + RECORD_HEAD)
            rest = self._stream.read(end - start - RECORD_HEAD)
        self._bytes.step_to(end)
        if opcode in _KINDS and record is None:
            return DamagedBytes(
                start,
                end,
                f"a record declares {length} bytes, but {end - start - RECORD_HEAD} remain",
                rest,
            )
        return DamagedBytes(
            min(start, end),
            end,
            f"no record begins here: kind {opcode:#04x}, {length} bytes declared",
            rest,
            bare,
        )

    def _next_record(self, start: int) -> int | None:
        while start < self._size:
            self._stream.seek(start)
            window = self._stream.read(PIECE)
            for match in _CANDIDATE.finditer(window):
                if self._begins(start + match.start()):
                    return start + match.start()
            start += max(1, len(window) - RECORD_HEAD + 1)
        return None

    def _begins(self, at: int) -> bool:
        """Return True if a record seems to begin at byte `at`.

        The lengths in the record must be consistent, and another record or the end of the file must
        follow.
        """
        self._stream.seek(at)
        data = self._stream.read(RECORD_HEAD + PEEKED)
        opcode, length = _HEAD.unpack_from(data)
        after = at + RECORD_HEAD + length
        if after > self._size or not _coherent(opcode, length, data[RECORD_HEAD:]):
            return False
        self._stream.seek(after)
        following = self._stream.read(RECORD_HEAD)
        if len(following) < RECORD_HEAD:
            return opcode != Opcode.MESSAGE or not following
        return (
            following.startswith(MAGIC)
            if opcode == Opcode.FOOTER
            else following[0] in _KINDS or following[0] >= 0x80
        )


def _is_header(body: bytes) -> bool:
    profile = int.from_bytes(body[:4], "little")
    library = int.from_bytes(body[4 + profile : 8 + profile], "little")
    return len(body) == 8 + profile + library


def _coherent(opcode: int, length: int, body: bytes) -> bool:
    """Return True if the lengths inside a body agree with the record's length.

    The body of a message contains no lengths; its times are checked instead. Only the length of a
    footer or data end record is checked. Reading resumes only at some kinds of records; the result
    is False for all other kinds.
    """
    if opcode == Opcode.CHUNK and len(body) >= _CHUNK.size + 12:
        start, end, _, _, name = _CHUNK.unpack_from(body)
        packed = (
            int.from_bytes(body[_CHUNK.size + name : _CHUNK.size + name + 8], "little")
            if name <= 4
            else -1
        )
        known = body[_CHUNK.size : _CHUNK.size + name] in _COMPRESSIONS
        return known and start <= end and packed == length - _CHUNK.size - name - 8
    if opcode == Opcode.MESSAGE_INDEX and length >= _INDEX.size:
        entries = _INDEX.unpack_from(body)[1]
        return bool(entries == length - _INDEX.size and entries % 16 == 0)
    if opcode == Opcode.SCHEMA and length >= 14:
        return 2 + 4 + int.from_bytes(body[2:6], "little") <= length
    if opcode == Opcode.CHANNEL and length >= 16:
        return 4 + 4 + int.from_bytes(body[4:8], "little") <= length
    if opcode == Opcode.MESSAGE and length >= MESSAGE_HEAD:
        return body[13] < 0x80 and body[21] < 0x80  # times fit 63 bits
    return (opcode, length) in ((Opcode.DATA_END, 4), (Opcode.FOOTER, FOOTER_LENGTH))
