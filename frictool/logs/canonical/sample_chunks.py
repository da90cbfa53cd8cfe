"""Samples on their last way: cut into the chunks of the canonical log, and those of all streams put
in the order of time."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence

import numpy as np

from frictool.logs.canonical.mcap_layout import NS, message_dtype
from frictool.logs.stream_source import SampleBlock

CHUNK_NS = 4 * NS  # a quarter of a megabyte at 1 kHz: many small chunks cost time at both ends
CHUNK_BYTES = 4_000_000  # of a fast log it is several chunks


def chunked(pieces: Iterator[SampleBlock]) -> Iterator[SampleBlock]:
    """The samples of a stream in pieces of CHUNK_NS, counted from its first sample, and of no more
    than CHUNK_BYTES each."""
    held: list[SampleBlock] = []  # of a chunk that is not whole yet,
    left = end = rows = 0  # which takes so many samples more, before so many ns
    start: int | None = None
    for piece in pieces:
        low, size = 0, piece.time.size
        if start is None:
            start, rows = (
                int(piece.time[0]),
                max(1, CHUNK_BYTES // message_dtype(len(piece.values)).itemsize),
            )
        while low < size:
            if not held:
                left, end = (
                    rows,
                    start + ((int(piece.time[low]) - start) // CHUNK_NS + 1) * CHUNK_NS,
                )
            high = min(int(piece.time.searchsorted(end)), low + left)
            if high > low:
                held.append(piece.part(low, high))
            left -= high - low
            if high < size or not left:
                yield join_blocks(held)
                held = []
            low = high
    if held:
        yield join_blocks(held)


def join_blocks(parts: Sequence[SampleBlock]) -> SampleBlock:
    if len(parts) == 1:
        return parts[0]
    values = tuple(
        np.concatenate(vectors) for vectors in zip(*(part.values for part in parts), strict=True)
    )
    return SampleBlock(np.concatenate([part.time for part in parts]), values)


def merged(streams: Sequence[Iterator[SampleBlock]]) -> Iterator[tuple[int, SampleBlock]]:
    """The pieces of all streams, each with the stream's place, in the order of their first times;
    of each, one is read ahead."""
    waiting: list[tuple[int, int, SampleBlock]] = []
    for place, stream in enumerate(streams):
        _push(waiting, place, stream)
    while waiting:
        _, place, piece = heapq.heappop(waiting)
        yield place, piece
        _push(waiting, place, streams[place])


def _push(
    waiting: list[tuple[int, int, SampleBlock]], place: int, stream: Iterator[SampleBlock]
) -> None:
    piece = next(stream, None)
    if piece is not None:
        heapq.heappush(waiting, (int(piece.time[0]), place, piece))
