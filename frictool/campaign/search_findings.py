"""Examination of a failed search: requirements that the best candidate misses, limits to relax.

During a search, a candidate with a large violation is simulated with few plants only. Here, the
candidates with the smallest violations are simulated with all plants. A relaxation of one
requirement is reported only if a candidate then passes all tests of the search and the
verification.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from msgspec import structs

from frictool.campaign.design_trial import DesignTest
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.synth.search.played_search import UNUSABLE, Candidate, PlayedExtent
from frictool.synth.search.played_tests import JudgedRuns, PlayedTests, missing, shortfalls
from frictool.synth.synthesis import synthesise

EXAMINED = 3  # number of candidates that are simulated with all plants
ATTEMPTS = 12  # largest number of candidates that are tried for the relaxation of a requirement


@dataclass(frozen=True)
class Relaxation:
    """Requirement, and a changed limit [SI] with which a candidate passes every test.

    The limit suffices; another search may pass with a smaller change.
    """

    metric: Any
    limit: float


@dataclass(frozen=True)
class NarrowerRange:
    """Range of one parameter with which a candidate passes every test.

    - parameter: key of the parameter
    - low, high: ends of the narrower range, in `unit`
    - whole: ends of the range of the model, in `unit`
    - unit: SI unit
    """

    parameter: str
    low: float
    high: float
    whole: tuple[float, float]
    unit: str


@dataclass(frozen=True, eq=False)
class SearchFindings:
    """Findings on the candidates of a search that found no design.

    - best: examined candidate with the smallest maximum violation over all plants; None if no
      examined candidate can be simulated with all plants
    - accepted: True if the best candidate passes every test and is verified
    - places: text with step and plant of the worst value, for each requirement that the best
      candidate misses
    - relaxations: requirements with a relaxed limit; each of these limits alone lets a candidate
      pass every test
    - examined: candidates with the smallest violations, and their results on all plants
    - narrower: range of one parameter with which a candidate passes every test, or None
    - nominal: True if a candidate meets every requirement on the nominal plant
    """

    best: Candidate | None = None
    accepted: bool = False
    places: Mapping[str, str] = field(default_factory=dict)
    relaxations: tuple[Relaxation, ...] = ()
    examined: tuple[Candidate, ...] = ()
    narrower: NarrowerRange | None = None
    nominal: bool = False


@dataclass(frozen=True)
class CandidateExamination:
    """Examination of the candidates of a search.

    - test: the complete test that a design must pass
    - tests: the tests of the search, cheapest first
    - controller: function that returns the controller of a design
    - progress: function that is called with the name of each step
    """

    test: DesignTest
    tests: PlayedTests
    controller: Callable[[Design], Controller]
    progress: Callable[[str], None] = lambda _: None

    def findings(self, candidates: Sequence[Candidate]) -> SearchFindings:
        """Return the findings on the candidates."""
        nearest = sorted(candidates, key=lambda one: one.distance)[:EXAMINED]
        played = [whole for one in nearest if (whole := self._on_all_plants(one)) is not None]
        if not played:
            return SearchFindings()
        best = min(played, key=lambda one: one.largest_missing)
        if best.largest_missing <= 0.0:
            return SearchFindings(best, self._is_verified(best.design, self.test.spec))
        relaxations = tuple(self._relaxations(best, candidates))
        return SearchFindings(best, False, self._places(best), relaxations, tuple(played))

    def played(self, design: Design) -> tuple[bool, int]:
        """Return (True if a design passes every test and is verified, number of plants).

        A test ends at the first plant that misses a requirement. The number is the sum of the
        plants that were simulated in each test.
        """
        try:
            runs = tuple(self._runs(design, missed, until=True))
        except UNUSABLE:
            return False, 0
        passed = not missed(runs[-1]) and self._is_verified(design, self.test.spec)
        return passed, sum(len(one.plants) for one in runs)

    def _on_all_plants(self, one: Candidate) -> Candidate | None:
        try:
            runs = list(self._runs(one.design, lambda played: missed(played)))
        except UNUSABLE:
            return None
        return replace(one, runs=tuple(runs), extent=PlayedExtent.ALL)

    def _runs(
        self, design: Design, condition: Callable[[JudgedRuns], bool], until: bool = False
    ) -> Iterator[JudgedRuns]:
        """Yield the results of a design in each test; end after results that meet `condition`.

        - condition: function that takes the results of a test, and returns True to end
        - until: True to apply `condition` after each plant of a test, and to end at once
        """
        controller = self.controller(design)
        whole = self.tests.whole(controller, None, condition if until else None)
        yield whole
        if condition(whole):
            return
        short = self.tests.short(controller, None, condition if until else None)
        yield short
        if condition(short):
            return
        for runs in self.tests.without_reserve(controller, whole, condition if until else None):
            yield runs
            if condition(runs):
                return

    def _places(self, best: Candidate) -> dict[str, str]:
        whole, controller = best.runs[0], self.controller(best.design)
        each = shortfalls(whole, 0.0)
        places = {}
        for column, metric in enumerate(whole.metrics):
            row = int(np.argmax(each[:, column]))
            if each[row, column] <= 0.0:
                continue
            plant = whole.plants[row]
            located = {one.key: one.where for one in self.test.judge.located(controller, plant)}
            where = located.get(metric.key)
            step = "" if where is None or where.time_s is None else self._step(where.time_s)
            places[metric.key] = f"{step}{self.test.names[plant]}"
        return places

    def _step(self, time: float) -> str:
        """Return a text with the number and the target of the step that begins at `time` [s]."""
        steps, half = self.test.scenario.steps, 0.5 * self.test.model.bench.sample_period_s
        begins = np.cumsum([0.0, *(step.seconds for step in steps)])
        number = int(np.searchsorted(begins, time + half))
        reference = steps[number - 1].reference
        unit = si_unit("position", self.test.scenario.axis)
        target = "" if reference is None else f" to {reference.value:.4g} {unit}"
        return f"step {number}{target}, "

    def _relaxations(
        self, best: Candidate, candidates: Sequence[Candidate]
    ) -> Iterator[Relaxation]:
        complete = [one for one in (best, *candidates) if one.extent > PlayedExtent.NONE]
        violated: dict[int, set[str]] = {}
        for number, metric in enumerate(best.metrics, start=1):
            self.progress(f"search: limits to relax, {number} of {len(best.metrics)}")
            limit = self._relaxed(metric, complete, violated)
            if limit is not None:
                yield Relaxation(metric, limit)

    def _relaxed(
        self, metric: Any, candidates: Sequence[Candidate], violated: dict[int, set[str]]
    ) -> float | None:
        """Return a limit of one requirement that lets a candidate pass every test, or None.

        `violated` contains the requirements that a design violated in earlier attempts, by the
        design's `id`. If another requirement is among them, the design fails without a simulation.
        """
        fitting = [
            one
            for one in candidates
            if math.isfinite(one.worst(metric)) and not others_missed(one.missing, metric.key)
        ]
        for one in sorted(fitting, key=lambda one: one.missing[metric.key])[:ATTEMPTS]:
            known = violated.setdefault(id(one.design), set())
            if known - {metric.key}:
                continue
            if (limit := self._passing_limit(one.design, metric, known)) is not None:
                return limit
        return None

    def _passing_limit(self, design: Design, metric: Any, violated: set[str]) -> float | None:
        """Return the limit with which a design passes every test; None if no limit suffices.

        Only the limit of the requirement `metric` is relaxed. The requirements that the design
        violates are added to `violated`.
        """

        def condition(played: JudgedRuns) -> bool:
            return others_missed(missing(played), metric.key)

        try:
            runs = tuple(self._runs(design, condition, until=True))
        except UNUSABLE:
            return None
        violated.update(key for one in runs for key, by in missing(one).items() if by > 0.0)
        value = Candidate(design, np.empty(0), runs).worst(metric)
        if condition(runs[-1]) or not math.isfinite(value):
            return None
        limit = rounded_outwards(value, metric.relation)
        spec = self.test.spec
        if metric.key == "modulus_margin":
            spec = structs.replace(spec, modulus_margin=limit)
        return limit if self._is_verified(design, spec) else None

    def _is_verified(self, design: Design, spec: Spec) -> bool:
        try:
            synthesise(self.test.model, spec, design, vertices_only=True)
        except UNUSABLE:
            return False
        return True


def missed(played: JudgedRuns) -> bool:
    """Return True if a requirement is violated."""
    return others_missed(missing(played), "")


def others_missed(violations: Mapping[str, float], key: str) -> bool:
    """Return True if a requirement other than `key` is violated."""
    return any(value > 0.0 for name, value in violations.items() if name != key)


def rounded_outwards(value: float, relation: str) -> float:
    """Round a value to four digits, up for the relation `<=` and down otherwise."""
    if value == 0.0:
        return 0.0
    scale = 10.0 ** (3 - math.floor(math.log10(abs(value))))
    rounded = math.ceil(value * scale) if relation == "<=" else math.floor(value * scale)
    return float(f"{rounded / scale:.6g}")
