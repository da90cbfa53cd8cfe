"""`relax: auto` on levels that are known in closed form: the largest W1 at each effort, within its
budget, or word that there is none."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.model_polytope import polytope
from frictool.documents.design import Design
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.documents.weights import Weights as Document
from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import PlantWeights, template
from frictool.synth.synthesis_problem import SynthesisProblem
from frictool.synth.weight_relaxation import (
    BUDGET,
    DEEPEST,
    TOLERANCE,
    Trade,
    relax,
    relaxed_problem,
)
from frictool.synth.weight_trade_off_plot import picture
from frictool.synth.weights import ChosenWeights, choose_weights
from studies.rigs.clutch_model import ROOT, clutch_model

START = ChosenWeights(PlantWeights(template(20.0, 0.5, 2 / 63), 1.0, 1.26), (), least_effort=0.01)
Level = Callable[[PlantWeights], float]


def known(floor: float, slope: float, power: float, share: float) -> Level:
    """gamma^2 = (floor W3)^2 + (gain W3^share W1^power)^2: a floor that effort alone sets, and what
    the disturbance adds."""
    return lambda w: math.hypot(floor * w.drive, slope * w.drive**share * w.disturbance**power)


def largest(
    floor: float, gain: float, power: float, share: float, drive: float, asked: float
) -> float:
    left = asked**2 - (floor * drive) ** 2
    return 0.0 if left <= 0.0 else (math.sqrt(left) / (gain * drive**share)) ** (1.0 / power)


@given(
    floor=st.floats(0.3, 10.0),
    gain=st.floats(2.0, 50.0),
    power=st.floats(0.4, 1.0),
    share=st.floats(0.2, 1.5),
    asked=st.sampled_from([0.5, 1.0, 2.0]),
)
def test_every_point_of_the_curve_is_the_largest_disturbance(
    floor: float, gain: float, power: float, share: float, asked: float
) -> None:
    level = known(floor, gain, power, share)
    trade = relax(START, level, asked)
    assert len(trade.points) <= BUDGET
    for point in trade.curve:
        assert point.level <= asked
        exact = min(1.0, largest(floor, gain, power, share, point.drive, asked))
        assert point.disturbance <= exact * (1.0 + 1e-9)
        if len(trade.points) < BUDGET and exact < 1.0:
            assert point.level >= (1.0 - TOLERANCE) * asked
    assert trade.chosen in trade.curve
    assert trade.chosen.disturbance >= 0.9 * max(point.disturbance for point in trade.curve) * (
        1.0 - 1e-9
    )
    assert level(trade.weights) == pytest.approx(trade.chosen.level)


@settings(max_examples=30, deadline=None)
@given(peak=st.floats(-3.5, -1.0), gain=st.floats(5.0, 100.0))
def test_an_effort_inside_is_chosen_where_less_of_it_buys_nothing(peak: float, gain: float) -> None:
    """The largest W1 falls on both sides of one effort: what is chosen lies at most a column beside
    it, and W1 is near the largest."""

    def level(w: PlantWeights) -> float:
        return gain * w.disturbance * math.exp(0.5 * (math.log(w.drive / 1.26) - peak) ** 2)

    trade = relax(START, level)
    assert trade.chosen.disturbance > 0.8 / gain
    assert math.log(trade.chosen.drive / 1.26) > peak - 0.2
    assert trade.chosen.drive >= max(p.drive for p in trade.curve if p.disturbance >= 0.9 / gain)


def test_the_strictest_weights_are_kept_where_they_are_achievable() -> None:
    trade = relax(START, lambda _: 0.7)
    assert trade.weights == START.weights
    assert len(trade.points) == 1
    assert "as they are" in trade.why


def test_a_smaller_level_asked_costs_disturbance_rejection() -> None:
    curves = [relax(START, known(1.0, 300.0, 0.7, 1.0), asked).curve for asked in (0.5, 1.0, 1.5)]
    found = [max(point.disturbance for point in curve) for curve in curves]
    assert found == sorted(found)
    assert found[0] < 0.5 * found[-1]


def test_where_nothing_reaches_the_level_it_says_how_near_it_came() -> None:
    with pytest.raises(NoSolutionError, match=r"the least is 1\.2.*lower weights.bandwidth_rad_s"):
        relax(START, lambda w: math.hypot(1.2, w.disturbance))


def test_plants_without_a_solution_count_as_unachievable() -> None:
    def level(w: PlantWeights) -> float:
        if w.drive > 0.3:
            raise NoSolutionError("nothing")
        return 10.0 * w.disturbance

    told: list[str] = []
    trade = relax(START, level, progress=told.append)
    assert any("gamma stays above 1" in line for line in told)
    assert sum("the largest W1 with gamma <= 1 is" in line for line in told) == len(trade.curve)
    assert trade.chosen.drive <= 0.3
    assert all(point.drive <= 0.3 for point in trade.curve)
    assert trade.chosen.disturbance == pytest.approx(0.1, rel=0.02)


def test_the_budget_holds_for_a_level_that_nothing_predicts() -> None:
    def level(w: PlantWeights) -> float:  # monotone, in steps
        return (
            math.inf
            if w.disturbance > 0.0371 * w.drive
            else 0.2
            if w.disturbance > 10.0 * DEEPEST
            else 0.1
        )

    trade = relax(START, level)
    assert len(trade.points) <= BUDGET
    assert trade.chosen.level <= 1.0


def test_only_the_disturbance_is_walked_where_the_effort_is_given_at_its_least() -> None:
    trade = relax(replace(START, least_effort=1.0), known(0.1, 20.0, 1.0, 0.0))
    assert len(trade.curve) == 1
    assert trade.chosen.drive == START.weights.drive
    assert trade.chosen.disturbance == pytest.approx(
        math.sqrt(1.0 - 0.126**2) / 20.0, rel=TOLERANCE
    )


def example() -> Trade:
    return relax(START, known(1.0, 10.0, 0.7, 1.0))


def test_the_picture_is_the_same_bytes_and_names_both_axes() -> None:
    first, second = picture(example(), "clutch"), picture(example(), "clutch")
    assert first == second
    for word in ("W1, disturbance rejection", "W3, effort", "gamma", "chosen"):
        assert word in first


def test_a_problem_gets_the_weights_that_bring_the_guides_bound_to_one() -> None:
    spec, speed = (
        load(ROOT / "configs/clutch/spec.yaml", Spec),
        load(ROOT / "configs/clutch/designs/speed.yaml", Design),
    )
    design = msgspec.structs.replace(speed, weights=Document(), relax="auto")
    model = clutch_model()
    chosen = choose_weights(model, spec, design)
    posed = SynthesisProblem(polytope(model), 3e-3, 1e-3, 1, chosen.weights, design, model, spec)

    def guide(one: SynthesisProblem) -> float:
        return 100.0 * one.weights.disturbance * one.weights.drive

    relaxed, trade = relaxed_problem(posed, chosen, guide)
    assert relaxed.weights == trade.weights
    assert guide(relaxed) == pytest.approx(trade.chosen.level)
    assert relaxed.weights.command * relaxed.weights.noise.gain == pytest.approx(
        chosen.weights.command * chosen.weights.noise.gain
    )
    with pytest.raises(NoSolutionError, match="relax: auto"):
        relaxed_problem(posed, chosen, lambda _: math.inf)
