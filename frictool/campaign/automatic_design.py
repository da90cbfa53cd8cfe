"""Automatic design: search for a controller that meets a specification in simulation.

    DesignTest ──shortened──▶ PlayedTests ──synth/search/──▶ FamilyOutcome of each family

A family is a set of candidate controllers with the same structure. The simplest family is searched
first; the search ends when a candidate meets the specification. If every search fails, but the best
candidate violates the specification only slightly, its family is searched again for a longer
response time. Further searches shorten this time to the specified response time. Each further
search starts from the design of the previous search.

If the axis rings after it stops and the design may therefore fail (campaign/doubts.py), the family
is searched again for slower loops.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from msgspec import structs

from frictool.campaign.design_trial import DesignTest, longest_step_of
from frictool.campaign.doubts import slower_factor
from frictool.campaign.draws.default_scenario import response_time
from frictool.campaign.narrower_range import meets_with_nominal_plant, narrower_range
from frictool.campaign.search_findings import CandidateExamination, SearchFindings
from frictool.campaign.search_tests import search_tests
from frictool.documents.design import Design
from frictool.documents.design_blocks import FeedforwardDesign, ProfileDesign
from frictool.documents.missing_effects import undeclared_ringing
from frictool.documents.spec import Spec
from frictool.logs.quality.overspeed import exceeds_top_speed
from frictool.runtime.object_view import ResultView
from frictool.synth.feasibility import check_feasible, check_played_step
from frictool.synth.least_drive import check_least_drive
from frictool.synth.load_disturbance import disturbance
from frictool.synth.search.candidate_controller import CandidateControllers
from frictool.synth.search.candidate_family import CandidateFamily, rounded
from frictool.synth.search.compensated_cascade import COMPENSATED_CASCADE
from frictool.synth.search.design_scales import DesignScales, design_scales
from frictool.synth.search.lpv_cascade import LPV_CASCADE
from frictool.synth.search.pi_cascade import PI_CASCADE
from frictool.synth.search.played_search import Candidate, CandidateSearch, FamilyOutcome
from frictool.synth.search.played_tests import RESERVE, PlayedTests
from frictool.synth.search.position_blocks import RELEASE, fastest_filter
from frictool.synth.synthesis import require_identified, synthesise

FAMILIES = (PI_CASCADE, COMPENSATED_CASCADE, LPV_CASCADE)
# keys of the user's design that the search does not vary
KEPT = (
    "name",
    "position_law",
    "prefilter",
    "profile",
    "feedforward",
    "velocity",
    "friction_compensation",
    "form",
    "measurement_hold_samples",
)
TRACKED = ("tracking_error_peak", "tracking_error_rms", "settling_after_profile")
CONTINUABLE = 0.15  # largest relative violation of a limit for which a family is searched again
# on an axis that rings: most searches for a slower loop, and their number of candidates relative to
# the first search
SLOWER_LOOPS, SLOWER_SHARE = 3, 0.25
# axis above its top speed: number of slower prefilters that are simulated with the fastest plants,
# number of these plants, ratio of the requested speed to the top speed, and number of prefilters
# that are simulated with all plants, because others may become the fastest
SLOWER_PREFILTERS, FASTEST, SPEED_RESERVE, SPEED_TRIALS = 12, 3, 0.98, 2
EASINGS = (1.06, 1.12, 1.25)  # longer response times, relative to the specified response time


@dataclass(frozen=True, eq=False, repr=False)
class AutomaticDesign(ResultView):
    """Outcomes of the searched families (controllers of one structure), in the order of the search.

    A design that meets the specification can only be in the last outcome. `findings`: findings on
    the candidates if all searches failed; None if a search succeeded.
    """

    outcomes: tuple[FamilyOutcome, ...]
    findings: SearchFindings | None = None

    @property
    def passed(self) -> bool:
        """Return True if a design meets every requirement."""
        return self.outcomes[-1].passed

    @property
    def design(self) -> Design:
        """Return the design that meets every requirement; `passed` must be True."""
        best = self.outcomes[-1].best
        assert best is not None
        return best.design


class SearchInterruptedError(KeyboardInterrupt):
    """Interruption of a search by the user; `found`: outcomes of the families searched so far."""

    def __init__(self, found: AutomaticDesign) -> None:
        super().__init__()
        self.found = found


def design_automatically(
    test: DesignTest,
    progress: Callable[[str], None] = lambda _: None,
    wishes: Design | None = None,
) -> AutomaticDesign:
    """Search for a design that passes the test; the families are searched from simple to complex.

    Parameters
    ----------
    test : DesignTest
        Model, specification, steps and plants.
    progress : callable
        Function that is called with the name of each step of the search.
    wishes : Design, optional
        Design with method `auto`; the designed controller gets the name and the blocks of this
        design.

    Returns
    -------
    AutomaticDesign
        The outcome of each family that was searched.

    Raises
    ------
    FrictoolError
        If no controller can be designed for the documents.
    SearchInterruptedError
        If a KeyboardInterrupt ends the search.
    """
    model, spec = test.model, test.spec
    require_identified(model)
    disturbance(model)  # refuses loads that the structures cannot handle
    check_least_drive(model, spec, test.scenario, test.plants)
    length = longest_step_of(test.scenario)
    scales = design_scales(model, spec, length, response_time(model, spec))
    kept = _kept_blocks(spec, wishes)
    families = [_with_blocks(family, kept) for family in FAMILIES]
    if not scales.releases:
        families = [_without(RELEASE, family) for family in families]
    first = families[0]
    check_feasible(model, spec, first.design(scales, first.values(first.starts[0])))
    slowness = scales.dead_time + 1.0 / fastest_filter(scales)
    check_played_step(model, spec, length, slowness)
    tests = search_tests(test)
    search = _Search(test, tests, scales, CandidateControllers(model, spec), progress)
    searches = [search.of(family) for family in families]
    found: AutomaticDesign | None = None
    try:
        found = search.first_found(searches)
        found = search.tolerant(found, families)
        return found if "prefilter" in kept else search.within_top_speed(found, families)
    except KeyboardInterrupt:
        if found is None:
            outcomes = [one.outcome() for one in searches if one.tried]
            found = AutomaticDesign(tuple(outcomes))
        raise SearchInterruptedError(found) from None


@dataclass(frozen=True)
class _Search:
    test: DesignTest
    tests: PlayedTests
    scales: DesignScales
    controllers: CandidateControllers
    progress: Callable[[str], None]

    def first_found(self, searches: Sequence[CandidateSearch]) -> AutomaticDesign:
        """Search one family after another until a design passes; return the outcome of each search.

        If no design passes, `continued` searches the family of the best candidate again. This
        requires a limit of the response time, and a violation by this candidate of at most
        CONTINUABLE. If no design passes then, the candidates with the smallest violations are
        simulated with all plants.
        """
        outcomes = []
        for one in searches:
            outcomes.append(one.run(self.progress))
            if outcomes[-1].passed:
                return AutomaticDesign(tuple(outcomes))
        near = [(one.least_missing, k) for k, one in enumerate(outcomes)]
        if self.test.spec.response_time_95_s is not None and min(near)[0] <= CONTINUABLE:
            outcomes += self.continued(searches[min(near)[1]].family)
        if outcomes[-1].passed:
            return AutomaticDesign(tuple(outcomes))
        self.progress("search: nearest candidates, with all plants")
        examination = CandidateExamination(self.test, self.tests, self.controllers, self.progress)
        candidates = [one for outcome in outcomes for one in outcome.trade]
        findings = examination.findings(candidates)
        if findings.accepted:
            outcomes.append(
                replace(_family_of(findings, outcomes), best=findings.best, passed=True)
            )
        else:
            self.progress("search: narrower range of a parameter")
            examined = [*findings.examined, *candidates]
            findings = replace(
                findings,
                narrower=narrower_range(self.test, examined),
                nominal=meets_with_nominal_plant(self.test, examined),
            )
        return AutomaticDesign(tuple(outcomes), findings)

    def tolerant(
        self, found: AutomaticDesign, families: Sequence[CandidateFamily]
    ) -> AutomaticDesign:
        """Search slower loops if the axis rings after it stops, and `found` may therefore fail.

        The searches end when a loop tolerates the ringing, or when no slower loop of the family
        meets the specification. Return the slowest loop that meets the specification.
        """
        if undeclared_ringing(self.test.model) is None or not found.passed:
            return found
        scales = self.scales
        family = next(one for one in families if one.name == found.outcomes[-1].family)
        family = replace(family, candidates=round(SLOWER_SHARE * family.candidates))
        for _ in range(SLOWER_LOOPS):
            slower = slower_factor(self.controllers(found.design), self.test)
            if slower is None or slower == 1.0:
                break
            self.progress(f"search: a loop {slower:g} times slower, because the axis rings")
            scales = replace(scales, dead_time=slower * scales.dead_time)
            outcome = replace(self, scales=scales).of(family).run(self.progress)
            if not outcome.passed:
                break
            found = AutomaticDesign((*found.outcomes, outcome))
        return found

    def within_top_speed(
        self, found: AutomaticDesign, families: Sequence[CandidateFamily]
    ) -> AutomaticDesign:
        """Slow down the prefilter of the found design until no plant exceeds the top speed.

        The top speed is `mechanics.top_speed` of the bench. The design stays unchanged if no plant
        exceeds this speed, or if the loop with the slower prefilter violates the specification.
        """
        last = found.outcomes[-1]
        if not found.passed:
            return found
        family = next(one for one in families if one.name == last.family)
        for _ in range(SPEED_TRIALS):
            assert last.best is not None
            design = self.slower_prefilter(last.best)
            if design is None:
                break
            self.progress("search: a slower prefilter, to keep mechanics.top_speed")
            search = self.of(replace(family, design=lambda *_, made=design: made))
            outcome = search.run_at(last.best.point, RESERVE if last.with_reserve else 0.0)
            if not outcome.passed:
                break
            last = replace(last, best=outcome.best, trade=(*last.trade, *outcome.trade))
        return replace(found, outcomes=(*found.outcomes[:-1], last))

    def slower_prefilter(self, candidate: Candidate) -> Design | None:
        """Return the candidate's design with a prefilter that keeps the top speed.

        Only the plants with the largest speeds are simulated. Return None if no change is needed,
        if the candidate has no prefilter, or if every tried prefilter exceeds the top speed.
        """
        bench, design = self.test.model.bench, candidate.design
        whole = [one for one in candidate.runs if len(one.plants) == self.tests.plants]
        if design.prefilter is None or not whole:
            return None
        fastest = max(whole, key=lambda one: float(one.speeds.max()))
        speed = float(fastest.speeds.max())
        if bench.mechanics.top_speed is None or not exceeds_top_speed(speed, bench):
            return None
        plants = [fastest.plants[row] for row in np.argsort(-fastest.speeds)[:FASTEST]]
        for _ in range(SLOWER_PREFILTERS):
            share = SPEED_RESERVE * bench.mechanics.top_speed.value / speed
            frequency = rounded(share * design.prefilter.natural_frequency_rad_s)
            prefilter = structs.replace(design.prefilter, natural_frequency_rad_s=frequency)
            design = structs.replace(design, prefilter=prefilter)
            speed = float(self.tests.whole(self.controllers(design), plants).speeds.max())
            if not exceeds_top_speed(speed, bench):
                return design
        return None

    def of(self, family: CandidateFamily) -> CandidateSearch:
        return CandidateSearch(
            family,
            self.scales,
            self.tests,
            self.controllers,
            lambda design: _verify(self.test, design),
        )

    def eased(self, easing: float) -> _Search:
        spec = self.test.spec
        assert spec.response_time_95_s is not None
        response = easing * spec.response_time_95_s
        test = replace(self.test, spec=structs.replace(spec, response_time_95_s=response))
        scales = replace(self.scales, response=response)
        return replace(self, test=test, tests=search_tests(test), scales=scales)

    def eased_outcome(
        self, easing: float, family: CandidateFamily
    ) -> tuple[_Search, FamilyOutcome]:
        """Search a family of controllers for a longer response time; return (search, outcome)."""
        eased = self.eased(easing)
        self.progress(f"search: first for a response time of {eased.scales.response:.4g} s")
        return eased, eased.of(family).run(self.progress)

    def continued(self, family: CandidateFamily) -> list[FamilyOutcome]:
        """Search a family of controllers for longer response times, then for the specified time.

        The first search allows the longest time in EASINGS, because a design that exceeds this time
        exceeds all shorter times. The next searches allow the other times, shortest first, until a
        design passes. The allowed time is then shortened step by step to the specified time; each
        search starts from the previous design. Return a list with the outcome of the last search.
        The list is empty if a search fails before the specified time is reached.
        """
        *shorter, longest = EASINGS
        first, outcome = self.eased_outcome(longest, family)
        if not outcome.passed:
            return []
        number = len(shorter)
        for index, easing in enumerate(shorter):
            nearer, found = self.eased_outcome(easing, family)
            if found.passed:
                number, first, outcome = index, nearer, found
                break
        for step in (*reversed(EASINGS[:number]), 1.0):
            assert outcome.best is not None
            # with the scales of the first search, the same point denotes the same candidate
            harder = replace(self.eased(step), scales=first.scales)
            outcome = harder.of(family).run_from(outcome.best.point, self.progress)
            if not outcome.passed and step > 1.0:
                return []
        return [outcome]


def _family_of(findings: SearchFindings, outcomes: Sequence[FamilyOutcome]) -> FamilyOutcome:
    assert findings.best is not None
    point = findings.best.point
    return next(one for one in outcomes if any(each.point is point for each in one.trade))


def _kept_blocks(spec: Spec, wishes: Design | None) -> dict[str, object]:
    kept: dict[str, object] = {}
    if wishes is not None:
        kept = {key: value for key in KEPT if (value := getattr(wishes, key)) is not None}
    if any(getattr(spec, key) is not None for key in TRACKED):
        if "prefilter" not in kept:
            kept = {"profile": ProfileDesign(), **kept}
        if "friction_compensation" not in kept:
            kept = {"feedforward": FeedforwardDesign(), **kept}
    if "profile" in kept:
        kept["prefilter"] = None
    if "feedforward" in kept:
        kept["friction_compensation"] = None
    return kept


def _with_blocks(family: CandidateFamily, kept: Mapping[str, object]) -> CandidateFamily:
    return replace(
        family,
        design=lambda scales, values: structs.replace(family.design(scales, values), **kept),
    )


def _without(names: Collection[str], family: CandidateFamily) -> CandidateFamily:
    searched = tuple(one for one in family.parameters if one.name not in names)
    return replace(family, parameters=searched)


def _verify(test: DesignTest, design: Design) -> None:
    synthesise(test.model, test.spec, design, vertices_only=True)
