"""An MCAP file of any kind as what it declares and where its messages are, in the order of the
file: the one walk of all readers.

    FileRecords ──▶ Record, Part, Part, Record, ...

Chunks are decompressed, and their CRCs checked, by a thread that runs some megabytes ahead of who
reads.
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

BATCH_BYTES = (
    1 << 20
)  # of plain records: chunks of a slow log are small, and each batch costs a change of threads
AHEAD_BYTES = 1 << 24  # that wait at most, unless one chunk alone has more
INDEX_BYTES = 1 << 26  # of indexes behind a chunk that are kept
_INDEX = struct.Struct("<HI")  # channel, bytes of entries


@dataclass
class FileSection:
    """Where messages are, or were, at byte `at`.

    data: records that follow one another. whole: they are all that a chunk holds, so that one that
    does not fit makes all of it doubtful. reason: why something here cannot be read; "" where all
    can. empty: no message was in what cannot be read.
    """

    at: int
    data: bytes = b""
    reason: str = ""
    whole: bool = False
    empty: bool = False
    packed: bytes = b""  # of a chunk, or of its beginning, that is not opened yet
    joined: list[FileSection] = field(
        default_factory=list
    )  # chunks that follow one another, where `data` is that of them all
    indexes: list[bytes] = field(default_factory=list)  # bodies of the records behind it

    def indexed(self) -> list[tuple[int, NDArray[np.int64]]]:
        """By the indexes behind a chunk: channel, and the times (n,) of its messages, in ns."""
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
    """Everything in its order, each with the bytes of the file up to its end. Raises OSError.

    only: bytes where chunks begin that are opened; None opens all.
    """
    worker = ThreadPoolExecutor(1)
    waiting: deque[tuple[Future[list[tuple[FileRecord | FileSection, int]]], int]] = deque()
    held = 0
    try:
        for batch, size in _batches(_parts(records, only), UnpackedBudget(records.size)):
            while waiting and (waiting[0][0].done() or held + size > AHEAD_BYTES):
                first, freed = waiting.popleft()
                held -= freed
                yield from first.result()
            waiting.append((worker.submit(_opened, batch), size))
            held += size
        while waiting:
            yield from waiting.popleft()[0].result()
    finally:
        worker.shutdown(cancel_futures=True)


def _parts(
    records: FileRecords, only: frozenset[int] | None
) -> Iterator[tuple[FileRecord | FileSection, int]]:
    """Each part with the indexes behind it."""
    part, end, kept, over = None, 0, 0, False
    for item in records:
        if part is not None:
            if isinstance(item, FileRecord) and item.opcode == Opcode.MESSAGE_INDEX:
                kept += len(item.body)
                if kept <= INDEX_BYTES:
                    part.indexes.append(item.body)
                end = records.offset
                continue
            yield part, end
        part, end, kept = None, records.offset, 0
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
    """Yield batches of parts with their unpacked size in bytes; a large chunk is alone, and one
    beyond the budget stays packed."""
    batch: list[tuple[FileRecord | FileSection, int]] = []
    held = 0
    for item, end in parts:
        if (
            isinstance(item, FileSection)
            and item.packed
            and (reason := budget.take(plain_size(item.packed)))
        ):
            item.reason, item.packed = item.reason or reason, b""
        size = (
            len(item.data) + len(item.packed) + plain_size(item.packed)
            if isinstance(item, FileSection)
            else len(item.body)
        )
        if batch and held + size > BATCH_BYTES:
            yield batch, held
            batch, held = [], 0
        batch.append((item, end))
        held += size
    if batch:
        yield batch, held


def _opened(
    batch: list[tuple[FileRecord | FileSection, int]],
) -> list[tuple[FileRecord | FileSection, int]]:
    """The same, with the chunks opened, and those that follow one another joined: they are taken
    apart at once."""
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
    return str(error) or type(error).__name__
