"""MATLAB tables and timetables, read with mat-io."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from frictool.errors import LogError
from frictool.logs.arrays import mat_objects
from frictool.logs.formats import tables_of


@pytest.fixture(scope="module", autouse=True)
def _writers() -> None:
    """Import the writers where they are needed: that takes half a second."""
    global matio, pandas
    matio, pandas = pytest.importorskip("matio"), pytest.importorskip("pandas")


ROWS = 50
POSITION = np.sin(np.arange(ROWS) / 5.0)


def written(folder: Path, version: str, **variables: object) -> Path:
    path = folder / f"{version}.mat"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # mat-io stores durations of ns in its own unit
        matio.save_to_mat(str(path), variables, version=version)
    return path


def timetable() -> object:
    times = pandas.to_timedelta(np.arange(ROWS) * 250_000, unit="ns")
    return pandas.DataFrame(
        {"pos": POSITION, "state": ["on"] * ROWS}, index=pandas.Index(times, name="Time")
    )


@pytest.mark.parametrize("version", ["v7", "v7.3"])
def test_a_timetable_keeps_its_row_times(version: str, tmp_path: Path) -> None:
    path = written(tmp_path, version, run=timetable(), x=np.arange(3.0))
    plain, run = tables_of(path)
    assert plain.names == ("x",)
    assert (run.topic, run.names, run.clock) == ("run", ("pos",), "Time")
    (block,) = [block for block, _ in run.blocks(["pos"])]
    assert block.columns["pos"].tolist() == POSITION.tolist()
    assert np.asarray(block.time_ns).tolist() == [250_000 * k for k in range(ROWS)]
    with pytest.raises(LogError, match="'state' is no column of numbers"):
        run.find("state")


@pytest.mark.parametrize("version", ["v7", "v7.3"])
def test_a_table_alone_is_read(version: str, tmp_path: Path) -> None:
    path = written(tmp_path, version, run=pandas.DataFrame({"t": POSITION, "i": -POSITION}))
    (table,) = tables_of(path)
    assert (table.topic, table.names, table.clock) == ("run", ("t", "i"), None)
    (block,) = [block for block, _ in table.blocks(["i"])]
    assert block.columns["i"].tolist() == (-POSITION).tolist()


@pytest.mark.parametrize("version", ["v7", "v7.3"])
def test_without_mat_io_the_extra_is_named(
    version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path, version, run=timetable())
    monkeypatch.setattr(mat_objects, "can_read", lambda: False)
    with pytest.raises(LogError, match=r"pip install 'frictool\[matlab\]'"):
        tables_of(path)


@pytest.mark.parametrize("version", ["v7", "v7.3"])
def test_damage_is_one_line(version: str, tmp_path: Path) -> None:
    path = written(tmp_path, version, run=timetable())
    data = np.frombuffer(path.read_bytes(), np.uint8)
    rng = np.random.default_rng(7)
    for _ in range(8):
        changed = data.copy()
        at = rng.integers(200, data.size, 6)
        changed[at] = rng.integers(0, 256, 6)
        path.write_bytes(changed.tobytes())
        messages = []
        try:
            for table in tables_of(path):
                list(table.blocks(table.names, []))
        except LogError as error:
            messages.append(str(error))
        assert not any("\n" in message for message in messages)
