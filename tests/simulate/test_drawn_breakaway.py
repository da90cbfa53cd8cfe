"""The breakaway of drawn and given plants: its range, its limit, and both directions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec.structs import replace

from frictool.adapters.axis_model import axis_of
from frictool.campaign.design_trial import design_test
from frictool.campaign.draws.factor_space import FactorSpace, plant_factors, space_of
from frictool.documents.laws import Backward, FrictionOverPosition, Laws, Polynomial
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.engine.axis_friction import breakaway_at, coulomb_at
from frictool.simulate.axis_variants import parameters_of, variants_of
from frictool.simulate.closed_loop import simulate_closed_loop
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario

COULOMB = (0.095, 0.1, 0.105)  # N m: low, value, high
DIRECTIONS = (1.0, -1.0)


def model_of(
    breakaway: tuple[float, float, float],
    source: str = "identified",
    lifelong: tuple[float, float, float] | None = None,
) -> Model:
    """Return the clutch with an identified Coulomb friction and this breakaway (low, value, high);
    `lifelong`: the same in the bench."""
    model = clutch_model()
    parameters = replace(
        model.parameters,
        coulomb=Estimate(COULOMB[1], COULOMB[0], COULOMB[2], "N m", source="identified"),
        breakaway=Estimate(breakaway[1], breakaway[0], breakaway[2], "N m", source=source),
    )
    bench = model.bench
    if lifelong is not None:
        known = Quantity(value=lifelong[1], low=lifelong[0], high=lifelong[2], unit="N m")
        bench = replace(bench, mechanics=replace(bench.mechanics, breakaway=known))
    return replace(model, parameters=parameters, bench=bench)


def space(model: Model, **spans: Span) -> FactorSpace:
    return space_of(plant_factors(parameters_of(model), spans, {}))


def drawn(space: FactorSpace, count: int = 2000) -> dict[str, np.ndarray]:
    units = np.random.default_rng(3).random((count, space.size))
    return dict(zip(space.names, space.values(units).T, strict=True))


def given(model: Model, **values: float) -> np.ndarray:
    quantities = {
        name: Quantity(value=value, unit=parameters_of(model)[name].unit)
        for name, value in values.items()
    }
    return variants_of(model, scenario(variants="given", given=quantities))[0].array


def with_backward(model: Model, coulomb: float, breakaway: float | None) -> Model:
    def side(value: float) -> Estimate:
        return Estimate(value, unit="N m", source="identified")

    backward = Backward(
        coulomb=side(coulomb), breakaway=None if breakaway is None else side(breakaway)
    )
    return replace(model, laws=Laws(backward=backward))


def test_a_range_of_the_bench_is_drawn_over_its_whole_width_above_the_coulomb_friction() -> None:
    model = model_of((0.11, 0.12, 0.13), lifelong=(0.05, 0.12, 0.25))
    values = drawn(space(model))
    assert np.all(values["breakaway"] >= values["coulomb"])
    assert 0.05 <= values["breakaway"].min() < 0.06
    assert 0.24 < values["breakaway"].max() <= 0.25
    # a low friction does not limit the breakaway
    assert values["breakaway"][values["coulomb"] < 0.03].max() > 0.23


def test_an_assumed_breakaway_is_1_to_1_5_times_the_drawn_coulomb_friction() -> None:
    model = model_of((COULOMB[0], 1.1 * COULOMB[1], 1.5 * COULOMB[2]), source="assumed")
    values = drawn(space(model))
    ratio = values["breakaway"] / values["coulomb"]
    assert 1.0 <= ratio.min() < 1.01
    assert 1.49 < ratio.max() <= 1.5 * (1.0 + 1e-12)


def test_an_identified_breakaway_is_drawn_relative_to_the_coulomb_friction() -> None:
    model = model_of((0.112, 0.12, 0.126))
    values = drawn(space(model))
    ratio = values["breakaway"] / values["coulomb"]
    # quotients of the lower ends 1.179, of the upper ends 1.2; of the breakaway's ends 1.12, 1.26
    assert ratio.min() == pytest.approx(0.112 / 0.095, rel=1e-3)
    assert ratio.max() == pytest.approx(1.2, rel=1e-3)
    assert ratio.max() <= 1.2 * (1.0 + 1e-12)


def test_a_breakaway_that_alone_is_identified_keeps_its_interval() -> None:
    """The Coulomb friction is known from the bench only: 0.018 to 0.18 N m."""
    model = model_of((0.112, 0.12, 0.126))
    bench = replace(model.parameters.coulomb, value=0.099, low=0.018, high=0.18, source="bench")
    values = drawn(space(replace(model, parameters=replace(model.parameters, coulomb=bench))))
    below = values["coulomb"] < 0.112
    assert np.all((values["breakaway"][below] >= 0.112) & np.all(values["breakaway"] <= 0.18))
    assert np.all(values["breakaway"] >= values["coulomb"])


def test_without_an_interval_the_ratio_is_constant() -> None:
    model = model_of((0.12, 0.12, 0.12))
    assert "breakaway" not in space(model).names
    for variant in variants_of(model, scenario(variants="random", plants=5))[1:]:
        assert set(variant.values) == {"inertia", "viscous", "coulomb", "constant"}
        assert variant.axis.breakaway == pytest.approx(1.2 * variant.axis.coulomb)


def test_a_range_of_the_scenario_replaces_the_ratio() -> None:
    model = model_of((0.112, 0.12, 0.126))
    values = drawn(space(model, breakaway=Span(0.2, 0.3, "N m"), coulomb=Span(0.1, 0.25, "N m")))
    assert np.all(values["breakaway"] >= np.maximum(0.2, values["coulomb"]))
    assert values["breakaway"].max() > 0.295


def test_the_other_parameters_of_a_random_plant_and_the_first_plants_stay_the_same() -> None:
    fixed, varied = model_of((0.12, 0.12, 0.12)), model_of((0.112, 0.12, 0.126))

    def plants(model: Model, count: int) -> list[dict[str, float]]:
        made = variants_of(model, scenario(variants="random", plants=count, seed=4))[1:]
        return [dict(one.values) for one in made]

    few, many = plants(varied, 3), plants(varied, 30)
    assert few == many[:3]
    alone = [{k: v for k, v in one.items() if k != "breakaway"} for one in many]
    assert alone == plants(fixed, 30)
    assert len({one["breakaway"] for one in many}) == 30


@pytest.mark.parametrize("opposite", [None, 0.15])
def test_a_given_breakaway_acts_in_both_directions(opposite: float | None) -> None:
    model = with_backward(model_of((0.12, 0.12, 0.12)), 0.09, opposite)
    array = given(model, breakaway=0.24)
    factor = 2.0
    assert breakaway_at(array, 1.0, 0.0, 0.0) == pytest.approx(factor * 0.12)
    assert breakaway_at(array, -1.0, 0.0, 0.0) == pytest.approx(factor * (opposite or 0.12))
    # the Coulomb friction does not change
    assert coulomb_at(array, 1.0, 0.0) == pytest.approx(0.1)
    assert coulomb_at(array, -1.0, 0.0) == pytest.approx(0.09)


def test_a_given_breakaway_is_the_nominal_plant_s_or_has_its_ratio() -> None:
    model = with_backward(model_of((0.12, 0.12, 0.12)), 0.09, 0.15)
    np.testing.assert_allclose(given(model, breakaway=0.12), axis_of(model).as_array(), rtol=1e-14)
    level = parameters_of(model)["coulomb"].nominal
    np.testing.assert_allclose(
        given(model, coulomb=1.3 * level, breakaway=1.3 * 0.12),
        given(model, coulomb=1.3 * level),
        rtol=1e-14,
    )


def test_the_effort_at_the_onset_of_motion_is_the_given_breakaway_in_both_directions() -> None:
    model = with_backward(model_of((0.12, 0.12, 0.12)), 0.1, 0.12)
    mechanics = replace(model.bench.mechanics, backlash=None, backlash_coulomb=None)
    model = replace(model, bench=replace(model.bench, mechanics=mechanics))
    values = {"breakaway": Quantity(value=0.3, unit="N m")}
    log = simulate_closed_loop(
        model, controller(), scenario(variants="given", given=values), Provenance("a test", "0")
    )
    signals = log.streams[0].signals
    moving = signals["velocity"] != 0.0
    onsets = np.flatnonzero(moving[1:] & ~moving[:-1]) + 1
    forward = onsets[signals["velocity"][onsets] > 0.0]
    backward = onsets[signals["velocity"][onsets] < 0.0]
    assert forward.size
    assert backward.size
    for chosen, sign in ((forward, 1.0), (backward, -1.0)):
        assert np.all(sign * signals["effort"][chosen] >= 0.3 * (1.0 - 1e-9))


def test_every_draw_of_a_breakaway_with_its_own_shape_over_the_position_is_a_plant() -> None:
    """The breakaway falls over the travel and the Coulomb friction rises; at every position in both
    directions, the breakaway is at least the Coulomb friction, also at the ends of the range."""
    law = FrictionOverPosition(
        Span(0.0, 60.0, "rad"),
        Polynomial((0.095, 1e-4), (0.1, 2e-4)),
        Polynomial((0.16, -3e-4), (0.2, -1e-3, 1e-5)),
    )
    model = with_backward(model_of((0.11, 0.15, 0.19), lifelong=(0.02, 0.15, 0.4)), 0.1, 0.16)
    model = replace(model, laws=replace(model.laws, position=law))
    factors = space(model)
    corners = [[(k >> i) & 1 for i in range(factors.size)] for k in range(2**factors.size)]
    smallest = math.inf
    for row in factors.values(np.array(corners, dtype=float)):
        array = given(model, **dict(zip(factors.names, map(float, row), strict=True)))
        for position in np.linspace(0.0, 60.0, 241):
            for direction in DIRECTIONS:
                excess = breakaway_at(array, direction, position, 0.0) / coulomb_at(
                    array, direction, position
                )
                assert excess >= 1.0 - 1e-6
                smallest = min(smallest, excess)
    assert smallest < 1.001  # the limit is not too high


def test_the_test_of_a_design_has_both_ends_of_the_breakaway_at_each_vertex() -> None:
    spec = clutch_spec()
    fixed = design_test(model_of((0.12, 0.12, 0.12)), spec)
    test = design_test(model_of((0.11, 0.12, 0.13), lifelong=(0.05, 0.12, 0.25)), spec)
    assert len(test.plants) == len(fixed.plants)
    assert not any("breakaway" in plant for plant in fixed.plants)
    count = test.vertices
    for number, plant in enumerate(test.plants[1 : 1 + 2 * count]):
        high = number < count
        expected = 0.25 if high else max(0.05, plant["coulomb"])
        assert plant["breakaway"] == pytest.approx(expected)
        assert ("largest" if high else "smallest") in test.names[1 + number]
    for plant in test.plants[1 + 2 * count :]:
        assert max(0.05, plant["coulomb"]) <= plant["breakaway"] <= 0.25
    # all other values are those of the test without a range
    for one, other in zip(test.plants, fixed.plants, strict=True):
        assert {k: v for k, v in one.items() if k != "breakaway"} == dict(other)
