"""Columns without a name, of one name, or without a number, and bags whose topics are damaged:
read, or one line."""

from __future__ import annotations

import io
import sqlite3
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from frictool.documents.bench import Column
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import run
from tests.support import sample_files
from tests.support.command_line import refused
from tests.support.example_logs import bench, measured

TIME = np.arange(100) / 1000.0
MOTION = np.sin(30.0 * TIME)


def _npz(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in (("time", TIME), ("", MOTION), ("current", TIME)):
            stream = io.BytesIO()
            np.save(stream, values)
            archive.writestr(f"{name}.npy", stream.getvalue())


def _parquet(path: Path) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table({"time": TIME, "": MOTION, "current": TIME}), path)


def _nested(path: Path) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    inner = pa.StructArray.from_arrays([pa.array(MOTION), pa.array(2.0 * MOTION)], names=["", "b"])
    pq.write_table(pa.table({"state": inner, "time": TIME, "current": TIME}), path)


def rig(folder: Path, column: str) -> Path:
    path = folder / "bench.yaml"
    columns = {
        "time": Column("time", "s"),
        "position": Column(column, "rad"),
        "current": Column("current", "A"),
    }
    path.write_text(to_yaml(bench(columns)))
    return path


@pytest.mark.parametrize(("write", "column"), [(_npz, ""), (_parquet, ""), (_nested, "state.")])
def test_a_column_without_a_name_can_be_asked_for(
    write: Callable[[Path], None], column: str, tmp_path: Path
):
    log, target = tmp_path / "log", tmp_path / "log.mcap"
    write(log)
    assert run("ingest", log, "--bench", rig(tmp_path, column), "-o", target).code == 0
    assert read_mcap(target).main.signals["position"].tolist() == MOTION.tolist()
    guessed = run("ingest", "--guess", log, "--axis", "rotary", "-o", tmp_path / "guess.yaml")
    assert guessed.code == 0
    assert "time is 'time' [s]" in guessed.stdout


def test_a_name_of_several_columns_is_refused(tmp_path: Path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    arrays = [pa.array(values) for values in (TIME, MOTION, TIME, TIME)]
    pq.write_table(pa.table(arrays, names=["time", "x", "x", "current"]), tmp_path / "log")
    refused(
        run("info", tmp_path / "log", "--bench", rig(tmp_path, "x")),
        3,
        "'x' is a name that several columns have",
    )


def test_the_bytes_of_matlab_s_objects_are_no_column(tmp_path: Path):
    """A file with objects ends in a variable without a name."""
    log = tmp_path / "log.mat"
    scipy.io.savemat(log, {"time": TIME, "x": MOTION, "current": TIME})
    flags, shape, name = (
        struct.pack("<IIII", 6, 8, 9, 0),
        struct.pack("<IIii", 5, 8, 1, 100),
        struct.pack("<II", 1, 0),
    )
    content = flags + shape + name + struct.pack("<II", 2, 100) + bytes(range(100)) + bytes(4)
    log.write_bytes(log.read_bytes() + struct.pack("<II", 14, len(content)) + content)
    guessed = run("ingest", "--guess", log, "--axis", "rotary", "-o", tmp_path / "guess.yaml")
    assert guessed.code == 0, guessed.stderr
    refused(
        run("info", log, "--bench", rig(tmp_path, "")),
        3,
        "has no column ''; found: time, x, current",
    )


@pytest.mark.parametrize(
    "name", ["datapage_v2_empty_datapage.snappy.parquet", "nulls.snappy.parquet"]
)
def test_a_file_without_a_finite_number_is_one_line(name: str, tmp_path: Path):
    log = measured(f"attacks/{name}")
    refused(
        run("ingest", "--guess", log, "--axis", "rotary", "-o", tmp_path / "guess.yaml"),
        3,
        "has no column with a finite number",
    )


def test_a_column_of_nothing_but_empty_cells_is_not_guessed(tmp_path: Path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table({"x": pa.array([None] * 50, pa.float64())}), tmp_path / "log")
    refused(
        run(
            "ingest", "--guess", tmp_path / "log", "--axis", "rotary", "-o", tmp_path / "guess.yaml"
        ),
        3,
        "finite",
    )


def test_the_bag_that_was_found(tmp_path: Path):
    log = measured("attacks/damaged_topics.db3")
    for words in (
        ["ingest", "--guess", log, "--axis", "rotary"],
        ["ingest", log, "--salvage", "--bench", rig(tmp_path, "x")],
    ):
        refused(
            run(
                *words, "-o", tmp_path / "out.yaml" if "--guess" in words else tmp_path / "out.mcap"
            ),
            3,
            "a row of its table 'topics' is",
        )


@pytest.mark.parametrize("column", ["id", "name", "type", "serialization_format"])
@pytest.mark.parametrize("value", [None, 1.5, b"\xff\x00", "text", -1, 2**62])
def test_topics_of_any_content_are_read_or_one_line(column: str, value: object, tmp_path: Path):
    log, good = tmp_path / "log.db3", sample_files.write("db3", tmp_path)
    with sqlite3.connect(good) as bag:
        rows = bag.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
        bag.execute("DROP TABLE topics")
        bag.execute("CREATE TABLE topics (id, name, type, serialization_format)")
        names = ("id", "name", "type", "serialization_format")
        for row in rows:
            bag.execute(
                "INSERT INTO topics VALUES (?, ?, ?, ?)",
                [value if name == column else cell for name, cell in zip(names, row, strict=True)],
            )
    bag.close()
    log.write_bytes(good.read_bytes())
    result = run("ingest", "--guess", log, "--axis", "rotary", "-o", tmp_path / "guess.yaml")
    assert result.code in (0, 3)
    assert result.code == 0 or result.stderr.count("\n") == 1


def test_a_unit_at_the_end_of_a_name_shows_the_kind_of_axis(tmp_path: Path) -> None:
    """A single letter may be a label: theta_m is an angle of the motor."""
    rows = "\n".join(f"{t:g},{x:g},{i:g}" for t, x, i in zip(TIME, MOTION, TIME, strict=True))
    log = tmp_path / "log.csv"
    log.write_text(f"zeit_s,winkel_deg,strom_mA\n{rows}\n")
    guessed = run("ingest", "--guess", log, "-o", tmp_path / "guess.yaml")
    assert guessed.code == 0, guessed.stderr
    assert "axis: rotary" in (tmp_path / "guess.yaml").read_text()
    log.write_text(f"zeit_s,lage_m,strom_mA\n{rows}\n")
    refused(run("ingest", "--guess", log, "-o", tmp_path / "other.yaml"), 3, "--axis")


def test_a_log_without_the_reference_is_read_with_a_warning(tmp_path: Path) -> None:
    """A test of drive ramps has no reference, but comes from the same bench."""
    columns = {
        "time": Column("t", "s"),
        "position": Column("x", "rad"),
        "current": Column("i", "A"),
        "reference": Column("goal", "rad"),
    }
    described = tmp_path / "bench.yaml"
    described.write_text(to_yaml(bench(columns)))
    rows = "\n".join(f"{t:g},{x:g},{t:g}" for t, x in zip(TIME, MOTION, strict=True))
    log = tmp_path / "log.csv"
    log.write_text(f"t,x,i\n{rows}\n")
    result = run("ingest", log, "--bench", described, "-o", tmp_path / "log.mcap")
    assert result.code == 0, result.stderr
    assert "log.csv has no column 'goal', and is read without the reference" in result.stderr
    assert "reference" not in read_mcap(tmp_path / "log.mcap").main.signals
    log.write_text(f"t,y,i\n{rows}\n")
    refused(run("ingest", log, "--bench", described, "-o", tmp_path / "no.mcap"), 3, "'x'")
