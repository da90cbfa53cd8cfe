"""Steps over smaller distances than in a controller's test, simulated after a passed test.

A loop with dry friction and a limited drive is nonlinear. A controller that meets a specification
in long steps can therefore violate it in shorter steps. A specification states no step length. The
simulated lengths lie between `shortest_step` (shortest step to which a response time can apply) and
`shortest_travel_step`. From the lowest and from the highest position of the default steps, the axis
steps inwards, back, and inwards again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from msgspec import structs

from frictool.campaign.design_trial import (
    GOLDEN,
    DesignTest,
    has_requirements,
    step_lengths,
)
from frictool.campaign.draws.default_scenario import (
    PLACES,
    SAME,
    place_on_travel,
    shortest_travel_step,
    step_duration,
    steps_scenario,
)
from frictool.campaign.trials.controller_judge import PlayedRequirement, PlayedVerdict
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.runtime.object_view import ResultView
from frictool.synth.feasibility import resting_error, shortest_step

SPACING, MOST = 2.0, 4  # ratio of successive lengths; largest number of lengths
LONG_HOLD = ("rest", "limit_cycle")  # requirements that are not judged in shorter steps
UNJUDGED = (*LONG_HOLD, "modulus_margin")  # the margin does not depend on the step


@dataclass(frozen=True, eq=False, repr=False)
class ShorterStep(ResultView):
    """Verdict on three steps of `length` [rad | m]: from `start` inwards, back, inwards again."""

    length: float
    start: float
    verdict: PlayedVerdict

    @property
    def failed(self) -> bool:
        """Return True if a plant violates a requirement, or could not be simulated."""
        return bool(self.verdict.failed) or any(
            one.met is False for one in self.verdict.requirements
        )


@dataclass(frozen=True, eq=False, repr=False)
class ShorterSteps(ResultView):
    """Verdicts on all shorter steps, shortest first.

    - plants: names of the plants by index
    - not_judged: keys of specified requirements that need a long hold, or that a run did not decide
    - unit: unit of a length
    """

    steps: tuple[ShorterStep, ...]
    plants: tuple[str, ...]
    not_judged: tuple[str, ...]
    unit: str

    @property
    def failed(self) -> bool:
        """Return True if a requirement is violated, or if a plant could not be simulated."""
        return any(step.failed for step in self.steps)

    @property
    def worst(self) -> tuple[ShorterStep, PlayedRequirement] | None:
        """Return the largest violation of a limit, and its step; None without a violation.

        Violations without a number (an axis that never settles) are returned last.
        """
        broken = [
            (step, one)
            for step in self.steps
            for one in step.verdict.requirements
            if one.met is False
        ]
        return min(
            broken, key=lambda two: (math.isinf(two[1].reserve), two[1].reserve), default=None
        )


def play_shorter_steps(test: DesignTest, controller: Controller) -> ShorterSteps | None:
    """Simulate steps over smaller distances than a test, with the nominal plant and some vertices.

    `DesignTest.extremes` lists the vertices. Return None in three cases:

    - the user provided the scenario of the test
    - no shorter step is long enough for the specification (`shortest_step`)
    - the specification has no requirement that a shorter step can decide
    """
    model, spec = test.model, test.spec
    judged = structs.replace(spec, **dict.fromkeys(UNJUDGED))
    lengths = shorter_lengths(test) if test.by_default and has_requirements(judged) else []
    if not lengths:
        return None
    # the extreme vertices have the largest and the smallest breakaway alternately
    chosen = [0] + [
        plant + index % 2 * test.vertices for index, plant in enumerate(test.extremes) if plant
    ]
    plants = [test.plants[index] for index in chosen]
    places = [math.fmod(index * GOLDEN, 1.0) for index in range(len(chosen))]
    steps = []
    for length in lengths:
        allowed = with_tolerance(model, judged, length)
        for scenario in _scenarios(test, length):
            verdict = test.judge_at(scenario, allowed, plants, places)(controller)
            assert scenario.start is not None
            steps.append(ShorterStep(length, scenario.start.value, verdict))
    undecided = {
        one.metric.key
        for step in steps
        if not step.verdict.failed
        for one in step.verdict.requirements
        if one.met is None
    }
    return ShorterSteps(
        tuple(steps),
        tuple(test.names[index] for index in chosen),
        tuple(
            one.key for one in test.judge.metrics if one.key in LONG_HOLD or one.key in undecided
        ),
        si_unit("position", model.axis),
    )


def shorter_lengths(test: DesignTest) -> list[float]:
    """Return the lengths [rad | m] of a test's shorter steps, from `shortest_step` upwards.

    Lengths that are close to a step of the test are left out.
    """
    low, high = shortest_step(test.model, test.spec), shortest_travel_step(test.model)
    if low * SAME >= high:
        return []
    count = min(MOST, math.ceil(math.log(high / low) / math.log(SPACING)))
    tested = step_lengths(test.scenario)
    lengths: list[float] = np.geomspace(low, high, count + 1)[:-1].tolist()
    return [one for one in lengths if not any(one / SAME < other < one * SAME for other in tested)]


def with_tolerance(model: Model, spec: Spec, length: float) -> Spec:
    """Return `spec` with an overshoot limit that suits a step of `length` [rad | m].

    The axis may rest beyond the target by `static_error`, or by one encoder count if the count is
    larger. An overshoot limit below this distance is raised to it.
    """
    if spec.overshoot_percent is None:
        return spec
    rest = 100.0 * resting_error(model, spec) / length
    return structs.replace(spec, overshoot_percent=max(spec.overshoot_percent, rest))


def _scenarios(test: DesignTest, length: float) -> list[Scenario]:
    """Return two scenarios with steps of `length` [rad | m]: inwards, back, and inwards again.

    One scenario starts at the lowest, the other at the highest position of the default steps. The
    third step repeats the first step, because reference_holds.py does not judge a first step in
    which the axis does not move.
    """
    model = test.model
    durations = [step_duration(model, test.spec)] * 3
    low, high = (place_on_travel(model, extreme(PLACES)) for extreme in (min, max))
    return [
        structs.replace(
            steps_scenario(model, start, [start + step, start, start + step], durations),
            seed=test.scenario.seed,
        )
        for start, step in ((low, length), (high, -length))
    ]
