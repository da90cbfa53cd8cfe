"""Parquet: row groups, stamps, units, nested fields; pyarrow writes, and what it was given is the
reference."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.errors import LogError
from frictool.logs.arrays import parquet_format
from frictool.logs.raw_table import BLOCK_ROWS, DataLoss
from tests.logs.tables import columns, one_line, times
from tests.support.example_logs import GOLDEN

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")
PATH = GOLDEN / "stamps.parquet"
EPOCH = 1_700_000_000_123_456_789


def test_the_golden_file():
    assert parquet_format.sniff(PATH.read_bytes()[:4096], PATH)
    (table,) = parquet_format.tables(PATH)
    assert (table.names, table.clock) == (("position", "count", "state.on"), "when")
    assert dict(table.units) == {"position": "rad", "count": None, "state.on": None}
    found = columns(table)
    assert found["position"].tolist() == [0.0, 0.5, 1.0, 1.5]
    assert np.array_equal(found["count"], [-1, 2, 300, np.nan], equal_nan=True)
    assert found["state.on"].tolist() == [0, 1, 0, 1]
    assert times(table).tolist() == [EPOCH + k * 500_000_001 for k in range(4)]


def test_what_is_no_column_is_said():
    (table,) = parquet_format.tables(PATH)
    with pytest.raises(LogError, match=r"'state\.text' is a column of string"):
        table.find("state.text")
    assert table.find("when") is None  # it dates the rows, whether it is asked for or not
    assert table.find(2) == "count"


@settings(max_examples=settings.default.max_examples // 4)
@given(
    st.lists(st.none() | st.integers(-(2**31), 2**31 - 1), min_size=1, max_size=30),
    st.sampled_from(
        [
            pa.int32(),
            pa.int64(),
            pa.float32(),
            pa.float64(),
            pa.decimal128(22, 2),
            pa.duration("us"),
        ]
    ),
    st.integers(1, 30),
    st.sampled_from(["none", "snappy", "zstd", "gzip"]),
)
def test_what_pyarrow_writes_is_read(
    values: list[int | None], kind: pa.DataType, group: int, compression: str
):
    column = pa.array(values, pa.int64() if pa.types.is_duration(kind) else None).cast(
        kind, safe=False
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "x.parquet")
        pq.write_table(
            pa.table({"x": column, "n": np.arange(len(values))}),
            file,
            row_group_size=group,
            compression=compression,
        )
        (table,) = parquet_format.tables(file)
        found = columns(table)
    wanted = [
        np.nan if value is None else np.float32(value) if kind == pa.float32() else value
        for value in values
    ]
    assert np.array_equal(found["x"], np.array(wanted, dtype=float), equal_nan=True)
    assert found["n"].tolist() == list(range(len(values)))
    assert table.units["x"] == ("us" if pa.types.is_duration(kind) else None)


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_stamps_of_every_unit_are_exact(tmp_path: Path, unit: str):
    per = {"s": 10**9, "ms": 10**6, "us": 1000, "ns": 1}[unit]
    stamps = EPOCH // per + np.arange(5)
    pq.write_table(
        pa.table({"when": pa.array(stamps).cast(pa.timestamp(unit)), "x": np.arange(5.0)}),
        tmp_path / "x.parquet",
    )
    (table,) = parquet_format.tables(tmp_path / "x.parquet")
    assert times(table).tolist() == (stamps * per).tolist()


def test_longer_than_a_block(tmp_path: Path):
    values = np.random.default_rng(1).normal(size=2 * BLOCK_ROWS + 7)
    pq.write_table(pa.table({"x": values}), tmp_path / "x.parquet", row_group_size=values.size)
    (table,) = parquet_format.tables(tmp_path / "x.parquet")
    assert np.array_equal(columns(table)["x"], values)


def test_a_damaged_row_group_is_lost_and_the_others_are_read(tmp_path: Path):
    file = tmp_path / "x.parquet"
    values = np.random.default_rng(1).normal(size=3000)
    pq.write_table(
        pa.table({"x": values}),
        file,
        row_group_size=1000,
        write_page_checksum=True,
        compression="none",
        use_dictionary=False,
    )
    data = bytearray(file.read_bytes())
    data[12_000] ^= 1
    file.write_bytes(bytes(data))
    (table,) = parquet_format.tables(file)
    with pytest.raises(LogError, match="row group 2 is damaged"):
        columns(table)
    losses: list[DataLoss] = []
    blocks = [(block.first_row, block.columns["x"]) for block, _ in table.blocks(["x"], losses)]
    assert [first for first, _ in blocks] == [0, 2000]
    assert np.array_equal(
        np.concatenate([part for _, part in blocks]), np.delete(values, slice(1000, 2000))
    )
    assert [loss.samples for loss in losses] == [1000]


def test_a_cut_file_is_one_line(tmp_path: Path):
    (tmp_path / "x.parquet").write_bytes(PATH.read_bytes()[:-9])
    with pytest.raises(
        LogError, match="is cut off: the footer that describes its columns is missing"
    ):
        parquet_format.tables(tmp_path / "x.parquet")


@pytest.mark.parametrize("count", [5, pytest.param(25, marks=pytest.mark.accept)])
def test_every_damage_is_one_line(count: int, tmp_path: Path):
    whole, file = PATH.read_bytes(), tmp_path / "x.parquet"
    draw = np.random.default_rng(7)
    refused = 0
    for _ in range(count):
        data = bytearray(whole)
        data[draw.integers(4, len(data) - 4)] ^= 0xFF
        file.write_bytes(bytes(data))
        with one_line() as refusals:
            (table,) = parquet_format.tables(file)
            columns(table)
        refused += len(refusals)
    assert refused >= 2 * count // 5
