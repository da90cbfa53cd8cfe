"""Division of samples into the chunks of the canonical log, and merging of streams by time."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence

import numpy as np

from frictool.logs.canonical.mcap_layout import NS, message_dtype
from frictool.logs.stream_source import SampleBlock

# ns of a chunk, 0.25 MB at 1 kHz: many small chunks slow down writing and reading
CHUNK_NS = 4 * NS
CHUNK_BYTES = 4_000_000  # maximum bytes of a chunk; a fast log has several chunks in CHUNK_NS


def chunked(pieces: Iterator[SampleBlock]) -> Iterator[SampleBlock]:
    """Yield the samples of a stream in chunks that each cover at most CHUNK_NS of time.

    A chunk that is larger than CHUNK_BYTES is divided.
    """
    pending: list[SampleBlock] = []  # parts of the current chunk
    # number of samples that still fit into the chunk; its end [ns]; largest number of its samples
    left = end = rows = 0
    start: int | None = None
    for piece in pieces:
        low = 0
        size = piece.time.size
        if start is None:
            start = int(piece.time[0])
            rows = max(1, CHUNK_BYTES // message_dtype(len(piece.values)).itemsize)
        while low < size:
            if not pending:
                left = rows
                end = start + ((int(piece.time[low]) - start) // CHUNK_NS + 1) * CHUNK_NS
            high = min(int(piece.time.searchsorted(end)), low + left)
            if high > low:
                pending.append(piece.part(low, high))
            left -= high - low
            if high < size or not left:
                yield join_blocks(pending)
                pending = []
            low = high
    if pending:
        yield join_blocks(pending)


def join_blocks(parts: Sequence[SampleBlock]) -> SampleBlock:
    """Join consecutive blocks of one stream into one block."""
    if len(parts) == 1:
        return parts[0]
    values = tuple(
        np.concatenate(vectors) for vectors in zip(*(part.values for part in parts), strict=True)
    )
    return SampleBlock(np.concatenate([part.time for part in parts]), values)


def merged(streams: Sequence[Iterator[SampleBlock]]) -> Iterator[tuple[int, SampleBlock]]:
    """Yield (stream index, block) of all streams, in the order of the first time in each block."""
    waiting: list[tuple[int, int, SampleBlock]] = []
    for index, stream in enumerate(streams):
        _push(waiting, index, stream)
    while waiting:
        _, index, piece = heapq.heappop(waiting)
        yield index, piece
        _push(waiting, index, streams[index])


def _push(
    waiting: list[tuple[int, int, SampleBlock]], index: int, stream: Iterator[SampleBlock]
) -> None:
    piece = next(stream, None)
    if piece is not None:
        heapq.heappush(waiting, (int(piece.time[0]), index, piece))
