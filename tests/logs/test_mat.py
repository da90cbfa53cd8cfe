"""MATLAB files: vectors are columns, whatever lies beside them."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st

from frictool.errors import LogError
from frictool.logs.mat_format import read_mat
from tests.logs.example import measured


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "bench.mat"
    contents = {
        "t": np.arange(4.0) / 1000.0,
        "counts": np.array([[1], [2], [3], [-4]], dtype=np.int16),
        "gtau": 35.15,
        "matrix": np.eye(3),
        "note": "a text",
        "rig": {"name": "x"},
        "z": np.array([1j, 2.0]),
    }
    scipy.io.savemat(file, contents, do_compression=True, oned_as="column")
    return file


def test_vectors_become_columns(path: Path):
    table = read_mat(path, ["t", "counts"])
    assert table.columns["t"].tolist() == [0.0, 0.001, 0.002, 0.003]
    assert table.columns["counts"].tolist() == [1, 2, 3, -4]
    assert table.columns["counts"].dtype == np.float64
    assert table.names == ("t", "counts")
    assert table.line(0) is None


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ("gtau", "variable 'gtau' is a 1x1 double; allowed: a real vector: t, counts"),
        ("matrix", "variable 'matrix' is a 3x3 double"),
        ("note", "variable 'note' is a 1x6 char"),
        ("rig", "variable 'rig' is a 1x1 struct"),
        ("z", "variable 'z' is a 2x1 complex double"),
        ("count", r"has no variable 'count' \(did you mean 'counts'\?\); found: t, counts"),
    ],
)
def test_a_wrong_variable_lists_what_there_is(path: Path, wanted: str, message: str):
    with pytest.raises(LogError, match=message):
        read_mat(path, [wanted])


def test_by_number(path: Path):
    assert list(read_mat(path, [2]).columns) == ["counts"]


def test_every_cut_is_one_line(path: Path):
    whole = path.read_bytes()
    last = path.with_name("cut.mat")
    ends = [128]  # a cut between two variables leaves a file that is whole
    while ends[-1] < len(whole):
        ends.append(ends[-1] + 8 + int.from_bytes(whole[ends[-1] + 4 : ends[-1] + 8], "little"))
    assert ends[-1] == len(whole)
    for length in set(range(1, len(whole))) - set(ends[2:]):
        last.write_bytes(whole[:length])
        with pytest.raises(LogError) as caught:
            read_mat(last, ["t", "counts"])
        assert "\n" not in str(caught.value)


DTYPES = ("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")


@given(
    values=st.lists(st.integers(-(2**52), 2**52), min_size=2, max_size=40),
    dtype=st.sampled_from(DTYPES),
    compressed=st.booleans(),
    column=st.booleans(),
    name=st.sampled_from(["x", "abc", "abcd", "a_long_name_of_31_characters_xyz"]),
)
def test_what_scipy_writes_is_read_as_scipy_reads_it(values: list[int], dtype: str, compressed: bool, column: bool, name: str):
    vector = np.array(values).astype(dtype)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "x.mat")
        scipy.io.savemat(file, {name: vector, "after": np.arange(3.0)}, do_compression=compressed, oned_as="column" if column else "row")
        reference = scipy.io.loadmat(file)[name].ravel()
        table = read_mat(file)
    assert table.names == (name, "after")
    assert np.array_equal(table.columns[name], reference.astype(float))
    assert table.columns["after"].tolist() == [0.0, 1.0, 2.0]


@pytest.mark.parametrize("compressed", [True, False])
def test_no_flipped_bit_raises_anything_but_the_one_line(tmp_path: Path, compressed: bool):
    """And in a compressed variable none passes: the checksum tells."""
    file = tmp_path / "flip.mat"
    contents = {"t": np.arange(20.0), "x": np.arange(20.0) ** 2}
    scipy.io.savemat(file, contents, do_compression=compressed)
    whole = file.read_bytes()
    passed = 0
    for position in range(len(whole)):
        for bit in (0, 4, 7):
            data = bytearray(whole)
            data[position] ^= 1 << bit
            file.write_bytes(bytes(data))
            with suppress(LogError):
                table = read_mat(file, ["t", "x"])
                assert not compressed or all(np.array_equal(table.columns[name], contents[name]) for name in contents)
                passed += 1
    assert passed >= 3 * 124  # the text at the head of the file means nothing


def test_a_length_beyond_the_file_is_refused_before_it_is_allocated(path: Path):
    data = bytearray(path.read_bytes())
    data[132:136] = b"\xff\xff\xff\xff"
    path.write_bytes(bytes(data))
    with pytest.raises(LogError, match="announces 4294967295 bytes"):
        read_mat(path, ["t"])


def test_the_measured_record():
    table = read_mat(measured("emps/DATA_EMPS.mat"), ["t", "qm", "vir"])
    assert table.columns["qm"].shape == (24841,)
    assert set(table.names) == {"qg", "qm", "t", "vir"}
