"""Commissioned actuators: the true plant lies in the bench's ranges, and broken limits are seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from frictool.documents.model import Model
from frictool.documents.registry import load
from studies import commissioning
from studies.actuators.drawing import VARIED, draw, draw_plants
from studies.commissioning import Commissioning, broken_limits, summary, truth


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


def test_a_log_beyond_travel_or_drive_limit_is_named() -> None:
    actuator = draw("test", 0)
    inside = np.array([0.0, 0.5, 1.0]) * actuator.travel
    beyond = inside + 2.0 * actuator.encoder_step
    drive = np.array([-1.0, 0.0, 1.0]) * actuator.limit
    assert list(broken_limits(actuator, inside, drive)) == []
    assert list(broken_limits(actuator, beyond, drive)) == ["travel"]
    assert list(broken_limits(actuator, inside, 1.1 * drive)) == ["drive limit"]


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
    assert "broke travel" in rows[2].row()
