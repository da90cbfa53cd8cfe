"""Drawn actuators: valid documents, the ranges of the module, and the time that a drive needs."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from studies.actuators.bang_bang import bang_bang_distance
from studies.actuators.documents import write
from studies.actuators.drawing import PLANTS, Actuator, draw, draw_plants

EULER_STEPS = 20_000


@pytest.fixture(scope="module")
def drawn() -> list[Actuator]:
    return [draw("test", number) for number in range(12)]


def test_documents_are_accepted(drawn: list[Actuator], tmp_path: Path) -> None:
    for actuator in drawn:
        write(actuator, tmp_path)
        for name, kind in (("bench", Bench), ("model", Model), ("spec", Spec), ("steps", Scenario)):
            load(tmp_path / f"{name}.yaml", kind)


def test_an_actuator_depends_on_its_seed_and_number_only(drawn: list[Actuator]) -> None:
    assert draw("test", 7) == drawn[7]
    assert draw("other", 7) != drawn[7]
    assert len({actuator.inertia for actuator in drawn}) == len(drawn)


def test_ranges(drawn: list[Actuator]) -> None:
    for actuator in drawn:
        assert 1e-4 <= actuator.period <= 1e-2
        assert 59.9 <= actuator.response / actuator.period <= 1000.1
        assert 0.0 <= actuator.lag <= 5.01 * actuator.period
        assert 0.24 <= actuator.bang_bang / actuator.response <= 0.61
        assert 1.29 <= actuator.coulomb.high / actuator.coulomb.low <= 10.1
        largest = actuator.constant.value * actuator.limit
        assert 0.049 <= actuator.coulomb.high / largest <= 0.61
        assert 0.0 <= actuator.backlash <= 3.01 * actuator.encoder_step
        assert 79 <= actuator.amplitude / actuator.encoder_step <= 20_001


def test_plants(drawn: list[Actuator]) -> None:
    plants = draw_plants(drawn[0], "test")
    assert len(plants) == PLANTS
    assert len(set(plants)) == PLANTS
    corners = [plant for plant in plants if plant.inertia in drawn[0].inertia[1:]]
    assert len(corners) == 32
    assert all(drawn[0].coulomb.low <= plant.coulomb <= drawn[0].coulomb.high for plant in plants)


def test_the_bang_bang_motion_has_its_closed_form() -> None:
    """Without lag and damping: accelerate at 1 - f, brake at 1 + f; d = (1 - f^2)/4."""
    for friction in (0.0, 0.3, 0.6):
        expected = (1.0 - friction**2) / 4.0
        assert bang_bang_distance(friction, friction, 0.0, 0.0, 0.0) == pytest.approx(
            expected, rel=5e-3
        )
    half = bang_bang_distance(0.3, 0.3, 0.0, 0.0, 0.5)
    assert half == pytest.approx(0.25 * (1.0 - 0.09) / 4.0, rel=1e-2)


def _euler_distance(switch: float) -> float | None:
    """Return the distance at standstill after friction 0.2, lag 0.05; None after the duration."""
    distance = speed = drive = 0.0
    for step in range(EULER_STEPS):
        drive += ((1.0 if step < switch * EULER_STEPS else -1.0) - drive) / (0.05 * EULER_STEPS)
        if speed > 0.0 or drive > 0.24:
            speed += (drive - 0.2 - 1.5 * speed) / EULER_STEPS
        if speed <= 0.0 and step > switch * EULER_STEPS:
            return distance
        distance += max(speed, 0.0) / EULER_STEPS
    return None


def test_the_bang_bang_motion_agrees_with_euler_integration() -> None:
    low, high, reached = 0.3, 1.0, 0.0
    for _ in range(14):
        switch = 0.5 * (low + high)
        distance = _euler_distance(switch)
        if distance is None:
            high = switch
        else:
            low, reached = switch, distance
    assert bang_bang_distance(0.2, 0.24, 0.05, 1.5, 0.0) == pytest.approx(reached, rel=5e-3)
