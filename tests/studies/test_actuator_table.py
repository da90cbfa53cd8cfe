"""The table of trials: rows, rates, and trials that are kept over an interruption."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from studies.actuators import table
from studies.actuators.__main__ import main
from studies.actuators.judge import REQUIREMENTS
from studies.actuators.trial import Trial, summary

GOOD = Trial(
    number=0, actuator="rotary", code=0, seconds=2.0, message="", searched=True, candidates=3,
    worst=dict.fromkeys(REQUIREMENTS, 0.5), limits=dict.fromkeys(REQUIREMENTS, 1.0),
    met=dict.fromkeys(REQUIREMENTS, True), plants_met=56,
)  # fmt: skip
FALSE = replace(GOOD, number=1, seconds=4.0, met={**GOOD.met, "rest": False})
HONEST = replace(FALSE, number=2, code=1)
REFUSED = replace(GOOD, number=3, code=4, worst={}, limits={}, met={}, message="error: no design")
HARD = replace(REFUSED, number=4, searched=False, seconds=100.0)


def test_rates() -> None:
    found = summary([GOOD, FALSE, HONEST, REFUSED, HARD])
    assert found["met_rate"] == 0.2
    assert found["search_solves"] == 4
    assert found["met_rate_of_solvable"] == 0.25
    assert found["refused_but_solvable"] == 1
    assert found["claimed_met"] == 2
    assert found["false_met_rate"] == 0.5
    assert found["median_seconds"] == 4.0
    assert summary([HARD])["false_met_rate"] == 0.0


def test_rows() -> None:
    assert table.row(GOOD).split()[:5] == ["0", "met", "met", "3", "2.0s"]
    assert "0.50 !" in table.row(FALSE)
    assert table.row(HONEST).split()[1:3] == ["missed", "missed"]
    refused = table.row(HARD)
    assert refused.split()[1:4] == ["refused", "-", "none"]
    assert refused.endswith("error: no design")


def test_an_infinite_figure_is_null(tmp_path: Path) -> None:
    target = tmp_path / "table.json"
    table.write_table("s", [replace(FALSE, worst={**GOOD.worst, "rest": math.inf})], target)
    (written,) = json.loads(target.read_text())["trials"]
    assert written["worst"]["rest"] is None
    assert written["worst"]["static_error"] == 0.5


def test_kept_trials_are_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = tmp_path / "table.json.trials"
    lines = [json.dumps({"seed": "s"}), *(json.dumps(one.__dict__) for one in (GOOD, FALSE))]
    kept.write_text("\n".join([*lines, '{"number": 2, "act']))
    assert [one.number for one in table.run_trials("s", 2, kept)] == [0, 1]
    assert [one.number for one in table.run_trials("s", 1, kept)] == [0]
    monkeypatch.setattr(table, "try_actuator", lambda seed, number: replace(HARD, number=number))
    assert [one.number for one in table.run_trials("s", 3, kept)] == [0, 1, 2]
    assert [one.number for one in table.run_trials("s", 3, kept)] == [0, 1, 2]
    assert [one.searched for one in table.run_trials("other", 1, kept)] == [False]


def test_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table, "try_actuator", lambda seed, number: replace(GOOD, number=number))
    target = tmp_path / "table.json"
    assert main(["2", "--seed", "actuators", "-o", str(target)]) == 0
    assert json.loads(target.read_text())["summary"]["met"] == 2
    assert len(capsys.readouterr().out.splitlines()) == 13


@pytest.mark.accept
def test_two_actuators(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`synth` meets their specification, and the judge agrees."""
    target = tmp_path / "table.json"
    assert main(["2", "--seed", "actuators", "-o", str(target)]) == 0
    found = json.loads(target.read_text())
    assert found["summary"]["met"] == 2
    assert len(capsys.readouterr().out.splitlines()) == 13
