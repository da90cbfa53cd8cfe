"""TDMS, ULog and CAN logs: values, units and times against the writers; damage; refusals."""

from __future__ import annotations

import json
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Layout
from frictool.errors import LogError
from frictool.logs.formats import FORMATS, format_of, tables_of
from frictool.logs.raw_table import DataLoss, RawTable
from studies.command_line import run
from tests.support import logger_files
from tests.support.command_line import refused
from tests.support.example_logs import GOLDEN
from tests.support.logger_files import CURRENT, PERIOD_MS, POSITION, ROWS

LIBRARIES = ("nptdms", "pyulog", "can", "cantools")
pytestmark = pytest.mark.skipif(
    not all(find_spec(name) for name in LIBRARIES), reason=f"{', '.join(LIBRARIES)} are needed"
)

FOLDER = GOLDEN / "loggers"
FILES = {
    "axis.tdms": ("tdms", "axis", "wf_increment", {"encoder": None, "current": "A"}),
    "axis.ulg": ("ulog", "axis_state", "timestamp", {"encoder": None, "current": None}),
    "axis.blf": ("can", "AxisState", "log time", {"encoder": "count", "current": "A"}),
    "axis.asc": ("can", "AxisState", "log time", {"encoder": "count", "current": "A"}),
    "axis.candump": ("can", "AxisState", "log time", {"encoder": "count", "current": "A"}),
}


def columns(table: RawTable, losses: list[DataLoss] | None = None) -> dict[str, np.ndarray]:
    """The columns and the times (`at`) of a table; none where it has no block."""
    parts = [block for block, _ in table.blocks(table.names, losses)]
    if not parts:
        return {}
    read = {name: np.concatenate([part.columns[name] for part in parts]) for name in table.names}
    times = [part.time_ns for part in parts if part.time_ns is not None]
    return read | ({"at": np.concatenate(times)} if times else {})


@pytest.mark.parametrize("name", FILES)
def test_a_golden_file_has_the_values_of_its_writer(name: str) -> None:
    form, topic, clock, units = FILES[name]
    path = FOLDER / name
    assert format_of(path).name == form
    table = tables_of(path)[0]
    assert (table.topic, table.clock, dict(table.units)) == (topic, clock, units)
    read = columns(table)
    assert read["encoder"].tolist() == POSITION.tolist()
    # a float of 32 bits, or a step of 0.01 A
    assert read["current"] == pytest.approx(CURRENT, abs=1e-7)
    steps = np.diff(read["at"])
    assert steps == pytest.approx(np.full(ROWS - 1, PERIOD_MS * 1e6), abs=500)  # times to 1 us


def test_a_group_of_two_time_bases_is_two_tables() -> None:
    axis, slow = tables_of(FOLDER / "axis.tdms")
    assert (slow.topic, slow.names, slow.clock) == ("slow", ("temperature",), None)
    (block,) = [block for block, _ in slow.blocks(["temperature"])]
    assert block.columns["temperature"].tolist() == [0, 1, 2, 30, 31, 32]
    first = int(columns(axis)["at"][0])
    assert first == 1_769_903_999_000_000_000


@pytest.mark.parametrize("name", FILES)
def test_the_command_line_reads_each_file(name: str, tmp_path: Path) -> None:
    log = tmp_path / name
    shutil.copy(FOLDER / name, log)
    shutil.copy(FOLDER / "axis.dbc", tmp_path)
    bench = tmp_path / "bench.yaml"
    made = run("ingest", "--guess", log, "--axis", "rotary", "-o", bench)
    assert made.code == 0, made.stderr
    bench.write_text(bench.read_text().replace('unit: "?"', "unit: A"))
    done = run("ingest", log, "--bench", bench, "-o", tmp_path / "log.mcap")
    assert done.code == 0, done.stderr
    facts = json.loads(run("info", tmp_path / "log.mcap", "--json").stdout)
    assert {row["name"]: row["samples"] for row in facts["channels"]}["position"] == ROWS


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_is_cut_is_refused_and_salvaged(name: str, tmp_path: Path) -> None:
    data = (FOLDER / name).read_bytes()
    path = tmp_path / name
    shutil.copy(FOLDER / "axis.dbc", tmp_path)
    path.write_bytes(data[: len(data) - 25])
    with pytest.raises(LogError, match=r"damaged|cut|incomplete|line end"):
        columns(tables_of(path)[0])
    try:
        table = tables_of(path)[0]
    except LogError:
        return  # nothing of the file can be read, and a line says so
    losses: list[DataLoss] = []
    read = columns(table, losses)
    assert losses
    kept = read.get("encoder", np.empty(0))
    assert kept.tolist() == POSITION[: kept.size].tolist()


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("count", [2, pytest.param(12, marks=pytest.mark.accept)])
def test_damage_is_one_line(count: int, name: str, tmp_path: Path) -> None:
    """Bytes changed at random: each file is read, or refused in one line."""
    data = np.frombuffer((FOLDER / name).read_bytes(), np.uint8)
    shutil.copy(FOLDER / "axis.dbc", tmp_path)
    path = tmp_path / name
    rng = np.random.default_rng(20261127)
    for _ in range(count):
        changed = data.copy()
        at = rng.integers(8, data.size, 4)
        changed[at] = rng.integers(0, 256, 4)
        path.write_bytes(changed.tobytes())
        messages = []
        try:
            for table in tables_of(path):
                columns(table, [])
        except LogError as error:
            messages.append(str(error))
        assert not any("\n" in message or "Traceback" in message for message in messages)


def test_can_without_its_dbc_is_refused_with_what_to_do(tmp_path: Path) -> None:
    log = tmp_path / "run.blf"
    shutil.copy(FOLDER / "axis.blf", log)
    with pytest.raises(LogError, match=r"found no run\.dbc in its folder; write layout\.dbc"):
        tables_of(log)
    (tmp_path / "other.dbc").write_text(logger_files.DBC.replace(" 288 ", " 289 "))
    with pytest.raises(LogError, match=r"no frame that other\.dbc describes; .* 120"):
        tables_of(log, Layout(dbc="other.dbc"))
    (tmp_path / "run.trc").write_text(";$FILEVERSION=2.1\n")
    with pytest.raises(LogError, match=r"no frame that other\.dbc describes; found no data frame"):
        tables_of(tmp_path / "run.trc", Layout(dbc="other.dbc"))
    (tmp_path / "other.dbc").write_text("no DBC")
    with pytest.raises(LogError, match=r"other\.dbc: is not a DBC"):
        tables_of(log, Layout(dbc="other.dbc"))
    shutil.copy(FOLDER / "axis.dbc", tmp_path / "motor.dbc")
    (table,) = tables_of(log, Layout(dbc="motor.dbc"))
    assert table.names == ("encoder", "current")


def test_a_trace_of_pcan_without_a_version_is_read(tmp_path: Path) -> None:
    """Version 1.0 names no version; its line of an error of the bus is no frame."""
    shutil.copy(FOLDER / "axis.dbc", tmp_path / "x.dbc")
    frames = [line.split("#") for line in logger_files.candump().splitlines()]
    rows = [
        f"{k + 1:6d})  {k * 10:8d}      {logger_files.FRAME:04X}  {len(data) // 2}"
        f"  {bytes.fromhex(data).hex(' ')}\r\n"
        for k, (_, data) in enumerate(frames)
    ]
    rows.insert(3, "     4)        35  FFFFFFFF  4  00 00 00 08 -- -- -- -- BUSHEAVY\r\n")
    log = tmp_path / "x.trc"
    log.write_text(
        f";{'#' * 74}\r\n;   C:\\axis.trc\r\n;\r\n;    Start time: 18.12.2021 14:28:07.062\r\n"
        f";    PCAN-Net: N/A\r\n;---+--   ----+----  --+--\r\n{''.join(rows)}",
        newline="",
    )
    (table,) = tables_of(log)
    read = columns(table)
    assert read["encoder"].tolist() == POSITION.tolist()
    assert np.diff(read["at"]) == pytest.approx(np.full(ROWS - 1, 10e6), abs=500)


def test_a_frame_that_is_too_short_is_named(tmp_path: Path) -> None:
    shutil.copy(FOLDER / "axis.dbc", tmp_path / "x.dbc")
    lines = logger_files.candump().splitlines(keepends=True)
    lines[5] = lines[5].replace(lines[5].split("#")[1], "01\n")
    log = tmp_path / "x.candump"
    log.write_text("".join(lines))
    (table,) = tables_of(log)
    with pytest.raises(LogError, match=r"frame at 1700000000\.010000 s of 'AxisState': "):
        columns(table)
    losses: list[DataLoss] = []
    assert columns(table, losses)["encoder"].size == ROWS - 1
    assert [loss.samples for loss in losses] == [1]


@pytest.mark.parametrize("name", ["axis.tdms", "axis.ulg", "axis.blf"])
def test_a_missing_library_names_its_extra(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    form = next(one for one in FORMATS if one.name == FILES[name][0])
    assert form.library is not None
    monkeypatch.setitem(sys.modules, form.library[0], None)
    refused(run("info", FOLDER / name), 3, f"pip install 'frictool[{form.library[1]}]'")
