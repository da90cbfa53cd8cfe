"""Tests of a search for a controller: shortened tests, the complete test, and shifted positions."""

from __future__ import annotations

from msgspec import structs

from frictool.campaign.design_trial import DesignTest
from frictool.campaign.draws.default_scenario import response_time
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.synth.search.played_tests import PlayedTests

SHORT = 2.5  # duration of a step in the shortened tests, in response times
AT_REST = 2.25  # time after which the axis must rest in the shortened tests, in response times
SCREENED = 2  # number of steps in the first shortened test


def search_tests(test: DesignTest) -> PlayedTests:
    """Return the tests that a candidate of a search must pass, cheapest first."""
    seconds = response_time(test.model, test.spec)
    short, spec = _shortened(test.scenario, test.spec, seconds)
    screened = structs.replace(short, steps=short.steps[:SCREENED])
    at_places = test.judges_of_places(short, spec)
    return PlayedTests(
        test.judge_of(screened, spec),
        test.judge_of(short, spec),
        test.judge,
        test.judges_of_others(short, spec),
        lambda controller, whole, until: test.worst_at_places(at_places, controller, whole, until),
        test.extremes,
        len(test.plants),
    )


def _shortened(scenario: Scenario, spec: Spec, response: float) -> tuple[Scenario, Spec]:
    steps = tuple(
        step
        if step.reference is None or step.duration_s is None
        else structs.replace(step, duration_s=min(step.duration_s, SHORT * response))
        for step in scenario.steps
        if step.hold_s is None
    )
    rest = spec.rest
    if rest is not None:
        rest = structs.replace(rest, after_s=min(rest.after_s, AT_REST * response))
    return structs.replace(scenario, steps=steps), structs.replace(
        spec, rest=rest, limit_cycle=None
    )
