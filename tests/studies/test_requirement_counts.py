"""A seeded part of the counts of 5.4, and that a count counts."""

from __future__ import annotations

from functools import cache

import msgspec
import numpy as np
import pytest

from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.logs.log import Log, Stream
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.synth.design import design_controller
from studies.clutch.requirement_counts import (
    T_INT,
    Counted,
    Plant,
    counted,
    judged,
    missed,
    spends_least,
    table,
)
from studies.rigs.clutch_model import clutch_model
from studies.rigs.example_controllers import ROOT, clutch_controller

RIG = ROOT / "configs/clutch"
SPEC = load(RIG / "spec.yaml", Spec)
PLANTS, SEED = 10, 543


@cache
def speed() -> Controller:
    return design_controller(
        clutch_model(), SPEC, load(RIG / "designs/speed.yaml", Design), Provenance("a test", "0")
    )


def played(controller: Controller, variants: str) -> Log:
    plants = PLANTS if variants == "random" else None
    scenario = msgspec.structs.replace(
        load(RIG / "counts/plants_1.yaml", Scenario), variants=variants, plants=plants, seed=SEED
    )
    return simulate_closed_loop(
        load(RIG / "nonlinear.yaml", Model), controller, scenario, Provenance("a test", "0")
    )


def test_the_speed_form_meets_5_4_1_on_every_vertex_and_random_plant() -> None:
    found = counted(
        SPEC, speed(), (played(speed(), variants) for variants in ("vertices", "random"))
    )
    assert (len(found.vertices), len(found.plants)) == (16, PLANTS)
    assert all(
        plant.all_met and plant.rest_drive == 0.0
        for plant in (found.nominal, *found.vertices, *found.plants)
    )
    assert missed(with_plants(found, plants=found.plants * 100)) == []
    assert len({plant.energy for plant in found.plants}) == PLANTS  # none is played twice
    assert found.margin >= 0.5


def with_plants(found: Counted, plants: tuple[Plant, ...]) -> Counted:
    return Counted(found.design, found.margin, found.nominal, found.vertices, plants)


def stream(current: float, end: float) -> Log:
    """A step from 5 to 55 rad that ends at `end` within 0.1 s and takes `current` for 0.1 s, one
    back, and a hold of 20 s."""
    time = np.arange(24_000) * 1e-3
    reference = np.where((time < 1.1), 55.0, 5.0)
    position = np.where(time < 0.1, 5.0, np.where(time < 1.2, end, 5.0))
    drive = current * ((time < 0.1) | ((time >= 1.1) & (time < 1.2)))
    signals = {"position": position, "reference": reference, "current": drive, "command": drive}
    units = {"position": "rad", "reference": "rad", "current": "A", "command": "A"}
    return Log((Stream("/axis", time, signals, units),), {"log": {"kind": "simulated"}}, "made up")


def test_energy_is_the_mean_square_over_the_first_0_28_s_of_the_first_two_steps() -> None:
    (plant,) = judged(SPEC, stream(20.0, 55.0))
    assert plant.energy == pytest.approx((400.0 * 0.1 / T_INT, 400.0 * 0.1 / T_INT))
    assert plant.all_met


@pytest.mark.parametrize(
    ("current", "end", "broken"),
    [(60.0, 55.0, "drive_peak"), (20.0, 58.0, "overshoot"), (20.0, 52.5, "static_error")],
)
def test_what_a_plant_breaks_is_named(current: float, end: float, broken: str) -> None:
    (plant,) = judged(SPEC, stream(current, end))
    assert not plant.met[broken]
    assert not plant.all_met


def test_what_is_missed_is_told() -> None:
    good = Plant(
        "/axis/p1", {"response_time_95": True, "rest": True}, 0.12, 1.0, 0.1, 0.0, (100.0, 120.0)
    )
    slow = Plant(
        "/axis/p2", {"response_time_95": False, "rest": True}, 0.30, 1.0, 0.1, 0.0, (90.0, 90.0)
    )
    fast = Counted("fast", 0.6, good, (good,) * 15 + (slow,), (good,) * 994 + (slow,) * 6)
    assert missed(fast) == [
        "vertices: 15 of 16, asked 16",
        "random plants: 994 of 1000, asked 995",
        "1 vertices slower than 0.122 s",
    ]
    assert missed(Counted("fast", 0.4, good, (good,) * 16, (good,) * 1000)) == [
        "modulus margin 0.400, asked 0.5"
    ]
    designs = [
        Counted(name, 0.6, plant, (plant,), (plant,))
        for name, plant in (("speed", slow), ("position", good), ("rst", good))
    ]
    assert spends_least(designs)
    assert not spends_least([Counted("speed", 0.6, good, (good,), (good,)), *designs[1:]])
    assert "90.0" in table(designs)[-3]


def test_a_log_that_cannot_tell_is_not_counted() -> None:
    whole = load(RIG / "counts/plants_1.yaml", Scenario)
    short = msgspec.structs.replace(whole, plants=1, steps=whole.steps[:3])
    log = simulate_closed_loop(
        load(RIG / "nonlinear.yaml", Model), clutch_controller(), short, Provenance("a test", "0")
    )
    with pytest.raises(ValueError, match="cannot tell rest"):
        judged(SPEC, log)
