"""The test that a designed controller is played in, from bench and specification alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from frictool.campaign.design_trial import (
    DRAWN,
    PLACES,
    TARGETS,
    design_test,
    step_lengths,
    untested_reason,
)
from frictool.campaign.draws.default_scenario import default_scenario
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Sine, Step
from frictool.documents.spec import Spec
from studies.rigs.clutch_model import ROOT, clutch_model

RIG = ROOT / "configs/clutch"
SPEC = load(Path(RIG / "spec.yaml"), Spec)


def test_the_default_steps_are_those_of_5_4_1() -> None:
    steps = default_scenario(clutch_model(), SPEC)
    assert steps.start is not None
    places = [steps.start.value, *(step.reference.value for step in steps.steps if step.reference)]
    assert places == pytest.approx([5.04, 55.44, 5.04, 35.28, 15.12])
    assert [step.seconds for step in steps.steps] == pytest.approx([1.1, 1.1, 1.1, 16.1])
    short = default_scenario(clutch_model(), replace(SPEC, rest=None))
    assert [step.seconds for step in short.steps] == pytest.approx([1.1] * 4)


def test_a_short_step_follows_the_first_if_the_static_error_is_small() -> None:
    coarse = 2.0 * math.pi / 20.0  # rad, an encoder count
    for counts, error, overshoot, length in (
        (5600.0, 0.01, 5.0, 5.04),
        (5600.0, 0.4, 5.0, 8.0),
        (20.0, 0.01, 5.0, 20.0 * coarse),
        (5600.0, 0.1, 1.0, 10.0),  # the axis may rest 0.1 rad beyond the target
    ):
        model = clutch_model()
        encoder = replace(model.bench.encoder, counts_per_revolution=counts)
        model = replace(model, bench=replace(model.bench, encoder=encoder))
        static_error = Quantity(value=error, unit="rad")
        spec = replace(SPEC, static_error=static_error, overshoot_percent=overshoot)
        steps = default_scenario(model, spec)
        lengths = [50.4, length, 50.4 - length, 30.24, 20.16]
        assert step_lengths(steps) == pytest.approx(lengths)
        assert steps.steps[1].duration_s == pytest.approx(1.1)
    large = Quantity(value=20.16 / 20.0 / 1.1, unit="rad")  # the short step is hardly shorter
    for spec in (
        replace(SPEC, static_error=large),
        replace(SPEC, static_error=None, overshoot_percent=0.0),
    ):
        assert len(step_lengths(default_scenario(clutch_model(), spec))) == 4


def test_the_lengths_are_those_of_steps_and_not_of_ramps_and_sines() -> None:
    def at(value: float) -> Quantity:
        return Quantity(value=value, unit="rad")

    scenario = Scenario(
        format="scenario/1",
        name="mixed",
        axis="rotary",
        start=at(1.0),
        steps=(
            Step(reference=at(3.0), duration_s=1.0),
            Step(hold_s=15.0),
            Step(ramp_to=at(10.0), duration_s=1.0),
            Step(reference=at(9.0), duration_s=1.0),
            Step(reference=at(9.0), duration_s=1.0),
            Step(sine=Sine(amplitude=at(1.0), frequency_hz=1.0), duration_s=0.3),
            Step(reference=at(4.0), duration_s=1.0),
            Step(reference=at(4.5), duration_s=1.0),
        ),
    )
    assert step_lengths(scenario) == [2.0, 1.0, 0.5]
    test = design_test(clutch_model(), SPEC, scenario)
    assert test.steps == "steps of 0.5 to 2 rad"
    assert "mixed, 3 steps of 0.5 to 2 rad, " in test.about


def test_the_plants_are_nominal_vertices_and_drawn_plants() -> None:
    test = design_test(clutch_model(), SPEC)
    assert test.vertices == 16
    assert len(test.plants) == len(test.names) == len(test.starts) == 33 + DRAWN
    assert test.plants[0] == {}
    assert (test.names[0], test.names[16], test.names[-1]) == (
        "nominal plant",
        "v16, largest breakaway",
        "drawn plant 40",
    )
    starts = [round(start, 9) for start in test.starts]
    assert (
        len({(*plant.items(), start) for plant, start in zip(test.plants, starts, strict=True)})
        == 73
    )
    count = clutch_model().bench.encoder.resolution
    assert test.starts[17] - test.starts[1] == pytest.approx(0.5 * count)
    within = sorted((start - starts[0]) / count for start in starts[33:])
    assert 0.0 < within[0] < 0.05
    assert 0.95 < within[-1] < 1.0
    judged = test.judge.scenarios[17].start
    assert judged is not None
    assert judged.value == test.starts[17]


def test_a_specification_without_requirement_is_not_played() -> None:
    empty = Spec(format="spec/1", name="nothing", axis="rotary", drive="current")
    assert "no requirement" in untested_reason(clutch_model(), empty)
    assert untested_reason(clutch_model(), SPEC) == ""


def test_the_other_plants_are_not_those_of_the_test() -> None:
    test = design_test(clutch_model(), SPEC)
    judges = test.judges_of_others(test.scenario, SPEC)
    known = {tuple(plant.values()) for plant in test.plants[33:]}
    drawn = [
        tuple(one.value for one in scenario.given.values())
        for judge in judges
        for scenario in judge.scenarios[17:]
    ]
    assert len(set(drawn)) == len(drawn) == 120
    assert known.isdisjoint(drawn)
    targets = [judge.scenarios[0].steps[0].reference for judge in judges]
    assert len({one.value for one in targets if one is not None}) == 4


def test_the_worst_plants_of_each_requirement_start_from_every_place() -> None:
    model = clutch_model()
    fixed = replace(model.parameters.breakaway, low=None, high=None)  # no range
    test = design_test(replace(model, parameters=replace(model.parameters, breakaway=fixed)), SPEC)
    steps = replace(test.scenario, steps=test.scenario.steps[:1])
    judges = test.judges_of_places(steps, SPEC)
    count = clutch_model().bench.encoder.resolution
    starts = [
        judge.scenarios[3 * PLACES + place].start for judge in judges for place in range(PLACES)
    ]
    within = sorted((one.value - test.starts[0]) / count for one in starts if one is not None)
    assert within == pytest.approx([k / (PLACES * TARGETS) for k in range(PLACES * TARGETS)])

    # plants 2 and 18 are the same vertex at two places, and worst in the first requirement
    reserves = np.full((len(test.plants), 2), 0.5)
    reserves[[2, 18, 7], 0] = 0.1, 0.05, 0.2
    reserves[:, 1] = np.nan
    played: list[Sequence[int]] = []

    def judge(controller: object, only: Sequence[int], until: object) -> None:
        played.append(only)

    found: Any = SimpleNamespace(reserves=reserves)
    list(test.worst_at_places([judge], None, found))  # type: ignore[arg-type, list-item] # counts the plants
    (only,) = played
    assert sorted({plant // PLACES for plant in only}) == [7, 18]
    assert len(only) == 2 * PLACES
