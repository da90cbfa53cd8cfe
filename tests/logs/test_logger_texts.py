"""Golden files of loggers in text, and of MATLAB timetables: values, units and times against the
writers; damage of headers and rows."""

from __future__ import annotations

import importlib.util
import re
import shutil
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from frictool.errors import LogError
from frictool.logs.channels.column_guess import guess_from
from frictool.logs.formats import format_of, tables_of
from frictool.logs.raw_table import DataLoss, RawTable
from frictool.typing import Vector
from studies.command_line import run
from tests.support.example_logs import GOLDEN
from tests.support.logger_files import CURRENT, PERIOD_MS, POSITION, ROWS
from tests.support.logger_texts import TEXTS

FOLDER = GOLDEN / "loggers"
LIBRARIES = {"can": "can", "mat": "matio", "mat73": "matio"}  # of the formats with an extra


class Golden(NamedTuple):
    """Facts of a golden file.

    time: column with the times and its number of units in a second; "" for times of the rows.
    columns: column -> unit in the file, and factor from its numbers to those of the writer.
    """

    form: str
    time: tuple[str, float]
    columns: dict[str, tuple[str | None, float]]


FILES = {
    "twincat.txt": Golden("csv", ("Time", 1000.0), {"encoder": (None, 1.0), "current": ("A", 1.0)}),
    "siemens.csv": Golden(
        "csv",
        ("Time", 1000.0),
        {"Drive_1.encoder": (None, 1.0), "Drive_1.current": (None, 1.0)},
    ),
    "tektronix.csv": Golden("csv", ("Time", 1.0), {"CH1": ("A", 1.0)}),
    "rigol.csv": Golden("csv", ("", 1.0), {"CH1": ("V", 1.0), "CH2": ("A", 1.0)}),
    "picoscope.csv": Golden(
        "csv", ("Time", 1000.0), {"encoder": ("V", 1.0), "current": ("mA", 1e-3)}
    ),
    "labview.lvm": Golden("csv", ("", 1.0), {"encoder": ("mm", 1.0), "current": ("A", 1.0)}),
    "pcan.trc": Golden("can", ("", 1.0), {"encoder": ("count", 1.0), "current": ("A", 1.0)}),
    "axis.jsonl": Golden(
        "jsonl", ("", 1.0), {"axis.encoder": (None, 1.0), "axis.current": (None, 1.0)}
    ),
    "timetable_v7.mat": Golden("mat", ("", 1.0), {"encoder": (None, 1.0), "current": (None, 1.0)}),
    "timetable_v7.3.mat": Golden(
        "mat73", ("", 1.0), {"encoder": (None, 1.0), "current": (None, 1.0)}
    ),
}


@pytest.fixture(params=FILES)
def name(request: pytest.FixtureRequest) -> str:
    """The name of a golden file whose library is installed."""
    found: str = request.param
    library = LIBRARIES.get(FILES[found].form)
    if library is not None and importlib.util.find_spec(library) is None:
        pytest.skip(f"{library} is not installed")
    return found


def copied(name: str, folder: Path, data: bytes | None = None) -> Path:
    """A copy of a golden file, or a file of its name with `data`; with the DBC beside it."""
    path = folder / name
    path.write_bytes((FOLDER / name).read_bytes() if data is None else data)
    shutil.copy(FOLDER / "axis.dbc", path.with_suffix(".dbc"))
    return path


def columns(
    table: RawTable, names: list[str], losses: list[DataLoss] | None = None
) -> tuple[dict[str, Vector], Vector | None]:
    """The columns `names` of a table, and the times of its rows in s."""
    blocks = [block for block, _ in table.blocks(names, losses)]
    if not blocks:
        return {name: np.empty(0) for name in names}, None
    times = [block.time_ns for block in blocks if block.time_ns is not None]
    read = {name: np.concatenate([block.columns[name] for block in blocks]) for name in names}
    return read, np.concatenate(times) / 1e9 if times else None


def test_the_golden_file_is_that_of_its_writer() -> None:
    for name, text in TEXTS.items():
        assert (FOLDER / name).read_bytes() == text().encode()


def test_a_golden_file_has_the_values_of_its_writer(name: str, tmp_path: Path) -> None:
    golden = FILES[name]
    path = copied(name, tmp_path)
    assert format_of(path).name == golden.form
    (table,) = tables_of(path)
    wanted = [*golden.columns, *filter(None, [golden.time[0]])]
    read, times = columns(table, wanted)
    for column, (unit, factor) in golden.columns.items():
        assert table.units[column] == unit
        written = POSITION if len(golden.columns) > 1 and column in next_to(golden) else CURRENT
        assert factor * read[column] == pytest.approx(written, abs=1e-9)
    if golden.time[0]:
        times = read[golden.time[0]] / golden.time[1]
    assert times is not None
    assert times - times[0] == pytest.approx(PERIOD_MS / 1000 * np.arange(ROWS), abs=5e-7)


def next_to(golden: Golden) -> list[str]:
    """The column of the position, which comes before that of the current."""
    return list(golden.columns)[:1]


def test_the_command_line_reads_each_file(name: str, tmp_path: Path) -> None:
    """The guess takes no wrong column; what it asks for is written by hand."""
    path, bench = copied(name, tmp_path), tmp_path / "bench.yaml"
    made = run("ingest", "--guess", path, "--axis", "rotary", "-o", bench)
    assert made.code == 0, made.stderr
    head = bench.read_text().partition("\ncolumns:")[0].partition("\nlayout:")[0]
    position = next_to(FILES[name])[0]
    bench.write_text(f"{head}\ncolumns:\n  position: {{column: {position}, unit: deg}}\n")
    done = run("ingest", path, "--bench", bench, "-o", tmp_path / "log.mcap")
    foreign = FILES[name].columns[position][0] not in (None, "deg")
    assert (done.code, "is in" in done.stderr) == ((3, True) if foreign else (0, False))


def test_a_file_that_is_cut_is_refused_and_salvaged(name: str, tmp_path: Path) -> None:
    path = copied(name, tmp_path, (FOLDER / name).read_bytes()[:-27])  # within a row
    column = next_to(FILES[name])[0]
    message = error_of(lambda: columns(tables_of(path)[0], list(FILES[name].columns)))
    assert message is not None
    assert re.search(r"damaged|cut|incomplete|line end|no JSON|cells|end of", message), message
    if error_of(lambda: tables_of(path)) is not None:
        return  # nothing of the file can be read, and a line says so
    losses: list[DataLoss] = []
    read, _ = columns(tables_of(path)[0], [column], losses)
    assert losses
    written = POSITION if len(FILES[name].columns) > 1 else CURRENT
    assert read[column] == pytest.approx(written[: read[column].size], abs=1e-9)


@pytest.mark.parametrize("part", ["header", "file", "cut"])
@pytest.mark.parametrize("count", [1, pytest.param(60, marks=pytest.mark.accept)])
def test_damage_is_one_line(name: str, part: str, count: int, tmp_path: Path) -> None:
    """Bytes changed at random, in the header or anywhere, and files cut anywhere: each file is
    read or refused in one line, in bounded time, and no table has more rows than the file."""
    data = np.frombuffer((FOLDER / name).read_bytes(), np.uint8)
    rng = np.random.default_rng(20261128)
    for _ in range(count):
        changed = data.copy()
        if part == "cut":
            changed = changed[: rng.integers(1, data.size)]
        else:
            at = rng.integers(0, data.size // (3 if part == "header" else 1), 4)
            changed[at] = rng.integers(0, 256, 4)
        path = copied(name, tmp_path, changed.tobytes())
        began = time.process_time()
        for message in (error_of(partial(guess_from, path, "rotary")), salvage_error(path)):
            assert message is None or not re.search(r"\n|Traceback", message)
        assert time.process_time() - began < 5.0


def error_of(read: Callable[[], object]) -> str | None:
    """The message with which `read` refuses a file; None if it does not."""
    try:
        read()
    except LogError as error:
        return str(error)
    return None


def salvage_error(path: Path) -> str | None:
    """The message with which a file is refused that is read with its losses."""

    def read() -> None:
        for table in tables_of(path):
            found, _ = columns(table, list(table.names), [])
            assert all(values.size <= 2 * ROWS for values in found.values())

    return error_of(read)
