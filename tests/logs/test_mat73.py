"""MATLAB 7.3: the names and shapes of the older versions, from HDF5; h5py writes, as MATLAB lays it
out."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis.extra import numpy as arrays_of

from frictool.errors import LogError
from frictool.logs.arrays import mat73_format
from frictool.logs.raw_table import BLOCK_ROWS, DataLoss
from tests.logs.tables import columns, one_line
from tests.support.example_logs import GOLDEN

h5py = pytest.importorskip("h5py")
PATH = GOLDEN / "v73.mat"


def test_the_golden_file():
    assert mat73_format.sniff(PATH.read_bytes()[:4096], PATH)
    (table,) = mat73_format.tables(PATH)
    assert set(table.names) == {
        *("t", "counts", "matrix(:,1)", "matrix(:,2)", "data.time"),
        *("cells{1}", "cells{2}", "runs(1).x", "runs(2).x"),
    }
    found = columns(table)
    assert found["counts"].tolist() == [-1, 2, 300, 7]
    assert found["matrix(:,2)"].tolist() == [4, 5, 6, 7]
    assert found["cells{2}"].tolist() == found["runs(2).x"].tolist() == [5.0, 5.5, 6.0, 6.5]
    assert table.find("matrix[:, 1]") == "matrix(:,2)"


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ("gain", "'gain' is 1x1 double; allowed: real numbers"),
        ("note", "'note' is 1x2 char"),
        ("series", "'series' is timeseries: an object; save its times and values as vectors"),
    ],
)
def test_what_is_no_column_is_said(wanted: str, message: str):
    (table,) = mat73_format.tables(PATH)
    with pytest.raises(LogError, match=message):
        table.find(wanted)


def test_other_files_are_not_followed():
    (table,) = mat73_format.tables(PATH)
    assert table.find("elsewhere") is None


@settings(max_examples=8)
@given(
    arrays_of.arrays(
        np.float64,
        arrays_of.array_shapes(min_dims=2, max_dims=2, max_side=6),
        elements={"allow_nan": False},
    )
)
def test_matrices_are_read_as_matlab_has_them(matrix: np.ndarray):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "x.mat")
        with h5py.File(file, "w", userblock_size=512) as opened:
            opened.create_dataset("x", data=matrix.T).attrs["MATLAB_class"] = np.bytes_("double")
            opened.create_dataset("plain", data=np.arange(4.0))
        (table,) = mat73_format.tables(file)
        for name in set(table.names) - {"plain"}:
            before, _, after = name.removeprefix("x").strip("()").partition(",")
            wanted = (
                matrix.ravel()
                if name == "x"
                else matrix[:, int(after) - 1]
                if before == ":"
                else matrix[int(before) - 1]
            )
            assert np.array_equal(columns(table, [name])[name], wanted)


def test_longer_than_a_block_and_a_damaged_chunk(tmp_path: Path):
    file = tmp_path / "x.mat"
    values = np.random.default_rng(1).normal(size=3 * BLOCK_ROWS)
    with h5py.File(file, "w", userblock_size=512) as opened:
        dataset = opened.create_dataset(
            "x", data=values, chunks=(1000,), compression="gzip", fletcher32=True
        )
        place = dataset.id.get_chunk_info(150).byte_offset
    (table,) = mat73_format.tables(file)
    assert np.array_equal(columns(table)["x"], values)
    data = bytearray(file.read_bytes())
    data[512 + place + 3000] ^= 1
    file.write_bytes(bytes(data))
    (table,) = mat73_format.tables(file)
    with pytest.raises(
        LogError, match=f"is damaged after {2 * BLOCK_ROWS} of {values.size} samples"
    ):
        columns(table)
    losses: list[DataLoss] = []
    assert np.array_equal(columns(table, None, losses)["x"], values[: 2 * BLOCK_ROWS])
    assert [loss.samples for loss in losses] == [BLOCK_ROWS]


@pytest.mark.parametrize("count", [5, pytest.param(25, marks=pytest.mark.accept)])
def test_every_damage_is_one_line(count: int, tmp_path: Path):
    whole, file = PATH.read_bytes(), tmp_path / "x.mat"
    draw = np.random.default_rng(7)
    refused = 0
    for k in range(count):
        data = bytearray(whole[: draw.integers(600, len(whole))] if k % 5 == 0 else whole)
        data[draw.integers(512, len(data))] ^= 0xFF
        file.write_bytes(bytes(data))
        with one_line() as refusals:
            (table,) = mat73_format.tables(file)
            columns(table, ["t", "counts"])
        refused += len(refusals)
    assert refused >= count // 5
