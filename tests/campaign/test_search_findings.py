"""The examination of a failed search: no relaxation without a simulation of all plants."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from frictool.campaign import search_findings
from frictool.campaign.search_findings import CandidateExamination, rounded_outwards
from frictool.campaign.views.search_view import relaxation_lines
from frictool.errors import NoSolutionError
from frictool.synth.search.played_search import Candidate, PlayedExtent
from frictool.synth.search.played_tests import PlayedTests

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
    tests = PlayedTests(plays, plays, plays, (plays,), lambda controller, whole: (), (0,), 3)
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
