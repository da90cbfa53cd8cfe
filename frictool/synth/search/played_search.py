"""Search for the parameters of a family whose controller meets a specification when played.

Each start is played first, then differential evolution (Storn and Price 1997, scipy) varies the
parameters around the best one. The objective is the largest shortfall of all figures, with the
reserve. A candidate is played on few plants first, and on all if it is promising; the plant on
which it is worst joins the few. The search ends with the first candidate that passes the whole
test with its reserve, passes on other plants without it, and is verified. If there is none, the
best ones are played again without the reserve. The figures of a candidate are the worst of all
tests in which it was played.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import differential_evolution

from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.errors import FrictoolError
from frictool.synth.search.candidate_family import CandidateFamily
from frictool.synth.search.design_scales import DesignScales
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

# errors of a candidate, which is then rejected: its numbers may be far outside of what is usual
UNUSABLE = (FrictoolError, *NOT_EVALUABLE)
SEED = 1
POPULATION, SPREAD = 18, 0.25  # candidates of a generation; their spread around the best start
PROMISING = RESERVE  # shortfall on the screen up to which a candidate is played on all plants
MOST_HARD = 10  # largest number of plants of the screen
RETRIED = 12  # candidates that are played again without the reserve


@dataclass(frozen=True, eq=False)
class Candidate:
    """Design with its objective and the runs of each test in which it was played, at least one."""

    design: Design
    shortfall: float
    runs: tuple[JudgedRuns, ...]

    @property
    def metrics(self) -> Sequence[Any]:
        """Return the requirements of the test that decides most of them."""
        return max((runs.metrics for runs in self.runs), key=len)

    @cached_property
    def missing(self) -> dict[str, float]:
        """Return the largest shortfall of each requirement without the reserve, by key."""
        each = [missing(runs) for runs in self.runs]
        keys = [metric.key for metric in self.metrics]
        return {key: max(one[key] for one in each if key in one) for key in keys}

    def worst(self, metric: Any) -> float:
        """Return the worst value of a requirement over all tests; NaN if none decides it."""
        values = [worst_value(runs, metric.key) for runs in self.runs]
        known = [value for value in values if not np.isnan(value)]
        return (max if metric.relation == "<=" else min)(known, default=np.nan)


@dataclass(frozen=True)
class FamilyOutcome:
    """Result of the search in one family.

    Attributes
    ----------
    family : str
        Description of the family.
    candidates : int
        Number of candidates played.
    best : Candidate or None
        The candidate that passed, or the one with the smallest shortfall; None if no candidate
        could be played.
    passed, with_reserve : bool
        True if the best candidate meets every requirement, and meets it with the reserve.
    refusals : tuple of str
        Reasons why candidates that passed the play were not verified.
    trade : tuple of Candidate
        Candidates in the order of play, for the trade between requirements.
    """

    family: str
    candidates: int
    best: Candidate | None
    passed: bool
    with_reserve: bool
    refusals: tuple[str, ...]
    trade: tuple[Candidate, ...]


class _FoundError(Exception):
    """A candidate passed everything."""

    def __init__(self, candidate: Candidate) -> None:
        super().__init__()
        self.candidate = candidate


class _ExhaustedError(Exception):
    """The number of candidates is reached."""


@dataclass
class CandidateSearch:
    """Search of a family.

    Attributes
    ----------
    family : CandidateFamily
        Designs to search.
    scales : DesignScales
        Scales of the actuator.
    tests : PlayedTests
        Judges of rising cost.
    controller : callable
        `controller(design)` returns the controller to play; raises FrictoolError.
    verify : callable
        `verify(design)` raises FrictoolError if the controller is not accepted.
    """

    family: CandidateFamily
    scales: DesignScales
    tests: PlayedTests
    controller: Callable[[Design], Controller]
    verify: Callable[[Design], None]
    hard: list[int] = field(default_factory=list)
    played: list[Candidate] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    tried: int = 0

    def run(self, progress: Callable[[str], None]) -> FamilyOutcome:
        """Return the outcome; the same inputs give the same outcome."""
        self.hard = list(self.tests.hard)
        progress(f"search: {self.family.name}")
        try:
            self._evolve()
        except _FoundError as found:
            return self._outcome(found.candidate, passed=True, with_reserve=True)
        except _ExhaustedError:
            pass
        progress(f"search: {self.family.name}, the best candidates without reserve")
        return self._without_reserve()

    def _evolve(self) -> None:
        starts = self.family.starts
        figures = [self._objective(start) for start in starts]
        best = starts[int(np.argmin(figures))]
        random = np.random.Generator(np.random.PCG64(SEED))
        spread = SPREAD
        while True:  # until a candidate passes or their number is reached
            population = best + random.normal(0.0, spread, (POPULATION, best.size))
            population[: len(starts)] = starts
            differential_evolution(
                self._objective,
                [(0.0, 1.0)] * best.size,
                init=np.clip(population, 0.0, 1.0),
                maxiter=self.family.candidates,
                seed=random,
                mutation=(0.4, 0.9),
                recombination=0.8,
                tol=0.0,
                atol=0.0,
                polish=False,
            )
            spread *= 2.0  # all candidates were equal

    def _objective(self, unit: Vector) -> float:
        """Return the shortfall at a point of the unit cube; raise _FoundError if it passes."""
        if self.tried >= self.family.candidates:
            raise _ExhaustedError
        self.tried += 1
        try:
            design = self.family.design(self.scales, self.family.values(unit))
            controller = self.controller(design)
            runs = [self.tests.screen(controller, self.hard)]
            value = shortfall(runs[0])
            if value <= PROMISING:
                runs.append(self.tests.short(controller, None))
                value = max(value, shortfall(runs[-1]))
                self._add_hard(runs[-1])
            if value <= 0.0:
                runs.append(self.tests.whole(controller, None))
                value = shortfall(runs[-1])
                self._add_hard(runs[-1])
            if value <= 0.0:
                for one in self.tests.without_reserve(controller, runs[-1]):
                    runs.append(one)
                    value = max(value, shortfall(one, 0.0))
                    if value > 0.0:
                        break
        except UNUSABLE:
            return FAILED
        candidate = Candidate(design, value, tuple(runs))
        self.played.append(candidate)
        if value <= 0.0:
            if self._verified(design):
                raise _FoundError(candidate)
            return 1.0
        return value

    def _verified(self, design: Design) -> bool:
        try:
            self.verify(design)
        except UNUSABLE as error:
            self.refusals.append(str(error))
            return False
        return True

    def _add_hard(self, runs: JudgedRuns) -> None:
        """Add the plant with the largest shortfall to the plants of the screen."""
        each = shortfalls(runs).max(axis=1)
        worst = runs.plants[int(np.argmax(each))]
        if each.max() > 0.0 and worst not in self.hard and len(self.hard) < MOST_HARD:
            self.hard.append(worst)

    def _without_reserve(self) -> FamilyOutcome:
        ranked = sorted(self.played, key=lambda one: one.shortfall)
        near = [one for one in ranked if one.shortfall <= 2.0 * RESERVE][:RETRIED]
        retried = []
        for one in near:
            controller = self.controller(one.design)
            runs = []
            for played in self._all_tests(controller):
                runs.append(played)
                if shortfall(played, 0.0) > 0.0:
                    break
            else:
                if self._verified(one.design):
                    found = replace(one, runs=tuple(runs))
                    return self._outcome(found, passed=True, with_reserve=False)
            again = replace(one, runs=(*one.runs, *runs))
            self.played[self.played.index(one)] = again
            retried.append(again)
        best = min(retried, key=lambda one: max(one.missing.values()), default=None)
        best = best or (ranked[0] if ranked else None)
        return self._outcome(best, passed=False, with_reserve=False)

    def _all_tests(self, controller: Controller) -> Iterator[JudgedRuns]:
        """Yield the runs of a controller in the tests of rising cost, from `short` on."""
        yield self.tests.short(controller, None)
        whole = self.tests.whole(controller, None)
        yield whole
        yield from self.tests.without_reserve(controller, whole)

    def _outcome(
        self, best: Candidate | None, *, passed: bool, with_reserve: bool
    ) -> FamilyOutcome:
        return FamilyOutcome(
            self.family.name,
            self.tried,
            best,
            passed,
            with_reserve,
            tuple(dict.fromkeys(self.refusals)),
            tuple(self.played),
        )
