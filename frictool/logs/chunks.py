"""Samples on their last way: cut into the chunks of the canonical log, and those of all streams put in the order of time."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from frictool.logs.flow import Samples
from frictool.logs.mcap_layout import NS, message_dtype

CHUNK_BYTES = 4_000_000  # a second of a fast log is several chunks


def chunked(pieces: Iterator[Samples]) -> Iterator[Samples]:
    """The samples of a stream in pieces of a second, counted from its first sample, and of no more than CHUNK_BYTES each."""
    held: list[Samples] = []  # of the second that is not over yet
    start = rows = 0
    for piece in pieces:
        if not held and not rows:
            start = int(piece.time[0])
            rows = max(1, CHUNK_BYTES // message_dtype(len(piece.values)).itemsize)
        held.append(piece)
        first, last = int(held[0].time[0]), int(piece.time[-1])
        if (first - start) // NS == (last - start) // NS and sum(part.time.size for part in held) < rows:
            continue
        *whole, rest = _split(joined(held), start, rows)
        yield from whole
        held = [rest]
    if held:
        yield joined(held)


def _split(samples: Samples, start: int, rows: int) -> list[Samples]:
    seconds = (samples.time - start) // NS
    bounds = [0, *(np.flatnonzero(np.diff(seconds)) + 1).tolist(), samples.time.size]
    return [samples.part(low, min(low + rows, end)) for first, end in itertools.pairwise(bounds) for low in range(first, end, rows)]


def joined(parts: Sequence[Samples]) -> Samples:
    if len(parts) == 1:
        return parts[0]
    values = tuple(np.concatenate(vectors) for vectors in zip(*(part.values for part in parts), strict=True))
    return Samples(np.concatenate([part.time for part in parts]), values)


def merged(streams: Sequence[Iterator[Samples]]) -> Iterator[tuple[int, Samples]]:
    """The pieces of all streams, each with the stream's place, in the order of their first times; of each, one is read ahead."""
    waiting: list[tuple[int, int, Samples]] = []
    for place, stream in enumerate(streams):
        _push(waiting, place, stream)
    while waiting:
        _, place, piece = heapq.heappop(waiting)
        yield place, piece
        _push(waiting, place, streams[place])


def _push(waiting: list[tuple[int, int, Samples]], place: int, stream: Iterator[Samples]) -> None:
    piece = next(stream, None)
    if piece is not None:
        heapq.heappush(waiting, (int(piece.time[0]), place, piece))
