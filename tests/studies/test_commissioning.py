"""Commissioned actuators: the true plant lies in the bench's ranges, and broken limits are seen."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from frictool.documents.model import Model
from frictool.documents.registry import load
from studies import commissioning
from studies.actuators import documents
from studies.actuators.drawing import VARIED, Actuator, draw, draw_plants
from studies.command_line import CommandResult
from studies.commissioning import (
    Commissioning,
    broken_limits,
    commissionings,
    summary,
    truth,
)


def test_the_true_plant_is_inside_the_ranges_of_its_bench(tmp_path: Path) -> None:
    for number in range(8):
        actuator = draw("test", number)
        plant = draw_plants(actuator, "test")[commissioning.TRUTH]
        for name in VARIED:
            interval = getattr(actuator, name)
            assert interval.low <= getattr(plant, name) <= interval.high
        path = tmp_path / f"{number}.yaml"
        path.write_text(yaml.safe_dump(truth(actuator, plant)))
        model = load(path, Model)
        assert model.bench.actuator.constant.value == plant.constant
        assert model.parameters.coulomb.value == plant.coulomb
        assert model.parameters.breakaway.value == pytest.approx(
            actuator.breakaway_ratio * plant.coulomb
        )


def test_a_log_beyond_travel_speed_or_drive_limit_is_named() -> None:
    actuator = draw("test", 0)
    samples = 20_000
    inside = np.linspace(0.1, 0.9, samples) * actuator.travel
    drive = np.full(samples, actuator.limit)
    speed = 0.8 * actuator.travel / (samples * actuator.period)
    assert speed < 0.5 * documents.top_speed(actuator)
    assert list(broken_limits(actuator, inside, drive)) == []
    for end in (0.0, actuator.travel):  # the stops of the simulated bench end the motion there
        stopped = np.where(np.arange(samples) == samples - 1, end, inside)
        assert "travel" in list(broken_limits(actuator, stopped, drive))
    assert list(broken_limits(actuator, inside, -1.1 * drive)) == ["drive limit"]
    factor = int(2.0 * documents.top_speed(actuator) / speed)
    assert list(broken_limits(actuator, inside[::factor], drive)) == ["top speed"]


def test_summary_counts_right_outcomes_only() -> None:
    rows = [
        Commissioning(k, "an actuator", outcome, 3, 60.0, broken)
        for k, (outcome, broken) in enumerate(
            [
                ("met", ()),
                ("refused like the search", ()),
                ("missed: overshoot", ("travel",)),
                ("plan says enough, synth ends with 1", ()),
            ]
        )
    ]
    found = summary(rows)
    assert (found["right"], found["met"], found["broken_limits"]) == (2, 1, 1)
    assert (found["tests"], found["bench_s"]) == (12, 240.0)
    assert "broke travel" in rows[2].row()
    assert "3 tests, 60 s" in rows[2].row()


def test_an_interrupted_study_continues(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    played = []

    def outcome(actuator: Actuator, seed: str, folder: Path) -> str:
        played.append(actuator.name)
        if len(played) == 2:
            raise ValueError("viscous is nan")
        return "met"

    monkeypatch.setattr(commissioning, "_outcome", outcome)
    kept = tmp_path / "rows.json"
    first = list(commissionings("test", range(2), kept))
    assert [one.outcome for one in first] == ["met", "crashed: ValueError: viscous is nan"]
    again = list(commissionings("test", range(3), kept))
    assert [one.row() for one in again[:2]] == [one.row() for one in first]
    assert played == ["actuator 0", "actuator 1", "actuator 2"]


def test_a_plan_without_end_is_no_refusal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    step = {"test": {}, "enough": False, "why": "nothing new"}
    answer = CommandResult(0, json.dumps(step).encode(), "")
    monkeypatch.setattr(commissioning, "_planned", lambda *_: answer)
    monkeypatch.setattr(commissioning, "_played", lambda folder, number: folder / str(number))
    actuator = draw("test", 0)
    assert commissioning._outcome(actuator, "test", tmp_path).startswith("no end after 8 tests")
    answer = CommandResult(3, b"", "error: the same log twice")
    assert commissioning._outcome(actuator, "test", tmp_path).startswith("plan ends with 3: error")
