"""`ingest` and `info` from the command line."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.example_logs import ROOT, as_bytes, golden_log, measured, same

CLUTCH = ROOT / "configs" / "clutch" / "bench.yaml"
SINES = ROOT / "sample_logs" / "sines.csv"
STEPS = ROOT / "sample_logs" / "steps.csv"
GOOD = "time [s],encoder [count],current [A]\n" + "".join(
    f"{k / 1000:.3f},{k},{k / 10}\n" for k in range(50)
)


@pytest.fixture
def raw(tmp_path: Path) -> Path:
    path = tmp_path / "raw.csv"
    path.write_text(GOOD)
    return path


def test_ingest_and_info(tmp_path: Path):
    target = tmp_path / "log.mcap"
    result = run("ingest", STEPS, "--bench", CLUTCH, "-o", target)
    assert (result.code, result.stderr) == (0, "")
    assert "/axis: position [rad], current [A], effort [N m]" in result.stdout
    shown = run("info", target)
    assert shown.code == 0
    assert "encoder step: 0.1122 rad\n" in shown.stdout
    facts = json.loads(run("info", target, "--json").stdout)
    assert {row["name"]: row["unit"] for row in facts["channels"]} == {
        "position": "rad",
        "current": "A",
        "effort": "N m",
    }
    for row in facts["channels"]:
        assert row["source"] == "/axis"
        assert row["rate_hz"] == pytest.approx(1000.0)
        assert row["jitter_s"] == pytest.approx(0.0, abs=1e-12)
        assert row["gaps"] == 0
    assert facts["encoder_step"] == pytest.approx(2 * np.pi / 56)
    assert facts["lost"] == []
    assert facts["duration_s"] == pytest.approx((facts["channels"][0]["samples"] - 1) / 1000.0)


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        (lambda k: 0, "unknown: the position does not change"),
        (
            lambda k: k % 3,
            "unknown: the position has only 3 different values; at least 8 are needed",
        ),
        (lambda k: k + (k % 7) ** 0.5, "none: the positions are not multiples of a step"),
    ],
)
def test_info_says_why_no_encoder_step_is_seen(
    tmp_path: Path, counts: Callable[[int], float], words: str
):
    path = tmp_path / "raw.csv"
    rows = [f"{k / 1000:.3f},{counts(k)},0.1" for k in range(50)]
    path.write_text("\n".join(["time [s],encoder [count],current [A]", *rows]) + "\n")
    shown = run("info", path, "--bench", CLUTCH)
    assert f"encoder step: {words}" in shown.stdout


def test_the_same_inputs_give_the_same_bytes_on_file_and_stdout(raw: Path, tmp_path: Path):
    one, other = tmp_path / "one.mcap", tmp_path / "sub" / "other.mcap"
    other.parent.mkdir()
    assert run("ingest", raw, "--bench", CLUTCH, "-o", one).code == 0
    assert run("ingest", raw, "--bench", CLUTCH, "-o", other).code == 0
    piped = run("ingest", raw, "--bench", CLUTCH, "-o", "-", "--json")
    assert one.read_bytes() == other.read_bytes() == piped.out
    assert json.loads(piped.stderr)["streams"][0]["samples"] == 50


def test_a_device_is_written_to_and_not_replaced(raw: Path):
    full = Path("/dev/full")
    if not full.is_char_device():
        pytest.skip("no /dev/full on this machine")
    refused(
        run("ingest", raw, "--bench", CLUTCH, "-o", full),
        3,
        "/dev/full: cannot be written: No space left on device",
    )
    assert full.is_char_device()


def test_a_link_stays_a_link(raw: Path, tmp_path: Path):
    link, target = tmp_path / "link.mcap", tmp_path / "real.mcap"
    link.symlink_to(target)
    for _ in range(2):  # first it leads nowhere
        assert run("ingest", raw, "--bench", CLUTCH, "-o", link).code == 0
        assert link.is_symlink()
        assert read_mcap(target).main.time.size == 50


def test_provenance_has_names_and_digests_and_no_path(raw: Path, tmp_path: Path):
    target = tmp_path / "log.mcap"
    run("ingest", raw, "--bench", CLUTCH, "-o", target)
    provenance = read_mcap(target).metadata["provenance"]
    assert provenance["command"] == "frictool ingest raw.csv --bench bench.yaml"
    assert provenance["input_1"] == f"raw.csv sha256:{hashlib.sha256(raw.read_bytes()).hexdigest()}"
    assert str(tmp_path) not in target.read_bytes().decode("latin-1")


def test_several_files_of_a_rig(tmp_path: Path):
    target = tmp_path / "log.mcap"
    result = run("ingest", SINES, STEPS, "--bench", CLUTCH, "-o", target, "--json")
    assert [stream["topic"] for stream in json.loads(result.stdout)["streams"]] == [
        "/axis",
        "/axis/steps",
    ]
    alone = tmp_path / "steps.mcap"
    run("ingest", STEPS, "--bench", CLUTCH, "-o", alone)
    assert np.array_equal(
        read_mcap(target).streams[1].signals["position"], read_mcap(alone).main.signals["position"]
    )


def test_a_canonical_log_passes_through_unmapped(tmp_path: Path):
    source, target = tmp_path / "source.mcap", tmp_path / "target.mcap"
    source.write_bytes(as_bytes(golden_log()))
    assert run("ingest", source, "--bench", CLUTCH, "-o", target).code == 0
    found = read_mcap(target)
    assert (
        found.metadata["provenance"]["command"] == "frictool ingest source.mcap --bench bench.yaml"
    )
    found.metadata["provenance"] = golden_log().metadata["provenance"]
    assert same(found, golden_log())


def test_the_measured_machine(tmp_path: Path):
    target = tmp_path / "emps.mcap"
    bench = ROOT / "configs" / "emps" / "bench.yaml"
    assert run("ingest", measured("emps/DATA_EMPS.mat"), "--bench", bench, "-o", target).code == 0
    facts = json.loads(run("info", target, "--json").stdout)
    assert facts["encoder_step"] == pytest.approx(5e-8)
    assert facts["duration_s"] == pytest.approx(24.84)


def test_info_of_a_raw_file_is_in_its_own_units_without_the_bench(raw: Path):
    shown = [
        json.loads(run("info", raw, *words, "--json").stdout)["channels"]
        for words in ((), ("--bench", CLUTCH))
    ]
    units = [{row["name"]: row["unit"] for row in rows} for rows in shown]
    assert units[0]["position"] == "count"
    assert "effort" not in units[0]
    assert units[1] == {"position": "rad", "current": "A", "effort": "N m"}


def test_warnings_go_to_stderr_and_into_json(raw: Path, tmp_path: Path):
    raw.write_text(GOOD.replace("0.010,10,1.0\n", "").replace("0.011,11,1.1\n", ""))
    result = run("ingest", raw, "--bench", CLUTCH, "-o", tmp_path / "x.mcap", "--json")
    assert result.stderr == "warning: 1 gap in time, the longest 0.003 s\n"
    assert json.loads(result.stdout)["warnings"] == ["1 gap in time, the longest 0.003 s"]


BAD = {
    "ragged": (GOOD + "0.050,50\n", ":52:", "has 2 cells"),
    "text": (GOOD.replace("0.030,30", "0.030,stuck"), ":32:", "'stuck'"),
    "nan": (GOOD.replace("0.030,30", "0.030,nan"), ":32:", "found nan"),
    "time repeats": (
        GOOD.replace("0.030,", "0.029,"),
        ":32:",
        "time does not increase: 0.029 s after 0.029 s; if the times are too coarse, remove "
        "columns.time",
    ),
    "unit": (GOOD.replace("[A]", "[V]"), "'current'", "'V'"),
    "column": (GOOD.replace("encoder", "encodr"), "'encoder'", "did you mean 'encodr'"),
    "rate": (GOOD.replace("time [s]", "time [ms]"), "'time'", "'ms'"),
    "header only": (GOOD.splitlines()[0] + "\n", "raw.csv", "no rows"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_raw_files(name: str, raw: Path, tmp_path: Path):
    text, *words = BAD[name]
    raw.write_text(text)
    refused(run("ingest", raw, "--bench", CLUTCH, "-o", tmp_path / "log.mcap"), 3, str(raw), *words)
    assert list(tmp_path.iterdir()) == [raw]


def test_a_misspelt_channel_names_the_line_and_the_nearest(raw: Path, tmp_path: Path):
    bench = tmp_path / "bench.yaml"
    text = CLUTCH.read_text().replace("  position: {column: encoder", "  positon: {column: encoder")
    bench.write_text(text)
    line = next(number for number, row in enumerate(text.splitlines(), start=1) if "positon" in row)
    result = run("ingest", raw, "--bench", bench, "-o", tmp_path / "log.mcap")
    refused(result, 3, f"bench.yaml:{line}: columns.positon: unknown key, did you mean 'position'?")
    assert not (tmp_path / "log.mcap").exists()


def test_an_mcap_of_something_else(tmp_path: Path):
    result = run("info", measured("formats/ros2_talker.mcap"), "--bench", CLUTCH)
    refused(result, 3, "ros2_talker.mcap")


def test_help_imports_neither_numba_nor_numpy():
    script = (
        "import json, sys; sys.argv = ['frictool', '--help']\n"
        "from frictool.cli.main import main\ntry: main()\nexcept SystemExit: pass\n"
    )
    script += (
        "print(json.dumps(sorted({name.partition('.')[0] for name in sys.modules})), "
        "file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert "Usage: " in done.stdout
    loaded = set(json.loads(done.stderr))
    assert "click" in loaded
    assert not loaded & {
        "numpy",
        "numba",
        "cvxpy",
        "scipy",
        "mcap",
        "yaml",
        "msgspec",
        "pint",
        "matplotlib",
    }


@pytest.mark.parametrize(
    "line",
    ["position: {column: when, unit: rad, scale: 2}", "time: {column: when, unit: s, scale: 2}"],
)
def test_a_column_of_dates_is_no_column_of_numbers(tmp_path: Path, line: str):
    raw, bench = tmp_path / "raw.csv", tmp_path / "bench.yaml"
    raw.write_text(
        "when;encoder;current\n"
        + "".join(f"2026-01-02T03:04:05.{k:03d}Z;{k};1\n" for k in range(9))
    )
    text = CLUTCH.read_text()
    bench.write_text(
        text[: text.index("columns:")]
        + f"columns:\n  {line}\n  current: {{column: current, unit: A}}\n"
    )
    refused(
        run("ingest", raw, "--bench", bench, "-o", tmp_path / "x.mcap"),
        3,
        "column 'when' contains dates",
        "remove it from columns",
    )
