"""NumPy files: vectors, matrices, structured arrays, dates; numpy itself is the reference."""

from __future__ import annotations

import tempfile
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of

from frictool.errors import LogError
from frictool.logs.arrays import npz_format
from frictool.logs.arrays.array_table import ArrayTable
from frictool.logs.raw_table import BLOCK_ROWS, DataLoss
from tests.logs.tables import columns, times
from tests.support.example_logs import GOLDEN


def table_of(path: Path) -> ArrayTable:
    assert npz_format.sniff(path.read_bytes()[:4096], path)
    (table,) = npz_format.tables(path)
    assert isinstance(table, ArrayTable)
    return table


@pytest.fixture(params=[np.savez, np.savez_compressed], ids=["stored", "compressed"])
def path(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    file = tmp_path / "bench.npz"
    contents = {
        "t": np.arange(4) / 1000,
        "counts": np.array([[1], [2], [3], [-4]], dtype=">i2"),
        "matrix": np.arange(12.0).reshape(4, 3),
        "by_columns": np.asfortranarray(np.arange(8.0).reshape(4, 2)),
        "wide": np.arange(8.0).reshape(2, 4),
        "rows": np.array([(1, 0.5), (2, 1.5)], dtype=[("count", "i4"), ("current", "f8")]),
        "gain": np.array(35.15),
        "text": np.array(["a", "b"]),
        "z": np.array([1j, 2.0]),
    }
    request.param(file, **contents)
    return file


def test_the_golden_file():
    """Written by numpy (tests/logs/golden/make_extras.py)."""
    table = table_of(GOLDEN / "arrays.npz")
    found = columns(table)
    assert {name: values.tolist() for name, values in found.items()} == {
        "counts": [-1, 2, 300, 7],
        "matrix[:, 0]": [0, 2, 4, 6],
        "matrix[:, 1]": [1, 3, 5, 7],
        "rows.count": [1, 2, 3, 4],
        "rows.current": [0.5, 1.5, 2.5, 3.5],
    }
    assert times(table).tolist() == [1_700_000_000_123_456_789 + k * 500_000_001 for k in range(4)]


def test_vectors_matrices_and_fields(path: Path):
    table = table_of(path)
    assert table.names == (
        *(
            "t",
            "counts",
            "matrix[:, 0]",
            "matrix[:, 1]",
            "matrix[:, 2]",
            "by_columns[:, 0]",
            "by_columns[:, 1]",
        ),
        *("wide[0, :]", "wide[1, :]", "rows.count", "rows.current"),
    )
    found = columns(table, ["t", "counts", "matrix(:,2)", "by_columns[:,1]", "wide[1,:]"])
    assert list(map(list, found.values())) == [
        [0, 0.001, 0.002, 0.003],
        [1, 2, 3, -4],
        [1, 4, 7, 10],
        [1, 3, 5, 7],
        [4, 5, 6, 7],
    ]
    assert columns(table, ["rows.current"])["rows.current"].tolist() == [0.5, 1.5]


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ("gain", "'gain' is a single float64"),
        ("text", "'text' is a 2 <U1"),
        ("z", "2 complex128"),
        ("rows", "2 structures"),
    ],
)
def test_what_is_no_column_is_said(path: Path, wanted: str, message: str):
    with pytest.raises(LogError, match=message):
        table_of(path).find(wanted)


def test_dates_are_the_clock(tmp_path: Path):
    """To the nanosecond, whatever their unit."""
    stamps = np.datetime64("2024-02-29T12:00:00.123456789", "ns") + np.arange(5) * np.timedelta64(
        1_000_001, "ns"
    )
    for unit in ("ns", "us", "ms"):
        np.savez(tmp_path / "x.npz", when=stamps.astype(f"M8[{unit}]"), x=np.arange(5.0))
        table = table_of(tmp_path / "x.npz")
        assert (table.clock, table.names) == ("when", ("x",))
        assert np.array_equal(
            times(table), stamps.astype(f"M8[{unit}]").astype("M8[ns]").astype(np.int64)
        )


@pytest.mark.parametrize("date", ["NaT", "9999-01-01", "0001-01-01"])
def test_a_missing_or_impossible_date_is_named(tmp_path: Path, date: str):
    np.savez(tmp_path / "x.npz", when=np.array(["2024-01-01", date], "M8[s]"), x=np.arange(2.0))
    with pytest.raises(
        LogError,
        match=f"'when' has {date}.* at sample 2; allowed: a time in the years 1678 to 2261",
    ):
        columns(table_of(tmp_path / "x.npz"))


@pytest.mark.parametrize("fields", [False, True])
def test_a_single_array(tmp_path: Path, fields: bool):
    vector = np.array([(1, 0.5), (2, 1.5)], dtype=[("count", "i4"), ("current", "f8")])
    np.save(tmp_path / "x.npy", vector if fields else vector["current"])
    found = columns(table_of(tmp_path / "x.npy"))
    assert found.keys() == ({"count", "current"} if fields else {"array"})
    assert found["current" if fields else "array"].tolist() == [0.5, 1.5]


def test_longer_than_a_block(tmp_path: Path):
    tall = np.random.default_rng(1).normal(size=(2 * BLOCK_ROWS + 7, 3))
    np.savez_compressed(tmp_path / "x.npz", rows=tall, columns=np.asfortranarray(tall), wide=tall.T)
    found = columns(table_of(tmp_path / "x.npz"))
    for k in range(3):
        for name in (f"rows[:, {k}]", f"columns[:, {k}]", f"wide[{k}, :]"):
            assert np.array_equal(found[name], tall[:, k])


@given(
    arrays_of.arrays(
        arrays_of.integer_dtypes(endianness="=")
        | arrays_of.unsigned_integer_dtypes()
        | arrays_of.floating_dtypes(endianness=">"),
        arrays_of.array_shapes(min_dims=1, max_dims=2, max_side=6),
    ),
    st.booleans(),
)
def test_what_numpy_writes_is_read_as_numpy_reads_it(array: np.ndarray, by_columns: bool):
    written = np.asfortranarray(array) if by_columns else array
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "x.npz")
        np.savez(file, x=written, after=np.arange(3.0))
        table = table_of(file)
        for name in table.names:
            with np.errstate(invalid="ignore"):
                reference = np.load(file)["after" if name == "after" else "x"].astype(float)
            position = (
                name.removeprefix("x").removeprefix("after").strip("[]").replace(" ", "").split(",")
            )
            index = tuple(slice(None) if one == ":" else int(one) for one in position if one)
            assert np.array_equal(
                columns(table, [name])[name],
                reference[index].ravel() if index else reference.ravel(),
                equal_nan=True,
            )


def test_objects_are_not_unpickled(tmp_path: Path):
    class Bomb:
        def __reduce__(self) -> tuple[object, ...]:
            return (pytest.fail, ("unpickled",))

    np.savez(tmp_path / "x.npz", bomb=np.array([Bomb(), Bomb()], dtype=object), x=np.arange(3.0))
    table = table_of(tmp_path / "x.npz")
    assert table.names == ("x",)
    assert columns(table)["x"].tolist() == [0, 1, 2]
    with pytest.raises(LogError, match="'bomb' is a 2 objects"):
        table.find("bomb")


def test_a_bomb_of_zeros_is_refused_by_its_sizes(tmp_path: Path):
    """100 MB of zeros under the head of 8 numbers: nothing is inflated for them."""
    good, file = tmp_path / "good.npy", tmp_path / "x.npz"
    np.save(good, np.arange(8.0))
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x.npy", good.read_bytes() + bytes(100_000_000))
    with pytest.raises(
        LogError, match="array 'x' declares 64 bytes of numbers, but 100000064 follow"
    ):
        columns(table_of(file))


def test_salvage_gives_what_was_before_a_damage(tmp_path: Path):
    file = tmp_path / "x.npz"
    values = np.random.default_rng(3).normal(size=200_000)
    np.savez_compressed(file, x=values)
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 0xFF
    file.write_bytes(bytes(data))
    with pytest.raises(LogError, match="variable 'x' is in a damaged archive"):
        columns(table_of(file))
    losses: list[DataLoss] = []
    found = columns(table_of(file), None, losses)["x"]
    assert found.size + sum(loss.samples or 0 for loss in losses) == values.size
    assert losses


def test_a_cut_archive_is_one_line(path: Path):
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(LogError, match="is not a complete zip archive"):
        npz_format.tables(path)


def test_a_cut_array_is_salvaged(tmp_path: Path):
    file = tmp_path / "x.npy"
    np.save(file, np.arange(100.0))
    file.write_bytes(file.read_bytes()[:-20])
    with pytest.raises(LogError, match="declares 800 bytes of numbers, but 780 follow"):
        columns(table_of(file))
    losses: list[DataLoss] = []
    assert columns(table_of(file), None, losses)["array"].tolist() == list(range(97))
    assert losses[-1].samples == 3


@pytest.mark.parametrize("step", [15, pytest.param(5, marks=pytest.mark.accept)])
def test_no_flipped_bit_raises_anything_but_the_one_line(path: Path, step: int):
    whole = path.read_bytes()
    for position in range(0, len(whole), step):
        data = bytearray(whole)
        data[position] ^= 1 << position % 8
        path.write_bytes(bytes(data))
        with suppress(LogError):
            (table,) = npz_format.tables(path)
            columns(table, ["t", "counts"])
