"""Steps that are shorter than those of a test, after a controller has passed the test."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace as changed
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from frictool.campaign import design_trial
from frictool.campaign.automatic_design import design_automatically
from frictool.campaign.design_trial import design_test, step_lengths
from frictool.campaign.draws.default_scenario import (
    SAME,
    default_scenario,
    longest_step,
    shortest_travel_step,
)
from frictool.campaign.shorter_steps import (
    MOST,
    play_shorter_steps,
    shorter_lengths,
    with_tolerance,
)
from frictool.campaign.views.played_view import shorter_json, shorter_text
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.synth.feasibility import shortest_step
from frictool.synth.search.candidate_controller import CandidateControllers
from studies.actuators import documents
from studies.actuators.drawing import draw
from studies.rigs.clutch_model import clutch_model

SEED, NUMBER = "shortsteps", 0  # an actuator whose friction is up to half of the drive's effort


@pytest.fixture(scope="module", autouse=True)
def few_plants() -> Iterator[None]:
    """Draw few plants besides the vertices."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design_trial, "DRAWN", 8)
        patch.setattr(design_trial, "OTHERS", 4)
        yield


@pytest.fixture(scope="module")
def documents_of_axis(tmp_path_factory: pytest.TempPathFactory) -> tuple[Model, Spec]:
    """Return model and specification of the actuator."""
    folder = tmp_path_factory.mktemp("drawn")
    documents.write(draw(SEED, NUMBER), folder)
    return load(folder / "model.yaml", Model), load(folder / "spec.yaml", Spec)


def without_the_short_step(scenario: Scenario) -> Scenario:
    return replace(scenario, steps=(scenario.steps[0], *scenario.steps[2:]))


def designed(model: Model, spec: Spec, scenario: Scenario | None = None) -> Controller:
    found = design_automatically(design_test(model, spec, scenario))
    assert found.passed
    return CandidateControllers(model, spec)(found.design)


@pytest.fixture(scope="module")
def default_controller(documents_of_axis: tuple[Model, Spec]) -> Controller:
    """Return the controller of the default steps."""
    return designed(*documents_of_axis)


def test_a_controller_of_long_steps_fails_in_shorter_ones_and_that_of_the_default_steps_passes(
    documents_of_axis: tuple[Model, Spec], default_controller: Controller
) -> None:
    """The loop is nonlinear: the same specification, met in steps over the travel, fails below."""
    model, spec = documents_of_axis
    default = design_test(model, spec)
    steps = default.scenario
    assert len(steps.steps) == 5
    long = designed(model, spec, without_the_short_step(steps))
    shorter = play_shorter_steps(default, long)
    assert shorter is not None
    assert shorter.failed
    assert shorter.worst is not None
    step, requirement = shorter.worst
    assert step.length < shortest_travel_step(model)
    assert requirement.value > requirement.metric.limit
    assert not default.judge(long).passed

    shorter = play_shorter_steps(default, default_controller)
    assert shorter is not None
    assert not shorter.failed
    assert shorter.worst is None
    # a provided scenario states the steps of the axis
    assert play_shorter_steps(design_test(model, spec, steps), default_controller) is None


def test_an_axis_that_does_not_move_fails(documents_of_axis: tuple[Model, Spec]) -> None:
    """A step within the band of the position law is not followed."""
    model, spec = documents_of_axis
    coarse = replace(spec, static_error=None)  # the band is 4 % of the longest step
    shorter = play_shorter_steps(design_test(model, coarse), designed(model, coarse))
    assert shorter is not None
    for step in shorter.steps:
        response = step.verdict.requirements[0]
        assert response.metric.key == "response_time_95_s"
        if step.length < 0.02 * longest_step(model):
            assert response.value == math.inf
            assert response.met is False
            assert step.failed
    assert shorter.steps[0].length < 0.02 * longest_step(model)


def test_a_step_as_long_as_the_first_of_the_test_has_the_same_figures(
    documents_of_axis: tuple[Model, Spec],
    default_controller: Controller,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first and third default step are a step over most of the travel, and back."""
    model, spec = documents_of_axis
    test = design_test(model, spec)
    controller = default_controller
    whole = longest_step(model)
    monkeypatch.setattr("frictool.campaign.shorter_steps.shorter_lengths", lambda _: [whole])
    shorter = play_shorter_steps(test, controller)
    assert shorter is not None
    low, high = shorter.steps
    assert high.start - low.start == pytest.approx(whole)
    steps = test.scenario.steps
    three = replace(test.scenario, steps=(steps[0], steps[2], steps[0]))
    alone = test.judge_of(three, spec)(controller, [0])
    known = {one.key: value for one, value in zip(alone.metrics, alone.values[0], strict=True)}
    found = {
        one.key: value
        for one, value in zip(low.verdict.metrics, low.verdict.values[0], strict=True)
    }
    assert set(known) - set(found) == {"modulus_margin", "rest"}
    assert found == pytest.approx({key: known[key] for key in found}, rel=1e-6)


@given(st.floats(1e-4, 0.2), st.booleans())
def test_the_lengths_fill_the_gap_between_the_specification_and_the_test(
    error: float, bounded: bool
) -> None:
    model = clutch_model()
    encoder = replace(model.bench.encoder, counts_per_revolution=56_000.0)
    bench = replace(model.bench, encoder=encoder)
    if not bounded:
        bench = replace(bench, mechanics=replace(bench.mechanics, travel=None))
    model = replace(model, bench=bench)
    static_error = Quantity(value=error * longest_step(model), unit="rad")
    spec = Spec(
        format="spec/1",
        name="s",
        axis="rotary",
        drive="current",
        overshoot_percent=5.0,
        static_error=static_error,
    )
    test: Any = SimpleNamespace(model=model, spec=spec, scenario=default_scenario(model, spec))
    lengths = shorter_lengths(test)
    low, high = shortest_step(model, spec), shortest_travel_step(model)
    tested = step_lengths(test.scenario)
    assert len(lengths) <= MOST
    for length in lengths:
        assert low <= length * (1.0 + 1e-12)
        assert length < high
        assert all(max(length / one, one / length) >= SAME for one in tested)
    known = sorted({*lengths, *(one for one in tested if one <= 1.001 * high)})
    if low * SAME < high:
        assert known[0] < low * SAME
        largest = max(2.0, (high / low) ** (1.0 / MOST))
        assert all(b / a < largest * SAME for a, b in pairwise(known))
    else:
        assert not lengths


def test_an_axis_may_rest_beyond_the_target_within_the_static_error() -> None:
    model = clutch_model()
    count = model.bench.encoder.resolution
    error = Quantity(value=0.5, unit="rad")
    spec = Spec(
        format="spec/1",
        name="s",
        axis="rotary",
        drive="current",
        overshoot_percent=2.0,
        static_error=error,
    )
    assert with_tolerance(model, spec, 10.0).overshoot_percent == pytest.approx(5.0)
    assert with_tolerance(model, spec, 100.0).overshoot_percent == 2.0
    coarse = replace(spec, static_error=None)
    assert with_tolerance(model, coarse, 1.0).overshoot_percent == pytest.approx(100.0 * count)
    assert (
        with_tolerance(model, replace(spec, overshoot_percent=None), 1.0).overshoot_percent is None
    )


def test_the_text_names_length_figure_and_limit(
    documents_of_axis: tuple[Model, Spec],
    default_controller: Controller,
) -> None:
    model, spec = documents_of_axis
    test = design_test(model, spec)
    controller = default_controller
    shorter = play_shorter_steps(test, controller)
    assert shorter is not None
    shortest = f"{shorter.steps[0].length:.3g}"
    text = shorter_text(shorter)
    assert text == (
        f"shorter steps of {shortest} rad: requirements met on 5 plants (rest not judged)"
    )
    slow = shorter.steps[0].verdict
    column = [one.key for one in slow.metrics].index("response_time_95_s")
    values, reserves, met = slow.values.copy(), slow.reserves.copy(), slow.met.copy()
    values[2, column], reserves[2, column], met[2, column] = 0.5, -2.0, 0
    broken = changed(slow, values=values, reserves=reserves, met=met)
    failed = changed(shorter, steps=(changed(shorter.steps[0], verdict=broken), *shorter.steps[1:]))
    limit = f"allowed <= {spec.response_time_95_s:.4g} s"
    text = shorter_text(failed)
    assert text.startswith(
        f"shorter steps of {shortest} rad: requirements not met, response 95 % 0.5 s at {shortest} "
        f"rad ({limit}); "
    )
    assert "--scenario" in text
    assert len(text) <= 190
    shown = shorter_json(failed)
    assert (shown["met"], shown["message"], shown["not_judged"]) == (False, text, ["rest"])
    assert shown["steps"][0]["requirements"][column]["value"] == 0.5
    values[2, column] = math.inf
    reserves[2, column] = -math.inf
    never = changed(slow, values=values, reserves=reserves, met=met)
    failed = changed(shorter, steps=(changed(shorter.steps[0], verdict=never),))
    assert f"response 95 % not reached at {shortest} rad ({limit})" in shorter_text(failed)
    dead = changed(slow, failed={1: "the drive cannot move the axis"})
    failed = changed(shorter, steps=(changed(shorter.steps[0], verdict=dead),))
    assert "not met, the drive cannot move the axis; if" in shorter_text(failed)
