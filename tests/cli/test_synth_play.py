"""The played test at the end of `frictool synth`: verdict, exit code, steps of a scenario."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from studies.command_line import run
from studies.rigs.clutch_model import ROOT

RIG = ROOT / "configs/clutch"
STEP = """\
format: scenario/1
name: one step
axis: rotary
start: {value: 5, unit: rad}
steps:
  - {reference: {value: 55, unit: rad}, duration_s: 0.6}
"""


@pytest.fixture
def arguments(tmp_path: Path) -> list[str | Path]:
    """Return a command with a PI of the speed, which overshoots by more than 5 %."""
    shutil.copy(RIG / "laws/pi_speed.yaml", tmp_path / "design.yaml")
    logged = "logged_positions: {low: 5, high: 50, unit: rad}\n"
    (tmp_path / "model.yaml").write_text((RIG / "nonlinear.yaml").read_text() + logged)
    (tmp_path / "steps.yaml").write_text(STEP)
    spec = (RIG / "spec.yaml").read_text().splitlines()
    (tmp_path / "spec.yaml").write_text("\n".join(spec[:-1]))  # without the rest
    return [
        "synth",
        tmp_path / "model.yaml",
        "--spec",
        tmp_path / "spec.yaml",
        "--design",
        tmp_path / "design.yaml",
        "--vertices-only",
        "-o",
        tmp_path / "controller.yaml",
    ]


def test_a_controller_that_misses_the_specification_is_written_with_exit_code_1(
    arguments: list[str | Path], tmp_path: Path
) -> None:
    done = run(*arguments, "--scenario", tmp_path / "steps.yaml")
    assert done.code == 1
    assert (tmp_path / "controller.yaml").exists()
    assert "steps range from 5 to 55 rad, but the model's logs only from 5 to 50 rad" in done.stderr
    lines = done.stdout.splitlines()
    assert lines[-9] == (
        "played: one step, 1 step of 50 rad, 0.6 s; nominal plant, 16 vertices from 2 "
        "positions within an encoder count, 40 drawn plants (seed 1)"
    )
    untested = lines[-10]  # next to the verdict
    assert untested.startswith("not tested: an elastic drive train; a resonance below ")
    assert lines[-7].startswith("NOT MET     overshoot ")
    assert "above mechanics.top_speed, 400 rad/s" in lines[-2]
    assert lines[-1].startswith("FAIL: ")
    assert lines[-1].endswith(" of 73 plants meet them all")

    asked = run(*arguments, "--scenario", tmp_path / "steps.yaml", "--json")
    assert asked.code == 1
    answer = json.loads(asked.stdout)
    assert untested in answer["notes"]
    played = answer["played"]
    assert not played["passed"]
    assert [one["key"] for one in played["requirements"] if not one["met"]] == [
        line.split()[2] + ("_percent" if "overshoot" in line else "")
        for line in lines
        if line.startswith("NOT MET")
    ]


def test_without_playing_the_verification_decides(
    arguments: list[str | Path], tmp_path: Path
) -> None:
    done = run(*arguments, "--no-play", "--json")
    assert done.code == 0
    assert json.loads(done.stdout)["played"] is None
    both = run(*arguments, "--no-play", "--scenario", tmp_path / "steps.yaml")
    assert both.code == 2
    assert "--scenario has no effect with --no-play" in both.stderr
