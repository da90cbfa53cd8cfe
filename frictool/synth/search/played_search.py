"""Search for the parameters of a family whose controller meets a specification in simulation.

To play a candidate means to simulate its controller. First, the starting points of the family are
played. Then differential evolution (candidate_evolution.py) varies the parameters around the best
starting point. Each requirement must be met with a reserve, a distance to the limit. The shortfall
of a requirement is the missing part of its reserve. The objective is the largest shortfall plus a
fraction of the sum of all shortfalls. A candidate is played on few plants first, and on all plants
if it is promising; the plant with the worst result is then added to the few plants. A test ends
early if the simulated plants already make the candidate worse than the candidate that it would
replace. The plants with the worst results in the last tests are played first. The search ends with
the first candidate that meets three conditions: it passes the whole test with the reserve, it
passes the tests with other plants without the reserve, and it is verified. If there is no such
candidate, the search continues without the reserve from the best candidates. The values of a
candidate are the worst values of all tests in which the candidate was played.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np

from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.errors import FrictoolError
from frictool.synth.search.candidate_evolution import evolve
from frictool.synth.search.candidate_family import CandidateFamily
from frictool.synth.search.design_scales import DesignScales
from frictool.synth.search.nearest_text import nearest_words
from frictool.synth.search.played_tests import (
    FAILED,
    RESERVE,
    JudgedRuns,
    PlayedTests,
    missing,
    shortfall,
    shortfalls,
    worst_value,
)
from frictool.typing import Vector
from frictool.verify.document_check import NOT_EVALUABLE

# errors after which a candidate is rejected
UNUSABLE = (FrictoolError, *NOT_EVALUABLE)
SEED = 1
POPULATION, SPREAD = 18, 0.25  # candidates of a generation; their spread around the best start
PROMISING = RESERVE  # shortfall on few plants up to which a candidate is played on all plants
REPORTED, REPORTED_S = 100, 10.0  # candidates, and seconds, between two progress messages
MOST_HARD = 10  # largest number of plants in the test on few plants
# number of tests on all plants with known worst plants, after which these plants are complete
COLLECTED = 20
CONTINUED = 0.5  # number of candidates without the reserve, relative to the number with it
NEAR = 0.1  # spread of the candidates without the reserve around the best one


class PlayedExtent(IntEnum):
    """Largest test that a candidate completed: none, with few plants, or with all plants."""

    NONE = 0
    FEW = 1
    ALL = 2


@dataclass(frozen=True, eq=False)
class Candidate:
    """Design with its point (d,) in the unit cube of the family, and its simulated tests."""

    design: Design
    point: Vector
    runs: tuple[JudgedRuns, ...]
    extent: PlayedExtent = PlayedExtent.NONE

    @property
    def metrics(self) -> Sequence[Any]:
        """Return the requirements of the simulated test that has the most requirements."""
        return max((runs.metrics for runs in self.runs), key=len)

    @cached_property
    def missing(self) -> dict[str, float]:
        """Return the largest violation of each requirement in all tests.

        The keys of the result are the keys of the requirements. `played_tests.missing` defines the
        violation.
        """
        each = [missing(runs) for runs in self.runs]
        keys = [metric.key for metric in self.metrics]
        return {key: max(one[key] for one in each if key in one) for key in keys}

    @property
    def largest_missing(self) -> float:
        """Return the largest relative violation of a limit; 0 or less if all limits are met."""
        return max(self.missing.values())

    @property
    def worst_requirement(self) -> Any:
        """Return the requirement with the largest relative violation of its limit."""
        key = max(self.missing, key=self.missing.__getitem__)
        return next(one for one in self.metrics if one.key == key)

    @property
    def distance(self) -> tuple[int, float]:
        """Return a sort key: the candidate nearest to the limits of the specification comes first.

        Violations are lower bounds if the candidate was not played on all plants. A candidate that
        was played on more plants therefore comes before a candidate that was played on fewer.
        """
        return -self.extent, self.largest_missing

    @property
    def plants(self) -> int:
        """Return the number of plants on which the candidate was played.

        The plants of the tests `others` and `places` are not counted.
        """
        return len({plant for runs in self.runs[:2] for plant in runs.plants})

    def worst(self, metric: Any) -> float:
        """Return the worst value of a requirement in all tests; NaN if no test determines it."""
        values = [worst_value(runs, metric.key) for runs in self.runs]
        known = [value for value in values if not np.isnan(value)]
        return (max if metric.relation == "<=" else min)(known, default=np.nan)


@dataclass(frozen=True)
class FamilyOutcome:
    """Result of the search in one family.

    - family: description of the family
    - candidates: number of candidates played
    - best: candidate that passed, else the candidate with the smallest shortfall; None if no
      candidate could be played
    - passed: True if the best candidate meets every requirement
    - with_reserve: True if the best candidate meets every requirement with the reserve
    - refusals: reasons why candidates that passed the simulation were not verified
    - trade: candidates in the order in which they were played, to show the trade-off. The values
      of a stopped candidate belong to the plants up to the stop
    """

    family: str
    candidates: int
    best: Candidate | None
    passed: bool
    with_reserve: bool
    refusals: tuple[str, ...]
    trade: tuple[Candidate, ...]

    @property
    def least_missing(self) -> float:
        """Return `largest_missing` of the best candidate that completed a test."""
        complete = [one.largest_missing for one in self.trade if one.extent > PlayedExtent.NONE]
        return min(complete, default=FAILED)


class _FoundError(Exception):
    """Signal that ends the search: a candidate passed all tests and was verified."""

    def __init__(self, candidate: Candidate) -> None:
        super().__init__()
        self.candidate = candidate


class _ExhaustedError(Exception):
    """Signal that ends the search: the largest number of candidates was played."""


@dataclass
class CandidateSearch:
    """Search for the best parameters of a family.

    - family: designs to search
    - scales: scales of the rig and the specification
    - tests: simulated tests in the order of their cost
    - controller: `controller(design)` returns the controller to play; raises FrictoolError
    - verify: `verify(design)` raises FrictoolError if the controller is not accepted

    The other fields are the state of the search.
    """

    family: CandidateFamily
    scales: DesignScales
    tests: PlayedTests
    controller: Callable[[Design], Controller]
    verify: Callable[[Design], None]
    hard: set[int] = field(default_factory=set)
    order: list[int] = field(default_factory=list)
    played: list[Candidate] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    tried: int = 0
    repeated: int = 0
    reserve: float = RESERVE
    most: int = field(init=False)
    progress: Callable[[str], None] = field(init=False)
    begun: float = 0.0
    reported: float = 0.0

    def __post_init__(self) -> None:
        self.most = self.family.candidates

    def run(self, progress: Callable[[str], None]) -> FamilyOutcome:
        """Search the family and return the outcome; the same inputs give the same outcome.

        progress: called with a text at the start of each search, and during the search with an
        estimate of the remaining time [s].
        """
        random = self._begin(progress)
        progress(f"search: {self.family.name}")
        found = self._found(self._from_starts, random)
        if found is None and any(one.extent > PlayedExtent.NONE for one in self.played):
            progress(f"search: {self.family.name}, without reserve, from the best candidates")
            self.reserve = 0.0
            self.most += round(CONTINUED * self.family.candidates)
            found = self._found(self._from_nearest, random)
        return self.outcome(found)

    def run_from(self, start: Vector, progress: Callable[[str], None]) -> FamilyOutcome:
        """Search near a point (d,) of the unit cube, without a reserve; return the outcome."""
        random = self._begin(progress)
        progress(f"search: {self.family.name}, from the design of an easier specification")
        self.reserve = 0.0
        self.most = round(CONTINUED * self.family.candidates)
        return self.outcome(
            self._found(lambda drawn: self._evolve([start], start, NEAR, drawn), random)
        )

    def run_at(self, point: Vector, reserve: float) -> FamilyOutcome:
        """Play the candidate at a point (d,) of the unit cube only; return the outcome.

        reserve: relative distance to each limit that the candidate must keep.
        """
        random = self._begin(lambda text: None)
        self.reserve = reserve

        def play(_: np.random.Generator) -> None:
            self._objective(point)

        return self.outcome(self._found(play, random))

    def _begin(self, progress: Callable[[str], None]) -> np.random.Generator:
        self.progress = progress
        self.begun = self.reported = time.monotonic()
        self.hard = set(self.tests.hard)
        self.order = list(dict.fromkeys([*self.tests.hard, *range(self.tests.plants)]))
        return np.random.Generator(np.random.PCG64(SEED))

    def outcome(self, found: Candidate | None = None) -> FamilyOutcome:
        """Return the outcome up to now, with the candidate that passed, if there is one."""
        return FamilyOutcome(
            self.family.name,
            self.tried,
            found or self._nearest(),
            found is not None,
            found is not None and self.reserve > 0.0,
            tuple(dict.fromkeys(self.refusals)),
            tuple(self.played),
        )

    def _found(
        self, search: Callable[[np.random.Generator], None], random: np.random.Generator
    ) -> Candidate | None:
        try:
            search(random)
        except _FoundError as found:
            return found.candidate
        except _ExhaustedError:
            pass
        return None

    def _from_starts(self, random: np.random.Generator) -> None:
        starts = self.family.starts
        figures = [self._objective(start) for start in starts]
        self._evolve(starts, starts[int(np.argmin(figures))], SPREAD, random)

    def _from_nearest(self, random: np.random.Generator) -> None:
        complete = [one for one in self.played if one.extent > PlayedExtent.NONE]
        nearest = sorted(complete, key=lambda one: one.largest_missing)[:POPULATION]
        self._evolve([one.point for one in nearest], nearest[0].point, NEAR, random)

    def _nearest(self) -> Candidate | None:
        # a candidate of the complete test that only lacks the reserve is nearer than any miss
        missed = [
            one
            for one in self.played
            if self.refusals or one.largest_missing > 0.0 or one.extent == PlayedExtent.ALL
        ]
        return min(missed or self.played, key=lambda one: one.distance, default=None)

    def _evolve(
        self,
        starts: Sequence[Vector],
        best: Vector,
        spread: float,
        random: np.random.Generator,
    ) -> None:
        while True:  # until a candidate passes, or the largest number is played
            population = best + random.normal(0.0, spread, (POPULATION, best.size))
            population[: len(starts)] = starts
            evolve(self._objective, np.clip(population, 0.0, 1.0), random)
            spread *= 2.0  # all candidates were equal

    def _objective(self, unit: Vector, parent: float = np.inf) -> float:
        """Play the candidate at a point of the unit cube, and return its shortfall.

        parent: if the shortfall exceeds this value, a lower bound of the shortfall suffices.
        Raises _FoundError if the candidate passes all tests and is verified, and _ExhaustedError
        if the largest number of candidates was played.
        """
        if self.tried >= self.most:
            raise _ExhaustedError
        self.tried += 1
        self._report()
        try:
            design = self.family.design(self.scales, self.family.values(unit))
            candidate, value = self._play(design, unit, parent)
        except UNUSABLE:
            return FAILED
        self.played.append(candidate)
        if value <= 0.0:
            if self._verified(design):
                raise _FoundError(candidate)
            return 1.0
        return value

    def _report(self) -> None:
        """Report every REPORTED candidates, or after REPORTED_S seconds if candidates take long."""
        now = time.monotonic()
        due = self.tried % REPORTED == 0 or now - self.reported >= REPORTED_S
        if not due or not self.played:
            return
        self.reported = now
        left = (self.most - self.tried) * (now - self.begun) / self.tried
        nearest = min(self.played, key=lambda one: one.distance)
        self.progress(
            f"search: {self.family.name}, {self.tried} of {self.most} candidates, about {left:.0f} "
            "s for all others; nearest: "
            f"{nearest_words(nearest, self.tests.plants, self.reserve)}"
        )

    def _play(self, design: Design, unit: Vector, parent: float) -> tuple[Candidate, float]:
        """Play a candidate, and return it with its shortfall.

        If the shortfall exceeds `parent`, the returned value may be a lower bound.
        """
        controller = self.controller(design)
        few = [plant for plant in self.order if plant in self.hard]
        runs = [self.tests.screen(controller, few, self._above(max(parent, PROMISING)))]
        value = shortfall(runs[0], self.reserve)
        extent = PlayedExtent.FEW if len(runs[0].plants) == len(few) else PlayedExtent.NONE
        if value > PROMISING:
            self._move_forward(runs[0])
            return Candidate(design, unit, tuple(runs), extent), value
        runs.append(self._short(controller, parent))
        value = max(value, shortfall(runs[-1], self.reserve))
        if len(runs[-1].plants) == self.tests.plants:
            extent = PlayedExtent.ALL
        self._add_hard(runs[-1])
        if value <= 0.0:
            until = None if self._collects else self._above(parent)
            runs.append(self.tests.whole(controller, None, until))
            value = shortfall(runs[-1], self.reserve)
            self._add_hard(runs[-1])
        if value <= 0.0:
            # a shortfall up to the parent's must be exact
            beyond = max(parent, 0.0)
            for one in self.tests.without_reserve(
                controller, runs[-1], lambda played: shortfall(played, 0.0) > beyond
            ):
                runs.append(one)
                value = max(value, shortfall(one, 0.0))
                if value > 0.0:
                    break
        return Candidate(design, unit, tuple(runs), extent), value

    def _short(self, controller: Controller, parent: float) -> JudgedRuns:
        """Return the results of the test `short`.

        The test stops when the candidate is worse than its parent. Exception: the search with the
        reserve simulates all plants while it collects the worst plants in `hard` (`_collects`).
        """
        if self._collects:
            runs = self.tests.short(controller, None)
            worst = int(np.argmax(shortfalls(runs, self.reserve).max(axis=1)))
            self.repeated = self.repeated + 1 if runs.plants[worst] in self.hard else 0
            return runs
        return self.tests.short(controller, tuple(self.order), self._above(parent))

    @property
    def _collects(self) -> bool:
        """Return True while the worst plants of tests on all plants are collected in `hard`.

        The collection ends with MOST_HARD plants, or if COLLECTED tests in a row add no plant.
        """
        return self.reserve > 0.0 and len(self.hard) < MOST_HARD and self.repeated < COLLECTED

    def _above(self, limit: float) -> Callable[[JudgedRuns], bool]:
        return lambda runs: shortfall(runs, self.reserve) > limit

    def _verified(self, design: Design) -> bool:
        try:
            self.verify(design)
        except UNUSABLE as error:
            self.refusals.append(str(error))
            return False
        return True

    def _add_hard(self, runs: JudgedRuns) -> None:
        worst = self._move_forward(runs)
        if worst is not None and len(self.hard) < MOST_HARD:
            self.hard.add(worst)

    def _move_forward(self, runs: JudgedRuns) -> int | None:
        """Move the worst plant to the front of `order`, and return this plant.

        The result is None if all plants keep the reserve.
        """
        each = shortfalls(runs, self.reserve).max(axis=1)
        if each.max() <= 0.0:
            return None
        worst = runs.plants[int(np.argmax(each))]
        self.order.remove(worst)
        self.order.insert(0, worst)
        return worst
