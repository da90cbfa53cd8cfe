"""MATLAB files of version 4 to 7: vectors are columns, whatever lies beside them. scipy is the
reference."""

from __future__ import annotations

import struct
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.bench import Column
from frictool.errors import LogError
from frictool.logs.arrays import mat_format
from frictool.logs.arrays.array_table import ArrayTable
from frictool.logs.log import Log
from frictool.logs.log_assembly import LogAssembly, add_tables
from frictool.logs.log_assembly import assemble_log as whole_log
from frictool.logs.raw_table import BLOCK_ROWS, DataLoss
from tests.logs.tables import columns
from tests.support.example_logs import GOLDEN, bench, measured

CONTENTS = {
    "t": np.arange(4.0) / 1000.0,
    "counts": np.array([[1], [2], [3], [-4]], dtype=np.int16),
    "gtau": 35.15,
    "matrix": np.arange(12.0).reshape(4, 3),
    "note": "a text",
    "z": np.array([1j, 2.0]),
    "data": {
        "time": np.arange(4.0),
        "signals": {"values": np.arange(8.0).reshape(4, 2), "label": "speed"},
    },
    "runs": np.array(
        [(np.arange(3.0), 1), (np.arange(3.0) + 5, 2)], dtype=[("x", "O"), ("n", "O")]
    ),
    "cells": np.array([np.arange(4), "text"], dtype=object),
}


def table_of(path: Path) -> ArrayTable:
    (table,) = mat_format.tables(path)
    assert isinstance(table, ArrayTable)
    return table


@pytest.fixture(params=[True, False], ids=["compressed", "plain"])
def path(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    file = tmp_path / "bench.mat"
    scipy.io.savemat(file, CONTENTS, do_compression=request.param, oned_as="column")
    return file


def test_vectors_become_columns(path: Path):
    table = table_of(path)
    found = columns(table, ["t", "counts"])
    assert found["t"].tolist() == [0.0, 0.001, 0.002, 0.003]
    assert found["counts"].tolist() == [1, 2, 3, -4]
    assert table.line(0) is None


def test_matrices_structures_and_cells_by_their_path(path: Path):
    table = table_of(path)
    assert table.names == (
        *("t", "counts", "matrix(:,1)", "matrix(:,2)", "matrix(:,3)", "data.time"),
        *(
            "data.signals.values(:,1)",
            "data.signals.values(:,2)",
            "runs(1).x",
            "runs(2).x",
            "cells{1}",
        ),
    )
    found = columns(table, ["matrix(:,2)", "data.signals.values(:,2)", "cells{1}"])
    assert found["matrix(:,2)"].tolist() == [1, 4, 7, 10]
    assert found["data.signals.values(:,2)"].tolist() == [1, 3, 5, 7]
    assert found["cells{1}"].tolist() == [0, 1, 2, 3]
    assert columns(table, ["runs(2).x"])["runs(2).x"].tolist() == [5, 6, 7]


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ("gtau", "variable 'gtau' is a 1x1 double; allowed: a real vector, here t, counts"),
        ("matrix", "variable 'matrix' is a 4x3 double"),
        ("note", "variable 'note' is a 1x6 char"),
        ("data", "variable 'data' is a 1x1 struct"),
        ("z", "variable 'z' is a 2x1 complex double"),
    ],
)
def test_what_is_no_column_is_said(path: Path, wanted: str, message: str):
    with pytest.raises(LogError, match=message):
        table_of(path).find(wanted)


def test_columns_are_found_as_matlab_and_as_numpy_count(path: Path):
    table = table_of(path)
    assert table.find(1) == "t"
    assert (
        table.find("matrix(:, 2)")
        == table.find("matrix[:, 1]")
        == table.find("matrix[:,1]")
        == "matrix(:,2)"
    )
    assert table.find("data.signals.values[:, 0]") == "data.signals.values(:,1)"
    assert table.find("matrix(:,4)") is None
    assert table.find("matrix[:,3]") is None
    assert table.find("nothing") is None


def test_a_matrix_wider_than_high_has_rows(tmp_path: Path):
    """As Simulink's To File writes it: time in the first row."""
    wide = np.vstack([np.arange(100.0), np.arange(100.0) ** 2])
    scipy.io.savemat(tmp_path / "x.mat", {"ans": wide})
    found = columns(table_of(tmp_path / "x.mat"))
    assert list(found) == ["ans(1,:)", "ans(2,:)"]
    assert np.array_equal(found["ans(2,:)"], wide[1])


def test_columns_of_other_lengths_are_named(path: Path):
    with pytest.raises(LogError, match=r"'t' has 4 samples, 'runs\(1\)\.x' has 3"):
        columns(table_of(path), ["t", "runs(1).x"])


def test_no_vector_at_all(tmp_path: Path):
    scipy.io.savemat(tmp_path / "x.mat", {"a": 1.0, "b": "text"})
    with pytest.raises(
        LogError, match=r"has no real numeric vector; found: a \(1x1 double\), b \(1x4 char\)"
    ):
        table_of(tmp_path / "x.mat")


@pytest.mark.parametrize("version", ["4", "5"])
def test_columns_longer_than_a_block(tmp_path: Path, version: str):
    n = 2 * BLOCK_ROWS + 7
    tall = np.random.default_rng(1).normal(size=(n, 3))
    scipy.io.savemat(
        tmp_path / "x.mat",
        {"x": tall, "wide": tall.T},
        format=version,
        do_compression=version == "5",
    )
    found = columns(table_of(tmp_path / "x.mat"))
    for k in range(3):
        assert np.array_equal(found[f"x(:,{k + 1})"], tall[:, k])
        assert np.array_equal(found[f"wide({k + 1},:)"], tall[:, k])


def test_every_cut_is_one_line_and_salvage_gives_what_was_before(path: Path):
    whole = path.read_bytes()
    cut = path.with_name("cut.mat")
    ends = [128]  # a cut between two variables leaves a file that is whole
    while ends[-1] < len(whole):
        ends.append(ends[-1] + 8 + int.from_bytes(whole[ends[-1] + 4 : ends[-1] + 8], "little"))
    assert ends[-1] == len(whole)
    most = 0
    for length in set(range(1, len(whole), 3)) - set(ends[2:]):
        cut.write_bytes(whole[:length])
        with pytest.raises(LogError) as caught:
            columns(table_of(cut), ["t", "counts"])
        assert "\n" not in str(caught.value)
        with suppress(LogError):
            losses: list[DataLoss] = []
            found = columns(table_of(cut), ["t", "counts"], losses)
            assert losses
            assert found["t"].tolist() == [0.0, 0.001, 0.002, 0.003][: found["t"].size]
            most = max(most, found["t"].size)
    assert most == 4


def test_half_a_compressed_variable_is_salvaged(tmp_path: Path):
    """The samples before the cut are those of the whole file, and the others are counted."""
    values = np.random.default_rng(2).normal(size=50_000)
    file = tmp_path / "x.mat"
    scipy.io.savemat(file, {"x": values}, do_compression=True)
    file.write_bytes(file.read_bytes()[:200_000])
    losses: list[DataLoss] = []
    found = columns(table_of(file), ["x"], losses)["x"]
    assert 20_000 < found.size < 30_000
    assert np.array_equal(found, values[: found.size])
    assert [(loss.channels, loss.samples) for loss in losses] == [
        (("x",), 50_000 - found.size)
    ]  # told once


def test_what_is_cut_off_beside_the_columns_is_told(tmp_path: Path):
    file = tmp_path / "x.mat"
    scipy.io.savemat(file, {"x": np.arange(5.0), "unused": np.arange(100.0)})
    file.write_bytes(file.read_bytes()[:-80])
    with pytest.raises(LogError, match="is damaged: a variable at byte"):
        columns(table_of(file), ["x"])
    losses: list[DataLoss] = []
    assert columns(table_of(file), ["x"], losses)["x"].tolist() == [0, 1, 2, 3, 4]
    assert [(loss.channels, loss.samples) for loss in losses] == [((), 0)]


def test_a_wrong_checksum_is_damage(tmp_path: Path):
    file = tmp_path / "x.mat"
    scipy.io.savemat(file, {"x": np.arange(100.0)}, do_compression=True)
    data = bytearray(file.read_bytes())
    data[-1] ^= 1
    file.write_bytes(bytes(data))
    with pytest.raises(
        LogError, match=r"variable 'x' has damaged compressed bytes \(.*incorrect data check"
    ):
        columns(table_of(file), ["x"])


DTYPES = ("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")


@given(
    values=st.lists(st.integers(-(2**52), 2**52), min_size=2, max_size=40),
    dtype=st.sampled_from(DTYPES),
    form=st.sampled_from([("4", False), ("5", False), ("5", True)]),
    column=st.booleans(),
    name=st.sampled_from(["x", "abc", "abcd", "a_long_name_of_31_characters_xyz"]),
)
def test_what_scipy_writes_is_read_as_scipy_reads_it(
    values: list[int], dtype: str, form: tuple[str, bool], column: bool, name: str
):
    vector = np.array(values).astype(dtype)
    name = name[:18] if form[0] == "4" else name
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "x.mat")
        contents: dict[str, Any] = {name: vector, "after": np.arange(3.0)}
        scipy.io.savemat(
            file,
            contents,
            format=form[0],
            do_compression=form[1],
            oned_as="column" if column else "row",
        )
        reference = scipy.io.loadmat(file)[name].ravel()
        table = table_of(file)
        assert table.names == (name, "after")
        assert np.array_equal(columns(table, [name])[name], reference.astype(float))
        assert columns(table, ["after"])["after"].tolist() == [0.0, 1.0, 2.0]


@pytest.mark.parametrize("compressed", [True, False])
def test_no_flipped_bit_raises_anything_but_the_one_line(tmp_path: Path, compressed: bool):
    """And in a compressed variable none passes: the checksum tells."""
    file = tmp_path / "flip.mat"
    contents = {"t": np.arange(20.0), "x": np.arange(20.0) ** 2}
    scipy.io.savemat(file, contents, do_compression=compressed)
    whole = file.read_bytes()
    passed = 0
    for position in range(128 if compressed else 0, len(whole)):
        for bit in (0, 7):
            data = bytearray(whole)
            data[position] ^= 1 << bit
            file.write_bytes(bytes(data))
            with suppress(LogError):
                found = columns(table_of(file), ["t", "x"])
                assert not compressed or all(
                    np.array_equal(found[name], contents[name]) for name in contents
                )
                passed += 1
    assert compressed or passed >= 2 * 124  # the text at the head of the file means nothing


def test_a_length_beyond_the_file_is_refused_before_it_is_allocated(path: Path):
    data = bytearray(path.read_bytes())
    data[132:136] = b"\xff\xff\xff\xff"
    path.write_bytes(bytes(data))
    with pytest.raises(LogError, match=r"declares 4294967295 bytes|are missing"):
        columns(table_of(path), ["t"])


@pytest.mark.parametrize("version", ["v4_big_endian", "v4", "v5"])
def test_golden_files(version: str):
    """Written byte by byte from the format's description (tests/logs/golden/make_mat.py)."""
    path = GOLDEN / f"{version}.mat"
    assert mat_format.sniff(path.read_bytes()[:4096], path)
    table = table_of(path)
    found = columns(table)
    assert found["t"].tolist() == [0.0, 0.5, 1.0]
    assert found["counts"].tolist() == [-1.0, 2.0, 300.0]


def test_an_object_of_matlab_is_named(tmp_path: Path):
    """A timeseries, as MATLAB lays it out: flags of class 17, then name, system, class."""
    text = b"".join(
        struct.pack("<II", 1, len(one)) + one + bytes(-len(one) % 8)
        for one in (b"speed", b"MCOS..", b"timeseries")
    )
    content = struct.pack("<IIII", 6, 8, 17, 0) + text
    data = (GOLDEN / "v5.mat").read_bytes() + struct.pack("<II", 14, len(content)) + content
    (tmp_path / "x.mat").write_bytes(data)
    table = table_of(tmp_path / "x.mat")
    assert columns(table, ["t"])["t"].size == 3
    with pytest.raises(
        LogError, match="'speed' is a timeseries: an object; save its times and values as vectors"
    ):
        table.find("speed")


def test_the_measured_record():
    table = table_of(measured("emps/DATA_EMPS.mat"))
    assert columns(table, ["t", "qm", "vir"])["qm"].shape == (24841,)
    assert set(table.names) == {"qg", "qm", "t", "vir"}


def test_a_channel_that_lies_behind_a_cut_is_lost_and_the_others_are_kept(tmp_path: Path):
    time, position = np.arange(100) / 1000.0, np.sin(np.arange(100.0))
    whole = tmp_path / "whole.mat"
    scipy.io.savemat(whole, {"t": time, "q": position, "i": position})
    cut = tmp_path / "cut.mat"
    cut.write_bytes(whole.read_bytes()[:1500])
    columns = {
        name: Column(column, unit)
        for name, column, unit in (
            ("time", "t", "s"),
            ("position", "q", "rad"),
            ("current", "i", "A"),
        )
    }
    with pytest.raises(LogError, match=r"is damaged: .*; not readable: 'i'"):
        assemble_whole(cut, columns, salvage=False)
    log, losses = assemble_whole(cut, columns, salvage=True)
    kept = log.main.time.size
    assert 0 < kept < 100
    assert np.array_equal(log.main.time, time[:kept])
    assert np.array_equal(log.main.signals["position"], position[:kept])
    assert list(log.main.signals) == ["position"]
    assert {path: loss.samples for loss in losses for path in loss.channels} == {
        "/axis.current": None,
        "/axis.position": 100 - kept,
    }
    cut.write_bytes(whole.read_bytes()[:900])  # no channel is left
    with pytest.raises(LogError, match="not readable: 'q'"):
        assemble_whole(cut, columns, salvage=True)


def test_a_zero_behind_a_cut_is_lost_with_its_channel_and_one_that_is_cut_is_told(tmp_path: Path):
    time, drive = np.arange(100) / 1000.0, 2.0 + np.sin(np.arange(100.0))
    whole, cut = tmp_path / "whole.mat", tmp_path / "cut.mat"
    scipy.io.savemat(whole, {"t": time, "i": drive, "q": time})
    columns = {
        "time": Column("t", "s"),
        "current": Column("i", "A", zero_first_samples=60),
        "position": Column("q", "rad", zero_first_samples=5),
    }
    cut.write_bytes(whole.read_bytes()[:1400])
    with pytest.raises(LogError, match=r"is damaged: .*; not readable: 'q'"):
        assemble_whole(cut, columns, salvage=False)
    log, losses = assemble_whole(cut, columns, salvage=True)
    assert "position" not in log.main.signals
    kept = log.main.time.size
    assert 0 < kept < 60
    assert np.allclose(
        log.main.signals["current"], drive[:kept] - drive[:kept].mean(), rtol=0.0, atol=1e-15
    )
    reasons = {loss.reason.partition(":")[0]: (loss.channels, loss.samples) for loss in losses}
    assert reasons.pop("is damaged") == (("/axis.position",), None)
    assert reasons.pop(f"its zero is the mean of {kept} samples instead of 60") == (
        ("/axis.current",),
        0,
    )
    assert [samples for _, samples in reasons.values()] == [100 - kept]


def assemble_whole(
    path: Path, columns: dict[str, Column], salvage: bool
) -> tuple[Log, list[DataLoss]]:
    made = LogAssembly(salvage=salvage)
    add_tables(made, mat_format.tables(path), bench(columns))
    return whole_log(made), made.losses
