"""Kinds and byte positions of consecutive records in memory, as in an MCAP chunk."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.logs.canonical.mcap_layout import RECORD_HEAD

SHORTEST = 14  # bytes, shortest body of a schema, channel or message, the only records of a chunk
MOST_SHORT = 100_000  # maximum number of records with a shorter body that are read
_HEAD = struct.Struct("<BQ")
_LENGTH = struct.Struct("<Q")


class RecordBounds(NamedTuple):
    """Kinds and byte positions of n consecutive records.

    opcode: kind of each record (n,).
    start: index in the data of the first byte of each record's body (n,).
    length: length of each record's body in bytes (n,).
    """

    opcode: NDArray[np.uint8]
    start: NDArray[np.int64]
    length: NDArray[np.int64]

    def first(self, n: int) -> RecordBounds:
        """Return the first `n` records."""
        return RecordBounds(self.opcode[:n], self.start[:n], self.length[:n])


def record_bounds(data: bytes) -> RecordBounds:
    """Return the bounds of the records of a chunk; raise ValueError at an invalid record."""
    bounds, end = whole_records(data)
    if end != len(data):
        if end < len(data) and not data[end]:
            raise ValueError(
                f"found a record of kind 0 at byte {end} of the chunk; allowed: 1 and above"
            )
        if int((bounds.length < SHORTEST).sum()) >= MOST_SHORT:
            raise ValueError(
                f"more than {MOST_SHORT} records of a chunk are shorter than {SHORTEST} bytes"
            )
        raise ValueError(
            f"a record is longer than the {len(data) - end} bytes that remain of its chunk"
        )
    return bounds


def whole_records(data: bytes) -> tuple[RecordBounds, int]:
    """Return the bounds of the records before the first invalid or incomplete record.

    The second result is the index of the byte after the last of these records. The search stops
    after MOST_SHORT records that are shorter than SHORTEST.
    """
    uniform = _uniform(data)
    if uniform is not None:
        return uniform, len(data)
    begins = []
    position = 0
    last = len(data) - RECORD_HEAD
    length_at = _LENGTH.unpack_from
    short = 0
    while position <= last and data[position]:
        length = length_at(data, position + 1)[0]
        end = position + RECORD_HEAD + length
        if end > len(data):
            break
        if length < SHORTEST:
            short += 1
            if short > MOST_SHORT:
                break
        begins.append(position)
        position = end
    heads = np.array(begins, np.int64)
    lengths = np.diff(heads, append=position) - RECORD_HEAD
    return RecordBounds(
        np.frombuffer(data, np.uint8)[heads], heads + RECORD_HEAD, lengths
    ), position


def _uniform(data: bytes) -> RecordBounds | None:
    if len(data) < RECORD_HEAD:
        return None
    opcode, length = _HEAD.unpack_from(data)
    if not opcode or length < SHORTEST:
        return None
    step = RECORD_HEAD + length
    if len(data) % step:
        return None
    heads = np.ndarray((len(data) // step, RECORD_HEAD), np.uint8, data, strides=(step, 1))
    if not (heads == heads[0]).all():
        return None
    count = heads.shape[0]
    starts = np.arange(count, dtype=np.int64) * step + RECORD_HEAD
    return RecordBounds(np.full(count, opcode, np.uint8), starts, np.full(count, length, np.int64))
