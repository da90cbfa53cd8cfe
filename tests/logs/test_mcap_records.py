"""The walk through the records of an MCAP file: all of a whole one, and all that a damaged one
still has."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType

from frictool.logs.canonical.mcap_bounds import record_bounds, whole_records
from frictool.logs.canonical.mcap_records import (
    DamagedBytes,
    FileRecord,
    FileRecords,
    LooseMessages,
)
from tests.support.recordings import float64s, in_order, joint_states, ros2_mcap

SENT = in_order(joint_states(np.arange(60.0).tolist()), float64s(np.arange(60.0).tolist()))
CHUNKED = ros2_mcap(SENT, compression=CompressionType.NONE, chunk_size=1000, enable_data_crcs=True)
LOOSE = ros2_mcap(SENT, use_chunking=False, enable_data_crcs=True)
FILES = {"chunked": CHUNKED, "loose": LOOSE}


def walked(data: bytes) -> list[FileRecord | LooseMessages | DamagedBytes]:
    return [*FileRecords(io.BytesIO(data), len(data))]


def records(data: bytes) -> list[FileRecord]:
    """The records of a file; messages outside chunks one by one."""
    found = []
    for item in walked(data):
        if isinstance(item, FileRecord):
            found.append(item)
        elif isinstance(item, LooseMessages):
            for opcode, start, length in zip(
                *(part.tolist() for part in record_bounds(item.data)), strict=True
            ):
                found.append(
                    FileRecord(opcode, item.data[start : start + length], item.offset + start - 9)
                )
    return found


@pytest.mark.parametrize("data", [CHUNKED, LOOSE])
def test_a_whole_file_has_the_records_that_the_library_sees(data: bytes):
    theirs = [
        type(one).__name__ for one in StreamReader(io.BytesIO(data), emit_chunks=True).records
    ]
    ours = [Opcode(opcode).name.title().replace("_", "") for opcode, _, _ in records(data)]
    assert ours == theirs
    assert not [item for item in walked(data) if isinstance(item, DamagedBytes)]


@pytest.mark.parametrize("data", [CHUNKED, LOOSE])
def test_everything_before_a_cut_is_there(data: bytes):
    whole = records(data)
    for cut in range(9, len(data), 37):
        items = walked(data[:cut])
        assert isinstance(items[-1], DamagedBytes)
        found = records(data[:cut])
        assert (
            found[: len(whole)] == whole[: len(found)] or data is CHUNKED
        )  # records of a chunk that was cut come as its messages
        ends = [item.offset + 9 + len(item.body) for item in whole]
        before = [item for item, end in zip(whole, ends, strict=True) if end <= cut]
        assert found[: len(before)] == before
        assert sum(isinstance(item, DamagedBytes) for item in items) == 1 or data is CHUNKED


def test_a_length_that_is_wrong_costs_no_other_chunk():
    """The walk goes on inside the chunk, record by record, or at the next one."""
    chunks = [
        item
        for item in walked(CHUNKED)
        if isinstance(item, FileRecord) and item.opcode == Opcode.CHUNK
    ]
    assert len(chunks) > 8
    for lost in chunks[1:-1:3]:
        for length in (0, 7, 2**40, 2**63, 2**64 - 1, len(lost.body) + 1000):
            damaged = bytearray(CHUNKED)
            damaged[lost.offset + 1 : lost.offset + 9] = struct.pack("<Q", length)
            items = walked(bytes(damaged))
            assert any(isinstance(item, DamagedBytes) for item in items)
            kept = [
                item
                for item in items
                if isinstance(item, FileRecord) and item.opcode == Opcode.CHUNK
            ]
            assert [one.offset for one in kept] == [one.offset for one in chunks if one is not lost]


@pytest.mark.parametrize("name", FILES)
@given(at=st.integers(0, 10**9), flip=st.integers(1, 255))
@example(at=8, flip=3)  # the header becomes a footer, which would end the file
@example(at=10, flip=3)  # the header spans the records after it
def test_a_flipped_byte_is_noticed_and_costs_little(name: str, at: int, flip: int):
    """The data's CRC shows any flipped byte; at most one record, and anything found in its place,
    is lost."""
    data = FILES[name]
    at %= len(data)
    damaged = bytearray(data)
    damaged[at] ^= flip
    items = walked(bytes(damaged))
    crc_off = {
        item.offset + 9 + k
        for item in walked(data)
        if isinstance(item, FileRecord) and item.opcode == Opcode.DATA_END
        for k in range(4)
    }
    assert (
        any(isinstance(item, DamagedBytes) for item in items)
        or at in crc_off
        or at >= len(data) - 12
    )
    whole, found = (
        [(one.opcode, one.body) for one in records(some)] for some in (data, bytes(damaged))
    )
    data_section = whole[
        : [opcode for opcode, _ in whole].index(Opcode.DATA_END)
    ]  # behind it stands again what is in it
    assert len([one for one in data_section if one not in found]) <= 2


def test_a_file_of_zeros_or_noise_is_damage():
    rng = np.random.default_rng(1)
    for data in (
        bytes(3000),
        rng.bytes(3000),
        b"\x89MCAP0\r\n" + rng.bytes(100_000),
        b"\x89MCAP0\r\n",
        b"\x89",
    ):
        assert any(isinstance(item, DamagedBytes) for item in walked(data))


@given(
    st.lists(st.tuples(st.integers(1, 255), st.binary(max_size=40)), max_size=20),
    st.integers(0, 60),
)
def test_bounds_are_those_of_a_plain_walk(parts: list[tuple[int, bytes]], cut: int):
    data = b"".join(struct.pack("<BQ", opcode, len(body)) + body for opcode, body in parts)
    cut = min(cut, len(data))
    bounds, end = whole_records(data[: len(data) - cut])
    wanted, position = [], 0
    for opcode, body in parts:
        if position + 9 + len(body) > len(data) - cut:
            break
        wanted.append((opcode, body))
        position += 9 + len(body)
    found = zip(bounds.opcode.tolist(), bounds.start.tolist(), bounds.length.tolist(), strict=True)
    assert [(opcode, data[start : start + length]) for opcode, start, length in found] == wanted
    assert end == position
    if end != len(data) - cut:
        with pytest.raises(ValueError, match="is longer than"):
            record_bounds(data[: len(data) - cut])


def test_records_of_one_length_are_found_at_once():
    data = (struct.pack("<BQ", 5, 30) + bytes(30)) * 1000
    bounds = record_bounds(data)
    assert bounds.start.tolist() == list(range(9, 39 * 1000, 39))
    assert set(bounds.length.tolist()) == {30}
