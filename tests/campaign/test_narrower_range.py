"""A failed search names the range that prevents a design, if a candidate passes without it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from frictool.adapters.parameter_intervals import breakaway_ratio
from frictool.campaign import automatic_design, design_trial
from frictool.campaign.automatic_design import EASINGS, AutomaticDesign, design_automatically
from frictool.campaign.design_trial import DesignTest, design_test
from frictool.campaign.narrower_range import narrowed
from frictool.campaign.views.search_view import narrower_words, refusal_lines, search_json
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate
from frictool.documents.spec import Spec
from frictool.simulate.axis_variants import parameters_of
from frictool.synth.search.pi_cascade import PI_CASCADE
from tests.support.turntable import IMPOSSIBLE, POSSIBLE, RANGES, turntable

CANDIDATES = 12


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Search only one family with few candidates, on few drawn plants."""
    monkeypatch.setattr(design_trial, "DRAWN", 8)
    monkeypatch.setattr(design_trial, "OTHERS", 4)
    families = (replace(PI_CASCADE, candidates=CANDIDATES),)
    monkeypatch.setattr(automatic_design, "FAMILIES", families)


def searched(model: Model, spec: Spec) -> tuple[AutomaticDesign, DesignTest]:
    test = design_test(model, spec)
    return design_automatically(test), test


@pytest.mark.usefixtures("few")
def test_a_breakaway_whose_range_prevents_a_design_is_named_with_a_range_that_allows_one() -> None:
    found, test = searched(turntable(), POSSIBLE)
    assert not found.passed
    assert found.findings is not None
    narrower = found.findings.narrower
    assert narrower is not None
    low, value, high = RANGES["breakaway"]
    assert (narrower.parameter, narrower.low, narrower.unit) == ("breakaway", low, "N m")
    assert narrower.whole == (low, high)
    assert value < narrower.high < high
    lines = refusal_lines(found, test)
    assert lines[-2].startswith("narrow the range of a parameter; with this range, ")
    assert lines[-1] == f"  breakaway: 1.4 to {narrower.high:.4g} N m (range: 1.4 to 7 N m)"
    assert not any("relax several limits" in line for line in lines)
    assert search_json(found)["narrower_range"] == {
        "parameter": "breakaway",
        "unit": "N m",
        "low": 1.4,
        "high": narrower.high,
        "range": [1.4, 7.0],
    }
    # a search on an axis with this range finds a design
    assert searched(turntable(breakaway=(low, value, narrower.high)), POSSIBLE)[0].passed


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("highest", [pytest.param(2.2, marks=pytest.mark.accept), 7.0])
def test_no_range_is_named_if_the_nominal_plant_cannot_meet_the_specification(
    highest: float,
) -> None:
    model = turntable(breakaway=(1.4, 1.7, highest))
    found, test = searched(model, IMPOSSIBLE)
    assert not found.passed
    assert narrower_words(found) == ""
    assert search_json(found)["narrower_range"] is None
    assert not any("narrow the range" in line for line in refusal_lines(found, test))
    assert found.findings is not None
    assert not found.findings.nominal
    # with a candidate for the nominal plant, the ranges are the first remedy
    alone = replace(found, findings=replace(found.findings, relaxations=(), nominal=True))
    lines = refusal_lines(alone, test)
    head = next(k for k, line in enumerate(lines) if line.endswith("narrow the widest ranges"))
    factors = [float(line.split("factor ")[1].split(")")[0]) for line in lines[head + 1 :]]
    assert factors == sorted(factors, reverse=True)
    assert f"(factor {highest / 1.4:.3g}); test: `frictool excite --for breakaway=10%`" in lines[-1]
    weight = structs.replace(model.parameters.offset, value=-8.0, low=-8.1, high=-7.9)
    parameters = structs.replace(model.parameters, offset=weight)
    heavy = replace(test, model=structs.replace(model, parameters=parameters))
    assert (
        "the offset is above this range, so that ramps cannot show"
        in refusal_lines(alone, heavy)[-1]
    )


def test_all_plants_of_a_narrowed_model_lie_in_the_narrower_range() -> None:
    for name, ends in {
        "inertia": (0.018, 0.021),
        "viscous": (0.045, 0.06),
        "coulomb": (1.35, 1.6),
        "constant": (0.79, 0.82),
        "breakaway": (1.4, 2.5),
    }.items():
        test = design_test(narrowed(turntable(), name, ends), POSSIBLE)
        values = [plant[name] for plant in test.plants if name in plant]
        assert len(values) > 40
        assert ends[0] <= min(values) < max(values) <= ends[1]


def test_a_breakaway_without_a_range_keeps_its_ratio_to_a_narrowed_coulomb_friction() -> None:
    model = turntable(coulomb=(1.0, 1.5, 2.0))
    mechanics = structs.replace(model.bench.mechanics, breakaway=None)
    breakaway = Estimate(low=1.0, value=1.65, high=3.0, unit="N m", source="assumed")
    model = structs.replace(
        model,
        bench=structs.replace(model.bench, mechanics=mechanics),
        parameters=structs.replace(model.parameters, breakaway=breakaway),
    )
    narrow = narrowed(model, "coulomb", (1.0, 1.6))
    assert (parameters_of(narrow)["coulomb"].low, parameters_of(narrow)["coulomb"].high) == (1, 1.6)
    np.testing.assert_allclose(breakaway_ratio(narrow), breakaway_ratio(model))


def test_a_search_that_fails_for_the_longest_time_is_not_repeated_for_shorter_times(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    searched_times = []

    def failed(search: Any, easing: float, family: Any) -> tuple[Any, Any]:
        searched_times.append(easing)
        return search, SimpleNamespace(passed=False)

    monkeypatch.setattr(automatic_design._Search, "eased_outcome", failed)
    none: Any = None
    search = automatic_design._Search(none, none, none, none, lambda _: None)
    assert search.continued(PI_CASCADE) == []
    assert searched_times == [max(EASINGS)]
