"""The walk that all readers of MCAP share: bytes with their CRC, chunks opened ahead of who reads,
vectors that grow."""

from __future__ import annotations

import io
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.writer import CompressionType

from frictool.logs.canonical import crc_reader, mcap_sections
from frictool.logs.canonical.crc_reader import CountedBytes
from frictool.logs.canonical.growing_vector import GrowingVector
from frictool.logs.canonical.mcap_chunk import chunk_data
from frictool.logs.canonical.mcap_records import FileRecord, FileRecords
from frictool.logs.canonical.mcap_sections import FileSection, contents
from tests.support.recordings import float64s, in_order, joint_states, ros2_mcap

SENT = in_order(joint_states(np.arange(300.0).tolist()), float64s(np.arange(300.0).tolist()))
CODECS = (CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD)


def walked(data: bytes, only: frozenset[int] | None = None) -> list[FileRecord | FileSection]:
    return [item for item, _ in contents(FileRecords(io.BytesIO(data), len(data)), only)]


def chunk_records(data: bytes) -> list[FileRecord]:
    return [
        item
        for item in FileRecords(io.BytesIO(data), len(data))
        if isinstance(item, FileRecord) and item.opcode == Opcode.CHUNK
    ]


def parts(items: list[FileRecord | FileSection]) -> list[FileSection]:
    """Each chunk by itself."""
    return [one for item in items if isinstance(item, FileSection) for one in item.joined or [item]]


@pytest.mark.parametrize("codec", CODECS)
@pytest.mark.parametrize(("batch", "ahead"), [(1, 1), (5000, 12_000), (1 << 20, 1 << 24)])
def test_chunks_are_opened_in_their_order(
    monkeypatch: pytest.MonkeyPatch, codec: CompressionType, batch: int, ahead: int
):
    """However many are opened together and ahead: what they hold is what the plain loop finds, and
    so are the indexes behind them."""
    monkeypatch.setattr(mcap_sections, "BATCH_BYTES", batch)
    monkeypatch.setattr(mcap_sections, "AHEAD_BYTES", ahead)
    data = ros2_mcap(SENT, compression=codec, chunk_size=1000)
    wanted = chunk_records(data)
    assert len(wanted) > 20
    items = walked(data)
    assert [(one.at, one.data) for one in parts(items)] == [
        (one.offset, chunk_data(one.body)) for one in wanted
    ]
    runs = [item for item in items if isinstance(item, FileSection)]
    assert all(
        item.data == b"".join(one.data for one in item.joined) for item in runs if item.joined
    )
    assert (len(runs) < len(wanted)) == (batch > 1)
    counts = sum(times.size for one in parts(items) for _, times in one.indexed())
    assert counts == len(SENT)


def test_a_chunk_that_cannot_be_opened_stands_in_its_place():
    data = ros2_mcap(SENT, compression=CompressionType.ZSTD, chunk_size=1000)
    wanted = chunk_records(data)
    damaged = bytearray(data)
    for lost in wanted[3::7]:
        damaged[lost.offset + 100] ^= 0x55
    found = parts(walked(bytes(damaged)))
    assert [one.at for one in found if one.whole] == [one.offset for one in wanted]
    for one in found[: len(wanted)]:
        assert bool(one.reason) == (one.at in {lost.offset for lost in wanted[3::7]})
        assert one.reason or one.data == chunk_data(
            next(record.body for record in wanted if record.offset == one.at)
        )
        assert one.indexed()


def test_only_the_chunks_that_are_wanted_are_opened():
    data = ros2_mcap(SENT, compression=CompressionType.ZSTD, chunk_size=1000)
    some = frozenset(one.offset for one in chunk_records(data)[::3])
    assert {one.at for one in parts(walked(data, some))} == some


def test_who_stops_reading_leaves_nothing_behind():
    """The walk is closed in the midst of a file: its thread ends."""
    data = ros2_mcap(SENT, compression=CompressionType.ZSTD, chunk_size=1000)
    walk = contents(FileRecords(io.BytesIO(data), len(data)))
    next(walk)
    worker = next(cell for name, cell in walk.gi_frame.f_locals.items() if name == "worker")
    walk.close()
    with pytest.raises(RuntimeError, match="after shutdown"):
        worker.submit(print)


@given(
    data=st.binary(max_size=400),
    steps=st.lists(
        st.tuples(st.sampled_from(["take", "peek", "crc", "begin", "step"]), st.integers(0, 90)),
        max_size=30,
    ),
)
def test_bytes_and_their_crc_are_those_of_a_plain_read(data: bytes, steps: list[tuple[str, int]]):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(crc_reader, "PIECE", 32)
        ours = CountedBytes(io.BytesIO(data), len(data))
        at, begun = 0, 0
        counted = True
        for step, number in steps:
            if step == "take":
                assert ours.take(number) == data[at : at + number]
                at = min(at + number, len(data))
            elif step == "peek":
                assert ours.peek(number % 33) == data[at : at + number % 33]
            elif step == "crc":
                assert ours.crc() == (zlib.crc32(data[begun:at]) if counted else None)
            elif step == "begin":
                ours.begin_crc()
                begun, counted = at, True
            else:
                at = min(number, len(data))
                ours.step_to(at)
                counted = False
            assert ours.offset == at


@given(
    sizes=st.lists(st.integers(0, 40), max_size=20),
    most=st.integers(0, 500),
    shares=st.floats(0.001, 1.0),
)
def test_a_vector_that_grows_is_its_parts_joined(sizes: list[int], most: int, shares: float):
    """The result does not depend on the size that the file seems to need."""
    pieces = [np.arange(size, dtype=np.int64) + 100 * place for place, size in enumerate(sizes)]
    vector = GrowingVector(np.int64, most)
    for piece in pieces:
        vector.append(piece, shares)
    assert np.array_equal(vector.whole(), np.concatenate([np.empty(0, np.int64), *pieces]))
