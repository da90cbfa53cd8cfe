"""Records and sections of messages of any MCAP file, in order.

FileRecords ──▶ FileRecord, FileSection, FileSection, FileRecord, ...
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from frictool.logs.canonical.mcap_chunk import chunk_data, chunk_prefix, plain_size
from frictool.logs.canonical.mcap_declarations import UNREADABLE
from frictool.logs.canonical.mcap_records import (
    DamagedBytes,
    FileRecord,
    FileRecords,
    LooseMessages,
)
from frictool.logs.unpacked_size import UnpackedBudget

BATCH_BYTES = 1 << 20  # uncompressed bytes that are passed between the threads as one batch
AHEAD_BYTES = 1 << 24  # uncompressed bytes that may wait for the reader; a chunk may be larger
INDEX_BYTES = 1 << 26  # bytes of indexes kept per chunk
_INDEX = struct.Struct("<HI")  # channel, bytes of entries


@dataclass
class FileSection:
    """Readable or unreadable section of messages at byte `at` of the file.

    data: consecutive records.
    reason: why a part of the section cannot be read; "" if the whole section can be read.
    whole: True if `data` is the complete content of one or several chunks. An invalid record then
        makes all records doubtful, because the position of a record follows from the lengths of the
        earlier records.
    empty: True if the unreadable part contained no message.
    packed: compressed content of a chunk, or the beginning of this content, before decompression.
    joined: consecutive chunks whose records are joined in `data`.
    indexes: bodies of the message index records after the chunk.
    """

    at: int
    data: bytes = b""
    reason: str = ""
    whole: bool = False
    empty: bool = False
    packed: bytes = b""
    joined: list[FileSection] = field(default_factory=list)
    indexes: list[bytes] = field(default_factory=list)

    def indexed(self) -> list[tuple[int, NDArray[np.int64]]]:
        """Return (channel, message times (n,) in ns) for each message index after the chunk."""
        return [
            (
                _INDEX.unpack_from(body)[0],
                np.frombuffer(body, "<u8", offset=_INDEX.size)[::2].astype(np.int64),
            )
            for body in self.indexes
        ]


def contents(
    records: FileRecords, only: frozenset[int] | None = None
) -> Iterator[tuple[FileRecord | FileSection, int]]:
    """Yield all records and sections in order, each with the byte position of its end.

    only: byte offsets of the chunks to decompress; None for all chunks.
    """
    worker = ThreadPoolExecutor(1)
    waiting: deque[tuple[Future[list[tuple[FileRecord | FileSection, int]]], int]] = deque()
    buffered = 0
    try:
        for batch, size in _batches(_parts(records, only), UnpackedBudget(records.size)):
            while waiting and (waiting[0][0].done() or buffered + size > AHEAD_BYTES):
                first, freed = waiting.popleft()
                buffered -= freed
                yield from first.result()
            waiting.append((worker.submit(_opened, batch), size))
            buffered += size
        while waiting:
            yield from waiting.popleft()[0].result()
    finally:
        worker.shutdown(cancel_futures=True)


def _parts(
    records: FileRecords, only: frozenset[int] | None
) -> Iterator[tuple[FileRecord | FileSection, int]]:
    part = None
    end = 0
    kept = 0
    over = False
    for item in records:
        if part is not None:
            if isinstance(item, FileRecord) and item.opcode == Opcode.MESSAGE_INDEX:
                kept += len(item.body)
                if kept <= INDEX_BYTES:
                    part.indexes.append(item.body)
                end = records.offset
                continue
            yield part, end
        part = None
        end = records.offset
        kept = 0
        if isinstance(item, LooseMessages):
            part = FileSection(item.offset, item.data, empty=over)
        elif isinstance(item, DamagedBytes):
            part = FileSection(
                item.start, reason=item.reason, empty=over or item.bare, packed=item.rest
            )
        elif item.opcode == Opcode.CHUNK:
            if only is None or item.offset in only:
                part = FileSection(item.offset, whole=True, empty=over, packed=item.body)
        elif item.opcode != Opcode.MESSAGE_INDEX:
            over |= item.opcode == Opcode.DATA_END
            yield item, end
    if part is not None:
        yield part, end


def _batches(
    parts: Iterable[tuple[FileRecord | FileSection, int]], budget: UnpackedBudget
) -> Iterator[tuple[list[tuple[FileRecord | FileSection, int]], int]]:
    """Yield batches of records and sections; each batch comes with its unpacked size in bytes.

    A large chunk is a batch by itself. A chunk is not unpacked if it exceeds what remains of
    the limit of unpacked bytes.
    """
    batch: list[tuple[FileRecord | FileSection, int]] = []
    buffered = 0
    for item, end in parts:
        if (
            isinstance(item, FileSection)
            and item.packed
            and (reason := budget.take(plain_size(item.packed)))
        ):
            item.reason = item.reason or reason
            item.packed = b""
        size = (
            len(item.data) + len(item.packed) + plain_size(item.packed)
            if isinstance(item, FileSection)
            else len(item.body)
        )
        if batch and buffered + size > BATCH_BYTES:
            yield batch, buffered
            batch = []
            buffered = 0
        batch.append((item, end))
        buffered += size
    if batch:
        yield batch, buffered


def _opened(
    batch: list[tuple[FileRecord | FileSection, int]],
) -> list[tuple[FileRecord | FileSection, int]]:
    opened: list[tuple[FileRecord | FileSection, int]] = []
    run: list[FileSection] = []
    end = 0
    for item, item_end in batch:
        if isinstance(item, FileSection) and item.packed:
            _open(item)
        if isinstance(item, FileSection) and item.whole and not item.reason:
            run.append(item)
            end = item_end
            continue
        if run:
            opened.append((_joined(run), end))
            run = []
        opened.append((item, item_end))
    return [*opened, (_joined(run), end)] if run else opened


def _open(part: FileSection) -> None:
    try:
        part.data = chunk_data(part.packed) if part.whole else chunk_prefix(part.packed)
    except UNREADABLE as error:
        part.reason = part.reason or f"a chunk cannot be read ({error_text(error)})"
    part.packed = b""


def _joined(run: list[FileSection]) -> FileSection:
    return (
        run[0]
        if len(run) == 1
        else FileSection(run[0].at, b"".join([part.data for part in run]), whole=True, joined=run)
    )


def error_text(error: Exception) -> str:
    """Return the text of an error for a message, or the name of its class if it has no text."""
    if isinstance(error, UnicodeDecodeError):
        return "a text is not UTF-8"
    return str(error) or type(error).__name__
