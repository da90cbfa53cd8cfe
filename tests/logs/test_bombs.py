"""Small files that announce far more than any log: refused in one line, before the time or the
memory is spent."""

from __future__ import annotations

import bz2
import io
import json
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import zstandard

from frictool.documents.bench import Column
from frictool.documents.writing import to_yaml
from frictool.logs.unpacked_size import LARGE, SMALL, UnpackedBudget, allowed_bytes
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.example_logs import bench

LONGEST = 10.0  # s of processor time
MCAP = b"\x89MCAP0\r\n"


def _record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def _mcap(plain: bytes, chunks: int) -> bytes:
    packed = zstandard.ZstdCompressor().compress(plain)
    body = (
        struct.pack("<QQQII", 0, 1, len(plain), 0, 4)
        + b"zstd"
        + struct.pack("<Q", len(packed))
        + packed
    )
    return b"".join(
        [
            MCAP,
            _record(1, bytes(8)),
            *[_record(6, body)] * chunks,
            _record(15, bytes(4)),
            _record(2, bytes(20)),
            MCAP,
        ]
    )


def _json(message: dict[str, object]) -> bytes:
    from mcap.writer import Writer

    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start()
    channel = writer.register_channel(
        "/axis", "json", writer.register_schema("Axis", "jsonschema", b"{}")
    )
    for k in range(3):
        writer.add_message(channel, k * 10**6, json.dumps(message).encode(), k * 10**6)
    writer.finish()
    return stream.getvalue()


def _bag(plain: bytes, chunks: int) -> bytes:
    def field(name: bytes, value: bytes) -> bytes:
        return struct.pack("<I", len(name) + 1 + len(value)) + name + b"=" + value

    def record(fields: bytes, data: bytes) -> bytes:
        return struct.pack("<I", len(fields)) + fields + struct.pack("<I", len(data)) + data

    chunk = record(
        field(b"op", b"\x05")
        + field(b"compression", b"bz2")
        + field(b"size", struct.pack("<I", len(plain))),
        bz2.compress(plain),
    )
    head = record(field(b"op", b"\x03") + field(b"index_pos", bytes(8)), b"")
    return b"#ROSBAG V2.0\n" + head + chunk * chunks


def _variables(count: int) -> Iterator[bytes]:
    yield b"MATLAB 5.0".ljust(124) + b"\x00\x01IM"
    for k in range(count):
        name = f"v{k}".encode().ljust(8, b"\0")
        content = (
            struct.pack("<IIII", 6, 8, 6, 0)
            + struct.pack("<IIii", 5, 8, 1, 2)
            + struct.pack("<II", 1, 8)
            + name
        )
        content += struct.pack("<II", 9, 16) + bytes(16)
        yield struct.pack("<II", 14, len(content)) + content


def _filled(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name in ("time", "x"):
            file.create_dataset(
                name, shape=(250_000_000,), dtype="f8", chunks=(1 << 16,), fillvalue=1.0
            )


def _constant_parquet(path: Path) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table({name: pa.array(np.zeros(10_000_000)) for name in ("time", "x")}), path)


def _zeros_npz(path: Path) -> None:
    np.savez_compressed(path.with_suffix(".npz"), time=np.zeros(6_000_000), x=np.zeros(6_000_000))
    path.with_suffix(".npz").rename(path)


def _bytes(data: Callable[[], bytes]) -> Callable[[Path], None]:
    return lambda path: path.write_bytes(data()) and None


BOMBS: dict[str, tuple[Callable[[Path], None], str]] = {
    "mcap zeros": (
        _bytes(lambda: _mcap(bytes(30_000_000), 40)),
        "found a record of kind 0 at byte 0 of the chunk",
    ),
    "mcap private": (
        _bytes(lambda: _mcap((b"\x80" + bytes(8)) * 1_000_000, 40)),
        "records of a chunk are shorter than 14 bytes",
    ),
    "mcap large": (
        _bytes(lambda: _mcap(_record(0x80, bytes(30_000_000)), 400)),
        "unpacks to more than",
    ),
    "json": (
        _bytes(lambda: _json({f"key{k}": k for k in range(150_000)})),
        "bytes of JSON; allowed: at most 2000000",
    ),
    "json texts": (
        _bytes(lambda: _json({f"k{k}": "" for k in range(120_000)} | {"x": 1.0})),
        "more than",
    ),
    "bag": (_bytes(lambda: _bag(bytes(8_000_000), 40)), "has no topic with numbers"),
    "bag large": (_bytes(lambda: _bag(bytes(40_000_000), 4)), "has no topic with numbers"),
    "mat": (_bytes(lambda: b"".join(_variables(20_100))), "has more than 20000 arrays"),
    "hdf5": (_filled, "declares 250000000 rows"),
    "npz": (_zeros_npz, "declares 6000000 rows"),
    "parquet": (_constant_parquet, "declares 10000000 rows"),
}


@pytest.mark.parametrize("name", BOMBS)
def test_what_announces_too_much_is_one_line(name: str, tmp_path: Path):
    write, words = BOMBS[name]
    log, rig, target = tmp_path / "log", tmp_path / "bench.yaml", tmp_path / "out.mcap"
    write(log)
    rig.write_text(to_yaml(bench({"time": Column("time", "s"), "position": Column("x", "rad")})))
    begun = time.process_time()
    refused(run("ingest", log, "--bench", rig, "-o", target), 3, words)
    assert run("ingest", log, "--bench", rig, "--salvage", "-o", target).code == 3
    assert time.process_time() - begun < LONGEST
    assert not target.exists()


def test_large_files_may_grow_less():
    assert allowed_bytes(1) == SMALL
    assert allowed_bytes(1_000_000) == 1000 * 1_000_000
    assert allowed_bytes(100_000_000) == LARGE
    assert allowed_bytes(10 * LARGE) == 200 * LARGE
    budget = UnpackedBudget(1)
    assert budget.take(SMALL) is None
    assert budget.take(1) is not None
