"""Logs of historians: a row or a cell only when a value changes (`layout.hold`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from frictool.documents.bench import Column, Layout
from frictool.errors import LogError
from frictool.logs.channels.deadband import deadband
from frictool.logs.channels.latched_table import MOST_HELD
from frictool.logs.log import Log
from frictool.logs.raw_table import RowBlock
from frictool.logs.text.csv_format import CsvTable
from frictool.logs.text.held_cells import HeldCells
from tests.support.example_logs import bench, mapped

PERIOD = 0.02  # s
COLUMNS = {"position": Column("PV", "deg"), "current": Column("I", "A")}


def exported(seed: int, deadband_a: float = 0.0) -> tuple[np.ndarray, list[str]]:
    """Samples (n, 2) of an axis that moves in strokes, and the lines of its historian.

    deadband_a: change of the current in A that the historian leaves out.
    """
    rng = np.random.default_rng(seed)
    strokes = np.repeat(rng.choice([-1.0, 0.0, 1.0], 12), 40)
    position = np.round(np.cumsum(strokes * rng.uniform(0.1, 2.0)), 1)
    current = np.round(strokes + rng.normal(0.0, 0.05, strokes.size), 2)
    true, lines, last = np.column_stack([position, current]), ["Time [s],PV,I"], [np.inf, np.inf]
    for k, row in enumerate(true):
        cells = [f"{row[0]:.1f}" if row[0] != last[0] else "", ""]
        if abs(row[1] - last[1]) > deadband_a + 1e-9:
            cells[1] = f"{row[1]:.2f}"
        last = [one if cell else old for one, cell, old in zip(row, cells, last, strict=True)]
        if any(cells):
            lines.append(",".join([f"{1.7e9 + PERIOD * k:.2f}", *cells]))
    return true, lines


def read(path: Path, lines: list[str], hold: bool = True) -> Log:
    path.write_text("\n".join(lines) + "\n")
    layout = Layout(hold=hold)
    columns = {"time": Column("Time", "s"), **COLUMNS}
    rig = replace(bench(columns, sample_period_s=PERIOD), layout=layout)
    return mapped(CsvTable(path, layout), rig)


@pytest.mark.parametrize("seed", range(3))
def test_the_samples_are_those_before_the_compression(seed: int, tmp_path: Path):
    true, lines = exported(seed)
    assert len(lines) < true.shape[0]
    log = read(tmp_path / "trend.csv", lines)
    n = log.main.time.size
    assert true.shape[0] - n < 10  # the historian writes no row for the rest at the end
    assert np.diff(log.main.time) == pytest.approx(PERIOD, rel=1e-4)
    assert np.degrees(log.main.signals["position"]) == pytest.approx(true[:n, 0])
    assert log.main.signals["current"] == pytest.approx(true[:n, 1])
    assert not any("deadband" in text for text in log.warnings)


def test_a_deadband_is_named_and_bounds_the_error(tmp_path: Path):
    true, lines = exported(7, deadband_a=0.04)
    log = read(tmp_path / "trend.csv", lines)
    error = np.abs(log.main.signals["current"] - true[: log.main.time.size, 1]).max()
    assert 0.0 < error <= 0.04 + 1e-9
    assert any("'I' has steps of 0.01, but no change below 0.05" in text for text in log.warnings)
    assert deadband(true[:, 1]) is None
    full = ["Time [s],PV,I"]  # a row for each sample, in which held values are repeated
    seen = log.main.signals["current"]
    full += [f"{1.7e9 + PERIOD * k:.2f},{k / 10:.1f},{one:.2f}" for k, one in enumerate(seen)]
    again = read(tmp_path / "full.csv", full, hold=False)
    assert any("no change below 0.05" in text for text in again.warnings)


def test_coarse_or_few_changes_are_no_deadband():
    """Noise of 30 steps has hardly a small change in 50 samples; a speed may be rounded twice."""
    rng = np.random.default_rng(3)
    noise = np.round(rng.normal(0.0, 30.0, 5000))
    assert all(deadband(noise[k : k + 50]) is None for k in range(0, 5000, 50))
    assert deadband(np.floor(2.5 * np.round(rng.normal(0.0, 8.0, 5000)))) is None


def test_cells_are_held_only_where_the_bench_says_so(tmp_path: Path):
    _, lines = exported(1)
    with pytest.raises(LogError, match=r"an empty cell; allowed: a number, or layout.hold: true"):
        read(tmp_path / "trend.csv", lines, hold=False)
    lines[5] = lines[5].rpartition(",")[0] + ",bad"  # a text is damage, not an unchanged value
    with pytest.raises(LogError, match=r"trend.csv:6: column 'I': found 'bad'"):
        read(tmp_path / "trend.csv", lines)


def test_values_are_held_from_block_to_block():
    cells = HeldCells()
    nan = np.nan
    first = RowBlock(0, {"a": np.array([nan, 1.0, nan, 2.0]), "b": np.array([3.0, nan, nan, nan])})
    filled = cells.fill(first)
    assert filled is not None
    assert filled.first_row == 1  # the first row has no value of a
    assert filled.columns["a"].tolist() == [1.0, 1.0, 2.0]
    assert filled.columns["b"].tolist() == [3.0, 3.0, 3.0]
    filled = cells.fill(RowBlock(4, {"a": np.array([nan, 5.0]), "b": np.array([nan, nan])}))
    assert filled is not None
    assert filled.columns["a"].tolist() == [2.0, 5.0]
    assert filled.columns["b"].tolist() == [3.0, 3.0]


@pytest.mark.parametrize(
    ("step", "words"),
    [(MOST_HELD * PERIOD + 1.0, "between two rows"), (-5.0, "not increase")],
)
def test_a_wrong_time_is_refused(step: float, words: str, tmp_path: Path):
    _, lines = exported(2)
    for k in range(20, len(lines)):
        time, _, rest = lines[k].partition(",")
        lines[k] = f"{float(time) + step:.2f},{rest}"
    with pytest.raises(LogError, match=words):
        read(tmp_path / "trend.csv", lines)


def test_whole_seconds_do_not_tell_the_rows_apart(tmp_path: Path):
    _, lines = exported(3)
    coarse = [f"{float(line.partition(',')[0]):.0f},{line.partition(',')[2]}" for line in lines[1:]]
    with pytest.raises(LogError, match=r"write layout.period_s"):
        read(tmp_path / "trend.csv", [lines[0], *coarse])
