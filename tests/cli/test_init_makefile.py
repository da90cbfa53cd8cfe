"""The Makefile that `frictool init` writes: it chains the commands, finds the logs or says where to
put them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from frictool.documents.starting_documents import StartingRig, starting_documents
from studies.command_line import run

ROOT = Path(__file__).parents[2]
LOG = ROOT / "sample_logs/sines.csv"
SHARED = ROOT / "frictool/documents/templates/rig.mk"
ENVIRONMENT = {
    name: value
    for name, value in os.environ.items()
    if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")
}  # of a make around us
ENVIRONMENT["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
WITH_MAKE = pytest.mark.skipif(shutil.which("make") is None, reason="there is no make on the PATH")


@WITH_MAKE
def test_the_makefile_chains_the_commands(tmp_path: Path) -> None:
    rig = tmp_path / "rig"
    assert run("init", rig, "--from", LOG, "--axis", "rotary").code == 0
    plan = subprocess.run(
        ["make", "-n", "demo"], cwd=rig, env=ENVIRONMENT, check=True, capture_output=True, text=True
    ).stdout
    commands = [line.split()[1] for line in plan.splitlines() if line.startswith("frictool ")]
    assert commands == [
        "ingest",
        "identify",
        "synth",
        "export",
        "simulate",
        "report",
        "verify",
        "report",
    ]
    subprocess.run(
        ["make", "build/logs/sines.mcap"], cwd=rig, env=ENVIRONMENT, check=True, capture_output=True
    )
    assert (rig / "build/logs/sines.mcap").stat().st_size > 0
    again = subprocess.run(
        ["make", "-n", "demo"], cwd=rig, env=ENVIRONMENT, check=True, capture_output=True, text=True
    ).stdout
    assert "frictool ingest" not in again


@WITH_MAKE
def test_every_design_is_played_and_has_a_target_of_its_own(tmp_path: Path) -> None:
    """A position loop too; a design that is there to compare with does not end make where it misses
    the specification."""
    rig = tmp_path / "rig"
    assert run("init", rig, "--from", LOG, "--axis", "rotary").code == 0
    text = (rig / "designs/automatic.yaml").read_text()
    (rig / "designs/other.yaml").write_text(
        text.replace("structure: speed_cascade", "structure: position")
    )
    plan = _plan(rig, "other")
    assert [line.split()[1] for line in plan.splitlines() if line.startswith("frictool ")][2:] == [
        "synth",
        "simulate",
        "report",
        "verify",
        "report",
    ]
    assert "build/automatic" not in plan
    assert plan.endswith("exit $code\n")
    assert _plan(rig, "other", "REFERENCE=automatic other").endswith("exit 0\n")
    pages = {"build/automatic/report.html", "build/other/report.html"}
    assert pages <= set(_plan(rig, "all").split())


def _plan(rig: Path, *words: str) -> str:
    return subprocess.run(
        ["make", "-n", *words], cwd=rig, env=ENVIRONMENT, check=True, capture_output=True, text=True
    ).stdout


@pytest.mark.parametrize("blank", [True, False])
def test_a_path_that_make_cannot_read_is_told(blank: bool, tmp_path: Path) -> None:
    log = tmp_path / ("my log.csv" if blank else "log.csv")
    shutil.copy(LOG, log)
    result = run("init", tmp_path / "rig", "--from", log, "--axis", "rotary")
    assert result.code == 0
    assert ("make cannot read" in result.stderr) == blank
    makefile = (tmp_path / "rig/Makefile").read_text()
    assert ("LOGS := ../log.csv\n" in makefile) != blank
    assert ("$(wildcard logs/" in makefile) == blank


@WITH_MAKE
def test_make_without_logs_says_where_to_put_them(tmp_path: Path) -> None:
    rig = tmp_path / "my rig"
    told = run("init", rig, "--axis", "rotary").stdout
    assert (
        f"put the bench's logs (CSV, MATLAB, MCAP) into {rig}/logs/, then run make -C '{rig}'"
        in told
    )
    for target in ("all", "demo", "build/model.yaml"):
        stopped = subprocess.run(
            ["make", target], cwd=rig, env=ENVIRONMENT, capture_output=True, text=True
        )
        assert stopped.returncode == 2
        assert stopped.stdout == ""
        assert stopped.stderr.count("\n") == 1
        assert "put the bench's logs into logs/" in stopped.stderr
    assert not (rig / "build").exists()
    subprocess.run(["make", "clean"], cwd=rig, env=ENVIRONMENT, check=True, capture_output=True)
    (rig / "logs").mkdir()
    shutil.copy(LOG, rig / "logs")
    subprocess.run(
        ["make", "build/logs/sines.mcap"], cwd=rig, env=ENVIRONMENT, check=True, capture_output=True
    )


def test_the_rigs_share_the_makefile_that_init_writes() -> None:
    written = starting_documents(StartingRig("rig", "rotary"))["Makefile"]
    assert written.endswith(SHARED.read_text())
    for rig in ("clutch", "emps"):
        (line,) = re.findall(
            r"^include (.*)$", (ROOT / "configs" / rig / "Makefile").read_text(), re.MULTILINE
        )
        assert (ROOT / "configs" / rig / line).resolve() == SHARED
