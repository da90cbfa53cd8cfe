"""`observe run` over a fleet: a row a log, whose units, dates and first logs are told apart; what
is damaged is a row and stops nothing."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from frictool.documents.model import Model
from frictool.logs.fleet import FleetLog, members
from frictool.logs.log import Log, Stream
from frictool.logs.origin import LogName, NamePatterns, as_date, origin_by_name
from frictool.observe.combined_estimator import WearEstimation
from frictool.observe.fleet import observe_logs
from frictool.observe.fleet_table import COLUMNS
from frictool.observe.log_observer import EstimatorFactories, ObservationSettings
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.observe.wear_estimate import WearEstimate
from studies.command_line import CommandResult, run
from studies.rigs.clutch_fleet import Unit, believed
from studies.rigs.fleet_logs import cut, log_of, model_file, save
from tests.support.command_line import also_called, refused

SECONDS = 2.5
DATE = r"\d{4}-\d\d-\d\d"
WEARS = {"U17": (1.05, 1.2, 1.45), "U23": (1.0, 1.02)}


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimpleNamespace]:
    """A model, and a folder of two units' logs, one of a third that is damaged, and what is no
    log."""
    root = tmp_path_factory.mktemp("rig")
    folder = root / "logs"
    for number, (unit, wears) in enumerate(WEARS.items()):
        for month, wear in enumerate(wears, start=1):
            save(
                log_of(Unit(wear=wear), 10 * number + month, SECONDS),
                folder / unit / f"2026-0{month}-03.mcap",
            )
    cut(save(log_of(Unit(), 50, SECONDS), folder / "U31" / "2026-01-09.mcap"))
    (folder / "notes.md").write_text("no log\n")
    (folder / ".hidden.mcap").write_text("no log\n")
    return SimpleNamespace(root=root, folder=folder, model=model_file(root))


def observe(*arguments: str | Path) -> CommandResult:
    return run("observe", "run", *arguments)


def table(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


LIMIT = ("--date", DATE, "--wear-limit", "1.25")


@pytest.fixture(scope="module")
def limited(rig: SimpleNamespace) -> tuple[CommandResult, str]:
    """Observe the folder with a limit; return the result and the table."""
    outputs = ("-o", rig.root / "fleet.csv", "--plot", rig.root / "trend.svg")
    result = observe(rig.model, rig.folder, *LIMIT, *outputs)
    return result, (rig.root / "fleet.csv").read_text()


def test_a_folder_is_a_row_a_log_in_the_order_of_unit_and_date(
    limited: tuple[CommandResult, str],
) -> None:
    result, text = limited
    assert result.code == 1, result.stderr
    assert text.splitlines()[0] == ",".join(COLUMNS)
    rows = table(text)
    assert [(row["unit"], row["date"], row["file"]) for row in rows] == [
        ("U17", "2026-01-03", "U17/2026-01-03.mcap"),
        ("U17", "2026-02-03", "U17/2026-02-03.mcap"),
        ("U17", "2026-03-03", "U17/2026-03-03.mcap"),
        ("U23", "2026-01-03", "U23/2026-01-03.mcap"),
        ("U23", "2026-02-03", "U23/2026-02-03.mcap"),
        ("U31", "2026-01-09", "U31/2026-01-09.mcap"),
    ]
    for row, wear in zip(rows, [*WEARS["U17"], *WEARS["U23"]], strict=False):
        assert abs(float(row["wear"]) / wear - 1.0) < 0.02
        assert float(row["low"]) < float(row["wear"]) < float(row["high"])
        assert int(row["moves"]) > 4
    assert [row["alarm"] for row in rows] == ["false", "false", "true", "false", "false", ""]
    assert "1 could not be read" in result.stdout
    assert "U17/2026-03-03.mcap" in result.stdout
    damaged = rows[-1]
    assert damaged["wear"] == ""
    assert "cut off" in damaged["reason"]


def test_the_first_log_of_a_unit_is_its_commissioning(rig: SimpleNamespace) -> None:
    rows = table(observe(rig.model, rig.folder, "--date", DATE).stdout)
    assert [row["ratio"] == "" for row in rows] == [True, False, False, True, False, True]
    assert float(rows[2]["ratio"]) == pytest.approx(
        float(rows[2]["wear"]) / float(rows[0]["wear"]), rel=1e-12
    )
    assert "first log of its unit" in rows[0]["reason"]
    undated = table(observe(rig.model, rig.folder).stdout)  # nothing says which came first
    assert all(row["ratio"] == "" and row["date"] == "" for row in undated)


def test_a_log_that_tells_no_wear_is_no_commissioning(rig: SimpleNamespace, tmp_path: Path) -> None:
    (moved,) = log_of(Unit(), 90, SECONDS).streams
    signals = {
        "position": moved.signals["position"],
        "current": np.zeros(moved.time.size),
    }  # the sensor's cable is off
    units = {name: moved.units[name] for name in signals}
    save(
        Log((Stream("/axis", moved.time, signals, units),), {}), tmp_path / "U5" / "2026-01-01.mcap"
    )
    for day, wear in ((2, 1.0), (3, 1.3)):
        save(log_of(Unit(wear=wear), 90 + day, SECONDS), tmp_path / "U5" / f"2026-01-0{day}.mcap")
    rows = table(observe(rig.model, tmp_path, "--date", DATE).stdout)
    assert float(rows[0]["wear"]) < 0.1
    assert float(rows[2]["ratio"]) == pytest.approx(
        float(rows[2]["wear"]) / float(rows[1]["wear"]), rel=1e-12
    )


def test_a_commissioning_that_is_given_is_that_of_all(rig: SimpleNamespace, tmp_path: Path) -> None:
    first = rig.folder / "U17" / "2026-01-03.mcap"
    rows = table(observe(rig.model, rig.folder, "--date", DATE, "--commissioning", first).stdout)
    assert float(rows[0]["ratio"]) == pytest.approx(1.0, abs=1e-12)
    assert float(rows[3]["ratio"]) == pytest.approx(
        float(rows[3]["wear"]) / float(rows[0]["wear"]), rel=1e-12
    )


def test_what_the_log_says_of_unit_and_date_comes_first(
    rig: SimpleNamespace, tmp_path: Path
) -> None:
    raw = rig.folder / "U23" / "2026-01-03.mcap"
    named = tmp_path / "logs" / "U99_2026-05-05.mcap"
    named.parent.mkdir()
    assert (
        run("ingest", raw, "--unit", "S 4711", "--date", "2026-04-01T08:15:00", "-o", named).code
        == 0
    )
    by_name = tmp_path / "logs" / "U99_20260505.mcap"
    by_name.write_bytes(raw.read_bytes())
    options = ("--unit", r"(U\d+)_", "--date", r"_(.*)\.mcap")
    rows = table(observe(rig.model, tmp_path / "logs", *options).stdout)
    assert [(row["unit"], row["date"]) for row in rows] == [
        ("S 4711", "2026-04-01T08:15:00"),
        ("U99", "2026-05-05"),
    ]
    result = run("ingest", raw, "--date", "yesterday", "-o", named)
    assert result.code == 2
    assert "allowed: 2026-01-03" in result.stderr


@pytest.mark.parametrize(
    ("option", "told"),
    [
        (
            ("--date", "[0-9]{5}"),
            "--date '[0-9]{5}' matches no name of a log, such as 2026-01-09.mcap",
        ),
        (
            ("--date", "[0-9]{4}(?=-0)"),
            "--date '[0-9]{4}(?=-0)' finds '2026' in 2026-01-09.mcap; this is not a date; "
            "allowed: year, month and day",
        ),
        (("--unit", "S[0-9]"), "--unit 'S[0-9]' matches no name of a log"),
    ],
)
def test_a_pattern_that_tells_nothing_is_told(
    rig: SimpleNamespace, option: tuple[str, str], told: str
) -> None:
    warned = observe(rig.model, rig.folder / "U31", *option)
    assert f"warning: {told}" in warned.stderr
    assert warned.code == 3  # as without: its only log is cut off
    assert (
        "warning: --"
        not in observe(rig.model, rig.folder / "U31", "--date", DATE, "--unit", "2026").stderr
    )
    alone = observe(rig.model, rig.folder / "U31" / "2026-01-09.mcap", *option)
    assert f"warning: {told.partition(',')[0]}".partition(" in ")[0] in alone.stderr


def test_a_recording_s_clock_dates_it(rig: SimpleNamespace, tmp_path: Path) -> None:
    log = log_of(Unit(), 60, SECONDS, time={"epoch_ns": "1767427200000000000", "/axis": "log time"})
    save(log, tmp_path / "logs" / "a.mcap")
    bench = log_of(
        Unit(), 60, SECONDS, time={"epoch_ns": "5000000000", "/axis": "uptime"}
    )  # since it was switched on
    save(bench, tmp_path / "logs" / "b.mcap")
    rows = table(observe(rig.model, tmp_path / "logs").stdout)
    assert {row["file"]: row["date"] for row in rows} == {
        "a.mcap": "2026-01-03T08:00:00Z",
        "b.mcap": "",
    }


def test_dates_are_read_however_they_are_written() -> None:
    for text, date in (
        ("2026-01-03", "2026-01-03"),
        ("20260103", "2026-01-03"),
        ("2026_01_03 08h15", "2026-01-03T08:15:00"),
        ("20260103-081530", "2026-01-03T08:15:30"),
        ("2026-13-03", None),
        ("4711", None),
        ("", None),
    ):
        assert as_date(text) == date


def test_the_groups_of_a_pattern_are_what_counts() -> None:
    name = LogName("B/AB-12 of 2026.03.01.csv", "B")
    for date in (r"(\d{4})\.(\d\d)\.(\d\d)", r"of (\d{4}\.\d\d\.\d\d)", r"\d{4}\.\d\d\.\d\d"):
        assert origin_by_name(name, NamePatterns(r"[A-Z]+-(\d+)", date)).date == "2026-03-01"
    assert origin_by_name(name, NamePatterns(r"[A-Z]+-(\d+)")).unit == "12"


def test_parquet_holds_the_same_with_types(
    rig: SimpleNamespace, limited: tuple[CommandResult, str], tmp_path: Path
) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    assert observe(rig.model, rig.folder, *LIMIT, "-o", tmp_path / "fleet.parquet").code == 1
    held = parquet.read_table(tmp_path / "fleet.parquet")
    assert tuple(held.column_names) == COLUMNS
    rows = held.to_pylist()
    for row, text in zip(rows, table(limited[1]), strict=True):
        assert row["file"] == text["file"]
        assert ("" if row["wear"] is None else repr(row["wear"])) == text["wear"]
        assert ("" if row["alarm"] is None else str(row["alarm"]).lower()) == text["alarm"]
        assert str(row["date"].date()) == text["date"]
    assert b"command" in held.schema.metadata


def test_the_machine_s_view_has_what_each_run_alone_prints(rig: SimpleNamespace) -> None:
    result = observe(rig.model, rig.folder, "--date", DATE, "--wear-limit", "1.25", "--json")
    facts = json.loads(result.stdout)
    assert result.code == 1
    assert [row["read"] for row in facts["logs"]] == [True] * 5 + [False]
    assert (facts["above_limit"], facts["not_read"], facts["data_lost"]) == (
        1,
        1,
        0,
    )  # the exit code is that of the alarm
    alone = json.loads(observe(rig.model, rig.folder / "U17" / "2026-03-03.mcap", "--json").stdout)
    assert facts["logs"][2]["wear"] == alone["wear"]
    assert facts["logs"][2]["velocity_rms"] == alone["velocity_rms"]


def test_a_lost_log_is_told_by_the_exit_code_where_nothing_is_worn(
    rig: SimpleNamespace, tmp_path: Path
) -> None:
    logs = [rig.folder / "U23" / "2026-01-03.mcap", rig.folder / "U31" / "2026-01-09.mcap"]
    result = observe(rig.model, *logs, "--wear-limit", "1.25", "-o", tmp_path / "fleet.csv")
    assert result.code == 3
    assert len(table((tmp_path / "fleet.csv").read_text())) == 2
    assert observe(rig.model, logs[0], logs[0], "-o", tmp_path / "once.csv").code == 0
    assert len(table((tmp_path / "once.csv").read_text())) == 1  # a log that is named twice is one
    salvaged = observe(rig.model, *logs, "--salvage", "-o", tmp_path / "salvaged.csv")
    assert salvaged.code == 3
    assert "2 logs, 1 read with data lost" in salvaged.stdout
    assert "data lost" in table((tmp_path / "salvaged.csv").read_text())[1]["reason"]


def test_the_trend_is_drawn_over_the_date_with_the_limit(
    rig: SimpleNamespace, limited: tuple[CommandResult, str], tmp_path: Path
) -> None:
    pages = set()
    for _ in range(2):
        observe(rig.model, rig.folder, *LIMIT, "--plot", tmp_path / "trend.html")
        pages.add((tmp_path / "trend.html").read_bytes())
    (html,) = pages
    for page in ((rig.root / "trend.svg").read_bytes(), html):
        for text in ("U17", "U23", "wear relative to commissioning [1]"):
            assert f">{text}<" in page.decode()
    observe(
        rig.model,
        rig.folder / "U17" / "2026-01-03.mcap",
        "-o",
        tmp_path / "one.csv",
        "--plot",
        tmp_path / "one.svg",
    )
    alone = re.findall(r">([^<>]*)</text>", (tmp_path / "one.svg").read_text())
    assert "wear [1]" in alone
    assert alone[: alone.index("log, in the table's order")] == ["1"]  # places are whole numbers


def test_what_an_earlier_run_wrote_into_the_folder_is_no_log(
    rig: SimpleNamespace, tmp_path: Path
) -> None:
    folder = tmp_path / "logs"
    save(log_of(Unit(), 70, SECONDS), folder / "a.mcap")
    for _ in range(2):
        assert observe(rig.model, folder, "-o", folder / "fleet.csv").code == 0
        assert [row["file"] for row in table((folder / "fleet.csv").read_text())] == ["a.mcap"]
    (folder / "b.csv").write_text("time,encoder,current\n0,1,2\n")
    refused(
        observe(rig.model, folder, "-o", folder / "b.csv"),
        3,
        "b.csv: is an input of this command and would be overwritten",
    )


def test_refusals_are_one_line(rig: SimpleNamespace, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    refused(observe(rig.model, tmp_path / "empty"), 3, "contains no log")
    for arguments, word in (
        (("-o", tmp_path / "fleet.mcap"), "several logs give a table"),
        (
            ("-o", tmp_path / "a.csv", "--plot", tmp_path / "a.csv"),
            "allowed endings: .svg, .html or .htm",
        ),
        (("--observer", rig.model), "works with one log only"),
        (("--cores", "2", "--cluster", "tcp://127.0.0.1:1"), "--cores applies to this machine"),
    ):
        result = observe(rig.model, rig.folder, *arguments)
        assert result.code == 2
        assert word in result.stderr
    first = rig.folder / "U17" / "2026-01-03.mcap"
    assert "need several logs" in observe(rig.model, first, "--cores", "2").stderr
    both = tmp_path / "same.svg"
    assert (
        "same name"
        in observe(rig.model, first, "-o", also_called(both, ".mcap"), "--plot", both).stderr
    )


class Deadly(WearEstimator):
    """An estimator whose process the system ends, as where memory is short, where the log is a
    short one."""

    def take(self, piece: MotionBlock) -> list[WearEstimate]:
        if piece.time[-1] < SECONDS - 1.0:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().take(piece)


def deadly(model: Model, confidence: float) -> WearEstimation:
    return Deadly(model, confidence=confidence)


def test_processes_change_nothing_and_one_that_is_ended_loses_its_own_log_only(
    rig: SimpleNamespace, tmp_path: Path
) -> None:
    short = save(log_of(Unit(), 80, 1.0), tmp_path / "short.mcap")
    fleet = [members([rig.folder])[0], FleetLog(short, LogName("short.mcap"))]
    found = observe_logs(
        fleet, believed(), ObservationSettings(), EstimatorFactories(wear=deadly), cores=2
    )
    assert found[:1] == observe_logs(fleet[:1], believed(), ObservationSettings(), cores=1)
    assert found[1].outcome is None
    assert "ended" in found[1].reason
