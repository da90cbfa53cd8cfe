"""The search of a design: dimensionless parameters, shortfalls, and the text of the design."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from frictool.campaign.automatic_design import _without
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.metric_table import Rest
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth.search.candidate_controller import CandidateControllers
from frictool.synth.search.candidate_evolution import evolve
from frictool.synth.search.compensated_cascade import COMPENSATED_CASCADE
from frictool.synth.search.design_scales import DesignScales, design_scales, may_release
from frictool.synth.search.design_text import design_text
from frictool.synth.search.lpv_cascade import LPV_CASCADE
from frictool.synth.search.nearest_text import nearest_words
from frictool.synth.search.pi_cascade import PI_CASCADE
from frictool.synth.search.played_search import (
    COLLECTED,
    Candidate,
    CandidateSearch,
    PlayedExtent,
)
from frictool.synth.search.played_tests import (
    FAILED,
    RESERVE,
    STANDSTILL,
    JudgedRuns,
    PlayedTests,
    shortfall,
    shortfalls,
)
from frictool.synth.search.position_blocks import RELEASE
from frictool.typing import Vector
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.sprung_valve import SPEC as SPRUNG
from tests.support.sprung_valve import parsed, valve

SPEC = load(ROOT / "configs/clutch/spec.yaml", Spec)
KEYS = ("response_time_95_s", "static_error", "oscillations", "rest")


def runs(
    reserves: Sequence[Sequence[float]],
    met: Sequence[Sequence[int]],
    failed: dict[int, str] | None = None,
) -> Any:
    metrics = [SimpleNamespace(key=key, limit=0.0 if key == "rest" else 1.0) for key in KEYS]
    return SimpleNamespace(
        metrics=metrics,
        plants=tuple(range(len(reserves))),
        values=np.zeros((len(reserves), len(KEYS))),
        reserves=np.array(reserves, dtype=float),
        met=np.array(met),
        failed=failed or {},
    )


def test_the_reserve_is_wanted_of_continuous_figures_only() -> None:
    some = runs([[0.05, 0.3, 0.0, 0.0]], [[1, 1, 1, 1]])
    assert shortfall(some) == pytest.approx(0.0)
    less = runs([[0.02, 0.3, 0.0, 0.0]], [[1, 1, 1, 1]])
    assert shortfalls(less)[0] == pytest.approx([0.03, -0.25, 0.0, 0.0])
    assert shortfall(less) > 0.03
    assert shortfall(less, 0.0) <= 0.0


def test_failures_without_a_number_are_graded() -> None:
    near = runs([[-np.inf, -1.0, 0.0, -4.0]], [[0, 0, 1, 0]])
    far = runs([[-np.inf, -8.0, 0.0, -4.0]], [[0, 0, 1, 0]])
    assert 1.0 + math.log(STANDSTILL) < shortfall(near) < shortfall(far)
    undecided = runs([[np.nan, 0.3, 0.0, np.nan]], [[-1, 1, 1, -1]])
    assert shortfall(undecided) == 0.0
    assert shortfall(runs([[1.0] * 4], [[1] * 4], {0: "stiff"})) == FAILED
    rounded = runs([[-1e-16, 0.3, 0.0, 0.0]], [[1, 1, 1, 1]])
    assert shortfall(rounded, 0.0) == 0.0


@pytest.fixture
def scales() -> DesignScales:
    return design_scales(clutch_model(), SPEC, 50.4, 0.22)


def test_the_design_of_a_start_is_scaled_to_the_actuator(scales: DesignScales) -> None:
    design = PI_CASCADE.design(scales, PI_CASCADE.values(PI_CASCADE.starts[0]))
    assert scales.dead_time == pytest.approx(0.005)
    assert scales.braking == pytest.approx((0.0128 * 50 + 0.018) / 1.53e-5)
    assert design.prefilter is not None
    assert design.prefilter.natural_frequency_rad_s == pytest.approx(10.0 / 0.22, rel=1e-3)
    assert design.pid is not None
    assert design.pid.speed_gain is not None
    lightest = design.pid.speed_gain.value / 0.0134 * 0.014 / 1.11e-5
    assert lightest == pytest.approx(0.4 / (0.005 + 0.005 / 2.0), rel=1e-3)
    law = design.position_law
    assert law is not None
    assert law.band is not None
    assert law.band.value == pytest.approx(0.7 * 2.0)


def test_the_text_of_a_design_gives_the_same_design(scales: DesignScales, tmp_path: Path) -> None:
    for family in (PI_CASCADE, COMPENSATED_CASCADE, LPV_CASCADE):
        design = family.design(scales, family.values(family.starts[1]))
        text = design_text(design, "found by a test\nin two lines")
        assert text.startswith("# found by a test\n# in two lines\nformat: design/1\n")
        (tmp_path / "design.yaml").write_text(text)
        assert load(tmp_path / "design.yaml", Design) == design


def test_the_weights_of_the_clutch_are_those_of_its_fast_form(scales: DesignScales) -> None:
    design = LPV_CASCADE.design(scales, LPV_CASCADE.values(LPV_CASCADE.starts[0]))
    fast = load(ROOT / "configs/clutch/designs/fast.yaml", Design)
    for name in ("bandwidth_rad_s", "disturbance", "drive", "command"):
        expected = getattr(fast.weights, name)
        assert getattr(design.weights, name) == pytest.approx(expected, rel=0.02)
    assert design.weights.noise is not None
    assert design.weights.noise.value == pytest.approx(0.01, rel=0.02)
    assert design.channel_effort == pytest.approx(0.003, rel=0.1)


def test_a_static_error_below_one_count_is_refused() -> None:
    model = clutch_model()
    fine = 0.5 * model.bench.encoder.resolution
    assert SPEC.static_error is not None
    tight = Spec(
        format="spec/1",
        name="tight",
        axis="rotary",
        drive="current",
        static_error=type(SPEC.static_error)(value=fine, unit="rad"),
    )
    with pytest.raises(NoSolutionError, match="encoder's step"):
        design_scales(model, tight, 50.0, 0.22)


@dataclass
class Judge:
    """Judge that requires a damping of the prefilter, on plant 5 a larger one."""

    least: float = 0.9
    played: list[tuple[int, ...]] = field(default_factory=list)

    def __call__(
        self,
        controller: Controller,
        only: Sequence[int] | None = None,
        until: Callable[[JudgedRuns], bool] | None = None,
    ) -> JudgedRuns:
        plants = tuple(range(6) if only is None else only)
        assert controller.prefilter is not None
        found = controller.prefilter.damping
        for number in range(1, len(plants) + 1):
            some = plants[:number]
            reserves = [[found - self.least - 0.1 * (plant == 5), 1.0, 1.0, 0.0] for plant in some]
            made: JudgedRuns = runs(reserves, [[int(row[0] >= 0.0), 1, 1, 1] for row in reserves])
            made.plants = some  # type: ignore[misc] # a simple namespace
            if until is not None and until(made):
                break
        self.played.append(some)
        return made


def test_a_plant_on_which_a_candidate_fails_joins_the_screen(scales: DesignScales) -> None:
    model = clutch_model()
    screen, short, whole, others = Judge(), Judge(), Judge(), Judge()
    search = CandidateSearch(
        PI_CASCADE,
        scales,
        PlayedTests(screen, short, whole, (others,), lambda controller, runs, until: (), (0, 1), 6),
        CandidateControllers(model, SPEC),
        lambda design: None,
    )
    outcome = search.run(lambda step: None)
    assert outcome.passed
    assert outcome.with_reserve
    assert outcome.best is not None
    assert outcome.best.design.prefilter is not None
    assert outcome.best.design.prefilter.damping >= 1.0 + RESERVE
    assert screen.played[0] == (0, 1)
    assert sorted(screen.played[-1]) == [0, 1, 5]
    assert len(whole.played) == len(others.played) == 1
    # the plant that failed last is played first
    joined = next(k for k, plants in enumerate(screen.played) if 5 in plants)
    assert all(plants[0] == 5 for plants in screen.played[joined:])
    assert len(short.played) < len(screen.played)


def test_a_test_stops_with_the_plant_that_makes_a_candidate_worse_than_its_parent(
    scales: DesignScales,
) -> None:
    """No damping meets the requirement, so that only the first 18 candidates have no parent."""
    family = replace(PI_CASCADE, candidates=60)
    screen = Judge(least=5.0)
    search = CandidateSearch(
        family,
        scales,
        PlayedTests(screen, Judge(), Judge(), (), lambda controller, runs, until: (), (0, 1), 6),
        CandidateControllers(clutch_model(), SPEC),
        lambda design: None,
    )
    outcome = search.run(lambda step: None)
    assert not outcome.passed
    lengths = [len(plants) for plants in screen.played]
    assert lengths[:20] == [2] * 20
    assert lengths[20:60].count(1) > 10
    dampings = [one.design.prefilter.damping for one in outcome.trade if one.design.prefilter]
    stopped = [one.extent == PlayedExtent.NONE for one in outcome.trade]
    assert stopped == [length == 1 for length in lengths]
    assert outcome.best is not None
    assert outcome.best.design.prefilter is not None
    assert outcome.best.design.prefilter.damping == max(dampings)


def test_all_plants_are_simulated_until_the_worst_ones_are_known(
    scales: DesignScales, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Plant 5 is always the worst. After COLLECTED tests, worse children stop at their first plant.

    Every candidate passes the screen, and none passes the next test.
    """
    monkeypatch.setattr("frictool.synth.search.played_search.nearest_words", lambda *_: "none")
    family = replace(PI_CASCADE, candidates=120)
    screen, short = Judge(least=0.0), Judge(least=5.0)
    messages: list[str] = []
    search = CandidateSearch(
        family,
        scales,
        PlayedTests(screen, short, Judge(), (), lambda controller, runs, until: (), (0, 5), 6),
        CandidateControllers(clutch_model(), SPEC),
        lambda design: None,
    )
    outcome = search.run(messages.append)
    assert not outcome.passed
    lengths = [len(plants) for plants in short.played[:120]]
    assert lengths[:COLLECTED] == [6] * COLLECTED
    assert set(lengths[COLLECTED:]) == {1, 6}
    complete = [one for one in outcome.trade if one.extent == PlayedExtent.ALL]
    best = max(one.design.prefilter.damping for one in complete if one.design.prefilter)
    dampings = [one.design.prefilter.damping for one in outcome.trade if one.design.prefilter]
    assert best == max(dampings)
    assert any(re.search(r"100 of 120 candidates, about \d+ s for all", one) for one in messages)


def test_the_last_tests_end_with_the_first_plant_and_the_first_test_that_decide() -> None:
    others = Judge(least=5.0), Judge(least=5.0)
    played: list[object] = []

    def places(controller: object, whole: object, until: object) -> Any:
        played.append(until)
        yield None

    tests = PlayedTests(Judge(), Judge(), Judge(), others, places, (0,), 6)
    controller: Any = SimpleNamespace(prefilter=SimpleNamespace(damping=1.0))
    whole: Any = None

    def until(made: JudgedRuns) -> bool:
        return shortfall(made, 0.0) > 1.0

    first = next(iter(tests.without_reserve(controller, whole, until)))
    assert first.plants == (0,)
    assert [len(one.played) for one in others] == [1, 0]
    assert played == []
    assert len(list(tests.without_reserve(controller, whole))) == 3
    assert others[1].played == [tuple(range(6))]
    assert played == [None]


def test_figures_of_a_candidate_are_the_worst_of_all_tests(scales: DesignScales) -> None:
    """A candidate meets everything in the search, and oscillates on a plant of the last test."""
    design = PI_CASCADE.design(scales, PI_CASCADE.values(PI_CASCADE.starts[0]))
    oscillations = SimpleNamespace(key="oscillations", limit=1.0, relation="<=")

    def played(*reserves: float) -> Any:
        return SimpleNamespace(
            metrics=[oscillations],
            values=np.array([[1.0 - reserve] for reserve in reserves]),
            reserves=np.array([[reserve] for reserve in reserves]),
            met=np.array([[int(reserve >= 0.0)] for reserve in reserves]),
            failed={},
        )

    searched = Candidate(design, np.zeros(9), (played(0.0), played(0.0, 1.0)))
    assert searched.missing["oscillations"] == 0.0
    rejected = Candidate(design, np.zeros(9), (*searched.runs, played(1.0, -1.0)))
    assert rejected.missing["oscillations"] == pytest.approx(1.0)
    assert rejected.worst(oscillations) == 2.0


def test_a_candidate_that_is_not_verified_is_no_result(scales: DesignScales) -> None:
    model = clutch_model()

    def refuse(design: Design) -> None:
        raise NoSolutionError("not verified: for the test")

    family = type(PI_CASCADE)(PI_CASCADE.name, PI_CASCADE.parameters, PI_CASCADE.design, 40)
    tests = PlayedTests(
        Judge(), Judge(), Judge(), (Judge(),), lambda controller, runs, until: (), (0,), 6
    )
    search = CandidateSearch(family, scales, tests, CandidateControllers(model, SPEC), refuse)
    outcome = search.run(lambda step: None)
    assert not outcome.passed
    assert outcome.candidates == 60
    assert outcome.refusals == ("not verified: for the test",)


def test_a_bound_above_the_parent_changes_no_point_of_the_evolution() -> None:
    """The candidates are the same if the value of a worse child is only a lower bound."""
    points: dict[bool, list[list[float]]] = {True: [], False: []}

    def objective(bounded: bool, unit: Vector, parent: float) -> float:
        if len(points[bounded]) == 600:
            raise RuntimeError("enough")
        points[bounded].append(unit.tolist())
        value = float(((unit - 0.3) ** 2).sum() + 0.1 * np.abs(np.sin(20.0 * unit)).sum())
        return min(value, np.nextafter(parent, np.inf)) if bounded else value

    start = np.random.Generator(np.random.PCG64(7)).uniform(size=(18, 6))
    for bounded in (True, False):
        with pytest.raises(RuntimeError, match="enough"):
            evolve(partial(objective, bounded), start, np.random.Generator(np.random.PCG64(1)))
    assert points[True] == points[False]
    assert np.abs(np.array(points[True][-18:]) - 0.3).max() < 0.15  # near the minimum
    assert 0.0 <= np.min(points[True]) <= np.max(points[True]) <= 1.0


def test_a_candidate_played_on_all_plants_is_nearer_than_one_on_few(scales: DesignScales) -> None:
    design = PI_CASCADE.design(scales, PI_CASCADE.values(PI_CASCADE.starts[0]))

    def candidate(reserve: float, extent: PlayedExtent, plants: int) -> Candidate:
        made = runs([[reserve, 1.0, 1.0, 0.0]] * plants, [[int(reserve >= 0.0), 1, 1, 1]] * plants)
        for metric in made.metrics:
            metric.name, metric.unit, metric.relation = metric.key, "s", "<="
        made.values[:, 0] = 1.0 - reserve
        return Candidate(design, np.zeros(9), (made,), extent)

    few = candidate(-0.02, PlayedExtent.FEW, 4)
    every = candidate(-0.24, PlayedExtent.ALL, 73)
    stopped = candidate(-0.01, PlayedExtent.NONE, 1)
    assert min(few, every, stopped, key=lambda one: one.distance) is every
    assert min(few, stopped, key=lambda one: one.distance) is few
    assert nearest_words(every, 73, RESERVE) == (
        "response time 95 s 1.24 s (specified <= 1 s), on 73 of 73 plants"
    )
    met = candidate(0.01, PlayedExtent.ALL, 73)
    assert nearest_words(met, 73, RESERVE) == (
        "every limit met, but not with the reserve of 5 %, on 73 of 73 plants"
    )
    assert nearest_words(met, 73, 0.0) == "every limit met, on 73 of 73 plants"


def test_a_drive_that_must_hold_the_load_stays_on() -> None:
    """The spring needs 14.5 N m at the end of the travel, and the breakaway is 12 N m."""
    spec = parsed(SPRUNG, Spec)
    weak, strong = valve(0.88, 0.88, 0.88), valve(8.9, 8.9, 8.9)
    assert may_release(weak, spec)
    assert not may_release(strong, spec)
    # 4 N m/A: 3 A do not hold 14.5 N m, but 4 A do
    for drive, may in ((3.0, True), (4.0, False)):
        limited = structs.replace(spec, rest=Rest(after_s=1.0, drive=drive))
        assert may_release(strong, limited) is may
    scales = design_scales(strong, spec, 1.0, 0.5)
    family = _without(RELEASE, PI_CASCADE)
    law = family.design(scales, family.values(family.starts[0])).position_law
    assert law is not None
    assert (law.action, law.rest_speed, law.settled_speed) == ("none", None, None)
    released = design_scales(weak, spec, 1.0, 0.5)
    law = PI_CASCADE.design(released, PI_CASCADE.values(PI_CASCADE.starts[0])).position_law
    assert law is not None
    assert law.action == "brake"
