"""The judge of controllers: the figures of `simulate` and `report`, plant by plant."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from frictool.campaign import ControllerJudge, plants_of_model
from frictool.campaign.trials.controller_judge import PlayedVerdict, relative_reserve
from frictool.campaign.trials.trials import MetricLimit
from frictool.errors import FrictoolError
from frictool.report.verdict import judge
from frictool.simulate.closed_loop import simulate_closed_loop
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario
from studies.rigs.verified_controller import truthful
from tests.support.provenance import HERE

SPEC = clutch_spec(rest=None)


def test_the_worst_figure_of_each_requirement_is_that_of_report() -> None:
    """Nominal plant and corners, without noise: the logs of both are the same."""
    model, by, test = clutch_model(), truthful(controller()), scenario()
    plants = plants_of_model(model, test)
    verdict = ControllerJudge(model, test, SPEC, plants)(by)
    log = simulate_closed_loop(model, by, msgspec.structs.replace(test, variants="vertices"), HERE)
    whole = judge(SPEC, [log], by)
    topics = [stream.topic for stream in log.axes]
    assert verdict.plants == tuple(range(len(topics)))
    for mine, theirs in zip(verdict.requirements, whole.requirements, strict=True):
        assert mine.metric.name == theirs.name
        assert mine.metric.limit == theirs.limit
        assert mine.metric.unit == theirs.unit
        assert mine.metric.relation == theirs.relation
        if theirs.name == "modulus_margin":  # report also judges the controller's vertices
            continue
        assert mine.met == theirs.met
        assert mine.value == (math.inf if theirs.value is None else theirs.value)
    peak = [one.name for one in whole.requirements].index("drive_peak")
    where = whole.requirements[peak].where
    assert where is not None
    largest = verdict.values[:, peak].max()
    assert verdict.values[topics.index(str(where.stream)), peak] == largest


def test_some_plants_have_the_figures_that_they_have_among_all() -> None:
    model, by = clutch_model(), truthful(controller())
    test = scenario(40.0, drive_noise=0.05, seed=4)
    every = ControllerJudge(model, test, SPEC, plants_of_model(model, test, random=3))
    verdict = every(by)
    few = every(by, only=(18, 2))
    assert few.plants == (18, 2)
    np.testing.assert_array_equal(few.values, verdict.values[[18, 2]])
    assert verdict.values.shape == (20, len(verdict.metrics))
    for index, one in enumerate(verdict.requirements):
        assert one.reserve == np.nanmin(verdict.reserves[:, index])
        assert one.value == verdict.values[one.plant, index]
    assert verdict.reserve == np.nanmin(verdict.reserves)


def test_a_simulation_ends_with_the_plant_that_decides_it() -> None:
    model, by = clutch_model(), truthful(controller())
    test = scenario(40.0)
    every = ControllerJudge(model, test, SPEC, plants_of_model(model, test))
    verdict = every(by)
    numbers: list[int] = []

    def ends(so_far: PlayedVerdict) -> bool:
        numbers.append(len(so_far.plants))
        return len(so_far.plants) == 3

    few = every(by, only=(5, 1, 9, 2), until=ends)
    assert numbers == [1, 2, 3]
    assert few.plants == (5, 1, 9)
    np.testing.assert_array_equal(few.values, verdict.values[[5, 1, 9]])
    np.testing.assert_array_equal(few.met, verdict.met[[5, 1, 9]])


def test_the_step_of_a_worst_value_is_located() -> None:
    """The value of the located requirement is that of the plant."""
    model, by = clutch_model(), truthful(controller())
    test = scenario(40.0)
    every = ControllerJudge(model, test, SPEC, plants_of_model(model, test))
    verdict = every(by, only=(4,))
    for column, one in enumerate(every.located(by, 4)):
        assert one.value == verdict.values[0, column]
        assert one.where is not None
    response = every.located(by, 4)[0]
    assert response.key == "response_time_95_s"
    assert response.where is not None
    assert response.where.step == 1
    assert response.where.time_s == pytest.approx(0.0)


def test_a_plant_that_cannot_be_simulated_is_named_and_the_others_are_judged() -> None:
    model, by = clutch_model(), truthful(controller())
    judge_of = ControllerJudge(model, scenario(40.0), SPEC, [{}, {"inertia": 0.0}])
    verdict = judge_of(by)
    assert "inertia is 0" in verdict.failed[1]
    assert np.isnan(verdict.values[1]).all()
    assert not np.isnan(verdict.values[0]).all()
    assert verdict.reserve == -math.inf
    assert not verdict.passed


def test_a_scenario_that_does_not_fit_is_an_error() -> None:
    model, by = clutch_model(), truthful(controller())
    beyond = scenario(40.0, start=1e6)
    with pytest.raises(FrictoolError, match="travel"):
        ControllerJudge(model, beyond, SPEC, [{}])(by)


def test_the_reserve_is_relative_to_the_limit_and_negative_beyond_it() -> None:
    most = MetricLimit("a", "a", "s", 0.2, "<=")
    least = MetricLimit("b", "b", "", 0.5, ">=")
    assert relative_reserve(most, 0.15) == pytest.approx(0.25)
    assert relative_reserve(most, math.inf) == -math.inf
    assert relative_reserve(least, 0.4) == pytest.approx(-0.2)
    assert relative_reserve(MetricLimit("c", "c", "A", 0.0, "<="), 0.1) == -0.1
