"""Large packages that a command imports: people wait for each of them at every start."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from studies.command_line import run
from studies.rigs.step_scenario import write_rig
from tests.support.short_logs import first_part

ROOT = Path(__file__).parents[2]
COMPILER = {"numba"}
PARTS = ("integrate", "interpolate", "ndimage", "optimize", "signal", "special", "stats")
LARGE = {
    *COMPILER,
    *("clarabel", "cvxpy", "jinja2", "matplotlib", "pint"),
    *(f"scipy.{part}" for part in PARTS),
}
PROGRAM = """
import json, sys
from frictool.cli.main import group
for command in json.loads(sys.argv[1]):
    group(command, standalone_mode=False)
    print(json.dumps(sorted(sys.modules)), file=sys.stderr)
"""


def test_commands_import_what_they_use(tmp_path: Path) -> None:
    bench = ROOT / "configs" / "clutch" / "bench.yaml"
    rig = write_rig(tmp_path)
    raw = tmp_path / "raw"
    raw.mkdir()
    for name in ("sines.csv", "ramp.csv"):
        (raw / name).write_text(first_part(name))
    logs = [tmp_path / "sines.mcap", tmp_path / "ramp.mcap"]
    ingests = [
        ["ingest", raw / f"{log.stem}.csv", "--bench", bench, "-o", log] for log in logs
    ]  # fmt: skip
    for words in ingests:
        assert run(*words).code == 0
    simulate = [
        "simulate", rig["model"], "--controller", rig["controller"],
        "--scenario", rig["scenario"], "-o", tmp_path / "run.mcap",
    ]  # fmt: skip
    identify = ["identify", *logs, "--bench", bench, "-o", tmp_path / "model.yaml"]
    again = ["ingest", raw / "ramp.csv", "--bench", bench, "-o", tmp_path / "again.mcap"]
    spec = ROOT / "configs" / "clutch" / "spec.yaml"
    report = ["report", tmp_path / "run.mcap", "--spec", spec, "--bench", bench]
    page = [*report, "-o", tmp_path / "report.html"]
    design = ROOT / "configs" / "clutch" / "designs" / "speed.yaml"
    synth = [
        "synth", rig["model"], "--spec", spec, "--design", design, "--vertices-only", "--no-play",
        "-o", tmp_path / "controller.yaml",
    ]  # fmt: skip
    compiled = [["info", raw / "ramp.csv"], again, simulate, report]
    commands = [["info", logs[1]], synth, *compiled, page, identify]
    seen, designed, *others, shown, identified = _imported(commands)
    assert seen == set()
    assert designed == {"clarabel"}
    assert others == [designed | COMPILER] * len(compiled)
    assert shown == designed | COMPILER | {"jinja2"}
    assert identified == shown | {"scipy.special"}


def _imported(commands: list[list[object]]) -> list[set[str]]:
    """Run commands one after the other in one process; return the imports of LARGE after each."""
    ran = subprocess.run(
        [sys.executable, "-c", PROGRAM, json.dumps(commands, default=str)],
        capture_output=True,
        text=True,
        check=True,
    )
    lines = [line for line in ran.stderr.splitlines() if line.startswith("[")]
    return [set(json.loads(line)) & LARGE for line in lines]
