"""MDF: groups are tables, whatever their version; asammdf writes, and what it was given is the
reference."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.errors import LogError
from frictool.logs.arrays import mdf_format
from frictool.logs.arrays.truncated_mdf import described_at
from frictool.logs.channels.column_binding import bind
from frictool.logs.raw_table import BLOCK_ROWS, DataLoss
from tests.logs.tables import columns, one_line, times
from tests.support.example_logs import GOLDEN, measured

V4, V3 = GOLDEN / "v4.mf4", GOLDEN / "v3.mdf"
EPOCH = 1_700_000_000_123_456_789


@pytest.fixture(scope="module", autouse=True)
def _asammdf() -> None:
    """Import the writer where it is needed: that takes most of a second."""
    global asammdf
    asammdf = pytest.importorskip("asammdf")


@pytest.mark.parametrize("path", [V4, V3])
def test_golden_files(path: Path):
    assert mdf_format.sniff(path.read_bytes()[:4096], path)
    fast, slow = mdf_format.tables(path)
    found = columns(fast, ["nAct\\ETKC:1", "iAct", "state", "time"])
    assert found["nAct\\ETKC:1"].tolist() == [-1, 2, 300, 7]
    assert found["iAct"].tolist() == [0.5, 2.0, 151.0, 4.5]
    assert found["state"].tolist() == [0, 1, 0, 1]  # the raw number, not "on" and "off"
    assert found["time"].tolist() == [0.0, 0.5, 1.0, 1.5]
    assert {name: fast.units[name] for name in found} == {
        "nAct\\ETKC:1": "rpm",
        "iAct": "A",
        "state": None,
        "time": "s",
    }
    assert columns(slow, ["nAct\\ETKC:1"])["nAct\\ETKC:1"].tolist() == [-1, 2]
    assert (fast.clock, fast.line(0)) == ("time", None)


def test_the_master_channel_dates_the_rows_from_the_start_of_the_file():
    fast, _ = mdf_format.tables(V4)
    assert times(fast, ["iAct"]).tolist() == [EPOCH + k * 500_000_000 for k in range(4)]
    assert times(mdf_format.tables(V3)[0], ["iAct"])[0] == 1_709_208_000 * 10**9


def test_texts_are_no_column():
    with pytest.raises(LogError, match="'note' is a text, not a number"):
        mdf_format.tables(V4)[0].find("note")


def test_a_name_in_two_groups_is_asked_for_with_its_group():
    fast, slow = mdf_format.tables(V4)
    assert fast.find("fast/nAct\\ETKC:1") == slow.find("slow/nAct\\ETKC:1") == "nAct\\ETKC:1"
    assert fast.find("slow/nAct\\ETKC:1") is None


def test_an_invalid_sample_is_damage_or_an_empty_cell():
    fast, _ = mdf_format.tables(V4)
    with pytest.raises(
        LogError, match="group 'fast', channel 'doubtful': sample 2 is marked as invalid"
    ):
        columns(fast, ["doubtful"])
    found = columns(fast, ["doubtful"], [])["doubtful"]
    assert np.array_equal(found, [-1, np.nan, 300, 7], equal_nan=True)


def test_bench_columns_of_two_groups_become_two_streams():
    from frictool.documents.bench import Column
    from tests.support.example_logs import bench

    rig = bench(
        {"position": Column("slow/nAct\\ETKC:1", "rad", scale=0.5), "current": Column("iAct", "A")},
        sample_period_s=0.5,
    )
    assert [mapper.head.topic for mapper in bind(mdf_format.tables(V4), rig)] == [
        "/axis",
        "/axis/fast",
    ]
    ambiguous = bench({"velocity": Column("nAct\\ETKC:1", "rpm")}, sample_period_s=0.5)
    with pytest.raises(LogError, match=r"has 2 columns .* in fast, slow"):
        bind(mdf_format.tables(V4), ambiguous)


@pytest.mark.parametrize("compression", [0, 1, 2])
def test_longer_than_a_block(tmp_path: Path, compression: int):
    n = BLOCK_ROWS + 1000
    values = np.random.default_rng(1).normal(size=n)
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(values, np.arange(n) / 1e4, name="x")])
        file.save(tmp_path / "x.mf4", compression=compression)
    (table,) = mdf_format.tables(tmp_path / "x.mf4")
    assert np.array_equal(columns(table, ["x"])["x"], values)
    assert np.array_equal(times(table, ["x"]) - times(table, ["x"])[0], np.arange(n) * 100_000)


DTYPES = ("f8", "f4", "i1", "u1", "i2", ">u2", "i4", "u4", ">i4", "i8")


@settings(max_examples=settings.default.max_examples // 4)
@given(
    values=st.lists(st.integers(-(2**52), 2**52), min_size=1, max_size=40),
    dtype=st.sampled_from(DTYPES),
    version=st.sampled_from(["4.10", "4.20", "3.30"]),
    gain=st.sampled_from([None, 0.25, -3.0]),
)
def test_what_asammdf_writes_is_read(
    values: list[int], dtype: str, version: str, gain: float | None
):
    if dtype == "f4":  # asammdf converts these numbers in float32
        values = [value % 2**20 for value in values]
    raw = np.array(values).astype(dtype)
    conversion = None if gain is None else {"a": gain, "b": 2.0}
    with tempfile.TemporaryDirectory() as folder, asammdf.MDF(version=version) as file:
        stamps = np.arange(raw.size) / 1000
        file.append(
            [
                asammdf.Signal(raw, stamps, name="x", conversion=conversion),
                asammdf.Signal(raw, stamps, name="x"),
            ]
        )
        target = file.save(Path(folder, "x" + (".mf4" if version > "4" else ".mdf")))
        (table,) = mdf_format.tables(target)
        found = columns(table, ["x (channel 2)", "x (channel 3)"])
    assert np.array_equal(
        found["x (channel 2)"], raw.astype(float) * (gain or 1.0) + (2.0 if gain else 0.0)
    )
    assert np.array_equal(found["x (channel 3)"], raw.astype(float))


def test_no_numbers(tmp_path: Path):
    with asammdf.MDF(version="4.10") as file:
        file.append(
            [
                asammdf.Signal(
                    np.array([b"a", b"b"]), np.array([0.0, 1.0]), name="note", encoding="latin-1"
                )
            ]
        )
        file.groups[0].channels.pop(0)
        target = file.save(tmp_path / "x.mf4")
    with pytest.raises(LogError):
        mdf_format.tables(target)


@pytest.mark.parametrize("path", [V4, V3])
@pytest.mark.parametrize("count", [3, pytest.param(12, marks=pytest.mark.accept)])
def test_every_damage_is_one_line(count: int, path: Path, tmp_path: Path):
    """Cuts and broken bytes, each read in a process of its own."""
    whole, file = path.read_bytes(), tmp_path / "x.mf4"
    draw = np.random.default_rng(7)
    refused = 0
    for k in range(count):
        data = bytearray(whole[: draw.integers(200, len(whole))] if k % 3 == 0 else whole)
        data[draw.integers(100, len(data))] ^= 0xFF
        file.write_bytes(bytes(data))
        losses: list[DataLoss] = []
        with one_line() as refusals:
            for table in mdf_format.tables(file):
                columns(table, None, losses)
        refused += len(refusals)
    assert refused >= count // 3


def test_a_file_that_was_cut_while_it_was_written_is_salvaged(tmp_path: Path):
    """As loggers write: heads first, then the records. asammdf writes the records first; here they
    are moved to the end, and cut."""
    n, file = 3000, tmp_path / "x.mf4"
    values = np.random.default_rng(4).normal(size=n)
    with asammdf.MDF(version="4.10") as made:
        made.append([asammdf.Signal(values, np.arange(n) / 1000, name="x")])
        made.save(file)
    data = bytearray(file.read_bytes())
    link = data.find(b"##DG") + 24 + 2 * 8
    records = int.from_bytes(data[link : link + 8], "little")
    block = bytes(
        data[records : records + int.from_bytes(data[records + 8 : records + 16], "little")]
    )
    data += bytes(-len(data) % 8)
    data[link : link + 8] = len(data).to_bytes(8, "little")
    file.write_bytes(data + block)
    assert np.array_equal(columns(mdf_format.tables(file)[0], ["x"])["x"], values)

    left = len(block) * 2 // 3
    file.write_bytes(data + block[:left])
    (table,) = mdf_format.tables(file)
    there = (left - 24) // 16  # a head of 24 bytes, 16 a record
    with pytest.raises(
        LogError, match=f"the file is cut off; group 'group 1' has {there} of 3000 samples"
    ):
        columns(table, ["x"])
    losses: list[DataLoss] = []
    assert np.array_equal(columns(table, ["x"], losses)["x"], values[:there])
    assert [loss.samples for loss in losses] == [n - there]


def test_a_file_whose_description_was_cut_off_says_where_it_ends(tmp_path: Path):
    """As asammdf writes: the records first, and behind them what they mean. Its own words are none
    a user can do anything with."""
    whole, file = tmp_path / "whole.mf4", tmp_path / "cut.mf4"
    with asammdf.MDF(version="4.10") as made:
        made.append([asammdf.Signal(np.arange(3000.0), np.arange(3000) / 1000, name="x")])
        made.save(whole)
    data = whole.read_bytes()
    assert described_at(whole) is None
    group = data.find(b"##DG")
    for end in (len(data) // 2, group, group + 10):
        file.write_bytes(data[:end])
        with pytest.raises(
            LogError,
            match=rf"cut.mf4: is cut off at byte {end}, before the description of its channels at "
            rf"byte {group}, ",
        ):
            mdf_format.tables(file)
    file.write_bytes(data.replace(b"##CG", b"##XX"))
    with pytest.raises(
        LogError,
        match="is damaged, or a kind of MDF that frictool cannot read: its blocks are inconsistent",
    ):
        mdf_format.tables(file)


def test_the_measured_file():
    (table,) = mdf_format.tables(measured("formats/test_meas_4.10.mf4"))
    found = columns(table)
    assert list(found) == ["t", "MAIN_CLOCK"]
    assert found["t"].size == 1483
    assert np.diff(found["t"]).min() > 0
