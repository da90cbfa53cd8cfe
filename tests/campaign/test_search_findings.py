"""The examination of a failed search: no relaxation without a simulation of all plants."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from frictool.campaign import automatic_design, search_findings
from frictool.campaign.automatic_design import (
    AutomaticDesign,
    SearchInterruptedError,
    design_automatically,
)
from frictool.campaign.design_trial import design_test
from frictool.campaign.search_findings import CandidateExamination, rounded_outwards
from frictool.campaign.views.search_view import relaxation_lines
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth.search.played_search import Candidate, FamilyOutcome, PlayedExtent
from frictool.synth.search.played_tests import PlayedTests
from studies.rigs.clutch_model import ROOT, clutch_model

PLANTS = ("nominal plant", "v01", "v02")
METRICS = (
    SimpleNamespace(
        key="response_time_95_s", name="response_time_95", unit="s", relation="<=", limit=1.0
    ),
    SimpleNamespace(key="static_error", name="static_error", unit="rad", relation="<=", limit=0.1),
)
Values = Sequence[tuple[float, float]]  # response time and static error of each plant


def runs(values: Values, plants: Sequence[int]) -> Any:
    made = np.array([values[plant] for plant in plants])
    limits = np.array([1.0, 0.1])
    return SimpleNamespace(
        metrics=METRICS,
        plants=tuple(plants),
        values=made,
        reserves=1.0 - made / limits,
        met=(made <= limits).astype(int),
        failed={},
    )


def judge(
    values: Any, only: Sequence[int] | None = None, until: Callable[[Any], bool] | None = None
) -> Any:
    """Judge designs that are the values of their plants."""
    for number in range(1, len(PLANTS) + 1):
        made = runs(values, range(number))
        if until is not None and until(made):
            break
    return made


def located(values: Any, plant: int) -> Any:
    where = SimpleNamespace(time_s=2.0)
    return [SimpleNamespace(key=metric.key, where=where) for metric in METRICS]


def step(target: float, seconds: float) -> Any:
    return SimpleNamespace(seconds=seconds, reference=SimpleNamespace(value=target))


TEST: Any = SimpleNamespace(
    model=SimpleNamespace(bench=SimpleNamespace(sample_period_s=0.001)),
    spec=None,
    names=PLANTS,
    scenario=SimpleNamespace(axis="rotary", steps=[step(1.0, 2.0), step(1.2, 3.0)]),
    judge=SimpleNamespace(located=located),
)


def candidate(values: Values, played: Sequence[int] = (0,)) -> Candidate:
    design: Any = tuple(values)
    return Candidate(design, np.empty(0), (runs(values, played),), PlayedExtent.FEW)


def examination(
    monkeypatch: pytest.MonkeyPatch, verified: Callable[[Any], bool]
) -> CandidateExamination:
    def synthesise(model: Any, spec: Any, design: Any, vertices_only: bool) -> None:
        if not verified(design):
            raise NoSolutionError("not verified")

    monkeypatch.setattr(search_findings, "synthesise", synthesise)
    plays: Any = judge  # a design is its values
    tests = PlayedTests(plays, plays, plays, (plays,), lambda controller, whole, until: (), (0,), 3)
    return CandidateExamination(TEST, tests, lambda design: design)  # type: ignore[arg-type, return-value]


def test_a_relaxation_is_reported_only_if_a_candidate_passes_on_all_plants(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On the plant of the search, the fast candidate misses the response time only."""
    fast = candidate([(1.1, 0.05), (1.1, 0.05), (1.1, 0.3)])
    slow = candidate([(1.5, 0.05), (1.61803, 0.09), (1.6, 0.05)])
    found = examination(monkeypatch, lambda design: True).findings([fast, slow])
    (relaxed,) = found.relaxations
    assert (relaxed.metric.key, relaxed.limit) == ("response_time_95_s", 1.619)
    head, line = relaxation_lines(found)
    assert "each of these values suffices, and a smaller change may" in head
    assert line == "  response_time_95_s: 1.619 s"
    assert found.best is not None
    assert found.best.design == slow.design
    assert found.places == {"response_time_95_s": "step 2 to 1.2 rad, v01"}

    alone = examination(monkeypatch, lambda design: True).findings([fast])
    assert alone.relaxations == ()
    assert set(alone.places) == {"response_time_95_s", "static_error"}
    assert alone.places["static_error"] == "step 2 to 1.2 rad, v02"

    unverified = examination(monkeypatch, lambda design: design != slow.design)
    assert unverified.findings([fast, slow]).relaxations == ()


def test_a_candidate_with_two_violations_is_simulated_once_for_all_limits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On the plants of the search, it misses nothing: each limit might be the one to relax."""
    both = candidate([(0.9, 0.05), (0.9, 0.05), (1.2, 0.3)])
    tried: list[Any] = []
    steps: list[str] = []

    def counted(values: Any, only: Any = None, until: Any = None) -> Any:
        tried.append(until)
        return judge(values, only, until)

    found = examination(monkeypatch, lambda design: True)
    tests = replace(found.tests, whole=counted)
    found = replace(found, tests=tests, progress=steps.append).findings([both])
    assert found.relaxations == ()
    assert len([until for until in tried if until is not None]) == 1
    assert steps == ["search: limits to relax, 1 of 2", "search: limits to relax, 2 of 2"]


def test_a_candidate_that_passes_on_all_plants_is_accepted_if_it_is_verified(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    good = candidate([(0.9, 0.05)] * 3)
    assert examination(monkeypatch, lambda design: True).findings([good]).accepted
    found = examination(monkeypatch, lambda design: False).findings([good])
    assert not found.accepted
    assert found.best is not None
    assert found.best.largest_missing <= 0.0


def test_a_suggested_limit_is_not_below_the_value_that_must_meet_it() -> None:
    assert rounded_outwards(0.43211, "<=") == 0.4322
    assert rounded_outwards(0.43219, ">=") == 0.4321
    assert rounded_outwards(3.0, "<=") == 3.0
    assert rounded_outwards(0.0, "<=") == 0.0
    assert rounded_outwards(1234.56, "<=") == 1235.0


def test_an_interrupt_after_the_search_keeps_the_design_that_was_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The interrupt ends the search for a slower loop; the first loop met the specification."""
    passed = FamilyOutcome("PI cascade", 1, candidate([(0.9, 0.05)] * 3), True, True, (), ())

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    search = automatic_design._Search
    monkeypatch.setattr(search, "first_found", lambda *_: AutomaticDesign((passed,)))
    monkeypatch.setattr(search, "tolerant", interrupted)
    spec = load(ROOT / "configs/clutch/spec.yaml", Spec)
    with pytest.raises(SearchInterruptedError) as stopped:
        design_automatically(design_test(clutch_model(), spec))
    assert stopped.value.found.passed
    assert stopped.value.found.outcomes == (passed,)
