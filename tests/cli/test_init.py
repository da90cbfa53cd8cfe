"""`frictool init`: documents that load, columns guessed from a log, a Makefile that chains, nothing overwritten."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.bench import Bench
from frictool.documents.design import Design
from frictool.documents.registry import DOCUMENTS, load, same_axis
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.documents.starter import FILES, Start, quoted, starting_documents
from frictool.logs.reading import read_log
from tests.cli.run import refused, run

ROOT = Path(__file__).parents[2]
LOG = ROOT / "sample_logs/sines.csv"
KINDS = {"bench.yaml": Bench, "spec.yaml": Spec, "designs/speed.yaml": Design, "scenarios/steps.yaml": Scenario}
COMMON = "# Everything below is the same for every rig"


def loaded(folder: Path) -> dict[Path, object]:
    """Every document of the folder, read strictly."""
    return {folder / name: load(folder / name, kind) for name, kind in KINDS.items()}


def bench_of(folder: Path) -> Bench:
    return load(folder / "bench.yaml", Bench)


@pytest.mark.parametrize("axis", ["rotary", "linear"])
def test_documents_load_and_agree(axis: str, tmp_path: Path) -> None:
    folder = tmp_path / "deep/my rig"
    result = run("init", folder, "--axis", axis)
    assert result.code == 0
    assert sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()) == sorted(FILES)
    documents = loaded(folder)
    same_axis(documents)
    assert bench_of(folder).axis == axis
    assert bench_of(folder).name == "my rig"
    assert {path.name for path in (tmp_path / "deep").iterdir()} == {"my rig"}
    assert "guessed" not in (folder / "bench.yaml").read_text()


def test_a_log_fills_in_what_it_tells(tmp_path: Path) -> None:
    folder = tmp_path / "rig"
    result = run("init", folder, "--from", LOG, "--json")
    assert result.code == 0
    said = json.loads(result.stdout)
    assert said["files"] == list(FILES)
    assert (said["axis"], said["sample_period_s"], said["log"]) == ("rotary", 0.001, "sines.csv")
    bench = bench_of(folder)
    assert {channel: (c.column, c.unit) for channel, c in bench.columns.items()} == {
        "time": ("time", "s"),
        "position": ("encoder", "count"),
        "current": ("current", "A"),
    }
    lines = (folder / "bench.yaml").read_text().splitlines()
    for key in ("axis:", "sample_period_s:", "  drive:", "  time:", "  position:", "  current:"):
        (line,) = [line for line in lines if line.startswith(key)]
        assert "# guessed from sines.csv: check" in line
    assert read_log(LOG, bench).main.time.size == len(LOG.read_text().splitlines()) - 1


def test_a_matlab_file_gives_names_period_and_step(tmp_path: Path) -> None:
    log = tmp_path / "bench.mat"
    k = np.arange(400)
    position = 2e-6 * np.rint(1e4 * np.sin(k / 30))
    values = {"t": k * 2e-3, "qm": position, "qg": position + 1e-3, "vir": np.cos(k / 30), "spare": k % 7 + 0.5, "gain": 3.0}
    scipy.io.savemat(log, values)
    assert run("init", tmp_path / "rig", "--from", log, "--axis", "linear").code == 0
    bench = bench_of(tmp_path / "rig")
    assert {channel: (c.column, c.unit) for channel, c in bench.columns.items()} == {
        "time": ("t", "s"),
        "position": ("qm", "m"),
        "reference": ("qg", "m"),
        "voltage": ("vir", "V"),
    }
    assert (bench.sample_period_s, bench.actuator.drive) == (0.002, "voltage")
    assert bench.encoder.resolution == pytest.approx(2e-6)
    assert "# spare" in (tmp_path / "rig/bench.yaml").read_text()
    same_axis(loaded(tmp_path / "rig"))
    np.testing.assert_allclose(read_log(log, bench).main.signals["position"], position)


def test_an_ingested_log_is_as_good(tmp_path: Path) -> None:
    assert run("ingest", LOG, "--bench", ROOT / "configs/clutch/bench.yaml", "-o", tmp_path / "sines.mcap").code == 0
    assert run("init", tmp_path / "rig", "--from", tmp_path / "sines.mcap").code == 0
    bench = bench_of(tmp_path / "rig")
    assert (bench.axis, bench.sample_period_s, bench.actuator.drive) == ("rotary", 0.001, "current")
    assert bench.encoder.resolution == pytest.approx(2 * np.pi / 56, rel=1e-5)
    assert "LOGS := ../sines.mcap\n" in (tmp_path / "rig/Makefile").read_text()


@pytest.mark.parametrize(
    ("header", "axis", "columns"),
    [
        ("t [ms],shaft angle [deg],I_q [mA]", "rotary", {"time": "ms", "position": "deg", "current": "mA"}),
        (
            "Time [s];Position reference [mm];Position [mm];Speed [mm/s]",
            "linear",
            {"reference": "mm", "position": "mm", "velocity": "mm/s"},
        ),
        ("t,u,theta", "rotary", {"voltage": "V", "position": "count"}),
        ("when [s],what [rad],why [A]", "rotary", {"time": "s", "position": "rad", "current": "A"}),
        ("a,b,c", "rotary", {}),
    ],
)
def test_units_are_believed_before_names(header: str, axis: str, columns: dict[str, str], tmp_path: Path) -> None:
    log = tmp_path / "bench.csv"
    mark = ";" if ";" in header else ","
    rows = [mark.join(str(value) for value in (k, *(k % 5 + shift for shift in range(header.count(mark))))) for k in range(20)]
    log.write_text("\n".join([header, *rows]) + "\n")
    assert run("init", tmp_path / "rig", "--from", log).code == 0
    bench = bench_of(tmp_path / "rig")
    assert bench.axis == axis
    found = {channel: column.unit for channel, column in bench.columns.items()}
    if columns:
        assert columns.items() <= found.items()
    same_axis(loaded(tmp_path / "rig"))


def test_a_period_that_no_bench_has_is_not_guessed(tmp_path: Path) -> None:
    """Time in microseconds under a name without a unit: the document loads all the same, with the example's period."""
    log = tmp_path / "bench.csv"
    log.write_text("t,theta [rad],u\n" + "".join(f"{1000 * k},{k % 7},{k % 3}\n" for k in range(50)))
    assert run("init", tmp_path / "rig", "--from", log).code == 0
    assert bench_of(tmp_path / "rig").sample_period_s == 0.001


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "designs").mkdir()
    (tmp_path / "designs/speed.yaml").write_text("mine")
    (tmp_path / "spec.yaml").write_text("mine")
    refused(run("init", tmp_path), 3, "spec.yaml", "designs/speed.yaml", "nothing is overwritten")
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")) == ["designs", "designs/speed.yaml", "spec.yaml"]
    assert (tmp_path / "spec.yaml").read_text() == "mine"


def test_same_inputs_same_bytes(tmp_path: Path) -> None:
    for name in ("one/rig", "two/rig"):
        assert run("init", tmp_path / name, "--axis", "linear").code == 0
    for name in FILES:
        assert (tmp_path / "one/rig" / name).read_bytes() == (tmp_path / "two/rig" / name).read_bytes()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"\x00\x01\x02" * 50, "binary"),
        (b"\x89MCAP0\r\n" + bytes(100), "log.csv"),
        (b"time [s],x [m]\n0,1\n1,\n", "an empty cell"),
    ],
)
def test_a_bad_log_leaves_no_folder(content: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_bytes(content)
    refused(run("init", tmp_path / "rig", "--from", tmp_path / "log.csv"), 3, "log.csv", words)
    refused(run("init", tmp_path / "rig", "--from", tmp_path / "missing.csv"), 3, "no such file")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.csv"]


@given(st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=30), st.text(min_size=1, max_size=10))
def test_any_name_and_column_survives(tmp_path_factory: pytest.TempPathFactory, name: str, column: str) -> None:
    name, column = (text.encode("utf-8", "replace").decode() for text in (name, column))
    start = Start(name, "linear", log=column, columns={"position": (column, "m")}, left=(column, name))
    folder = tmp_path_factory.mktemp("rig")
    (folder / "bench.yaml").write_text(starting_documents(start)["bench.yaml"], newline="\n")
    bench = bench_of(folder)
    assert (bench.name, bench.columns["position"].column) == (name, column)


@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_quoted_text_is_one_line(text: str) -> None:
    assert "\n" not in quoted(text)


@pytest.mark.skipif(shutil.which("make") is None, reason="there is no make on the PATH")
def test_the_makefile_chains_the_commands(tmp_path: Path) -> None:
    rig = tmp_path / "rig"
    assert run("init", rig, "--from", LOG).code == 0
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    plan = subprocess.run(["make", "-n", "demo"], cwd=rig, env=environment, check=True, capture_output=True, text=True).stdout
    commands = [line.split()[1] for line in plan.splitlines() if line.startswith("frictool ")]
    assert commands == ["ingest", "identify", "synth", "export", "simulate", "report", "report"]
    subprocess.run(["make", "build/logs/sines.mcap"], cwd=rig, env=environment, check=True, capture_output=True)
    assert (rig / "build/logs/sines.mcap").stat().st_size > 0
    again = subprocess.run(["make", "-n", "demo"], cwd=rig, env=environment, check=True, capture_output=True, text=True).stdout
    assert "frictool ingest" not in again


@pytest.mark.parametrize("blank", [True, False])
def test_a_path_that_make_cannot_read_is_told(blank: bool, tmp_path: Path) -> None:
    log = tmp_path / ("my log.csv" if blank else "log.csv")
    shutil.copy(LOG, log)
    result = run("init", tmp_path / "rig", "--from", log)
    assert result.code == 0
    assert ("make cannot read" in result.stderr) == blank
    makefile = (tmp_path / "rig/Makefile").read_text()
    assert ("LOGS := ../log.csv\n" in makefile) != blank
    assert ("$(wildcard logs/" in makefile) == blank


def test_the_rigs_share_the_makefile_that_init_writes() -> None:
    bodies = {path.read_text().partition(COMMON)[2] for path in (ROOT / "configs").glob("*/Makefile")}
    bodies.add(starting_documents(Start("rig", "rotary"))["Makefile"].partition(COMMON)[2])
    assert len(bodies) == 1
    assert len(bodies.pop()) > 1000


def test_every_kind_of_document_that_a_rig_writes_by_hand_is_there() -> None:
    assert set(KINDS.values()) == {DOCUMENTS[name] for name in ("bench", "spec", "design", "scenario")}
