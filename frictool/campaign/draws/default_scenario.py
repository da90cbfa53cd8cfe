"""Default scenario that tests a controller: steps, from the bench and the specification.

The axis starts at 8 % of the travel and steps to 88, 8, 56 and 24 %, as in thesis 5.4.1 (5, 55, 5,
35 and 15 rad of 63 rad). A loop with dry friction and a limited drive is nonlinear: some loops
overshoot in short steps only. A short step back therefore follows the first step. Its length is a
tenth of the first step's length. It is longer if 5 % of its length, or its allowed overshoot, would
otherwise be smaller than the allowed static error or one encoder count. The short step is left out
if another step is at most 1.2 times as long.

Each step lasts 5 response times. The last step is longer by `rest.after_s` if `rest` is specified,
and by 30 s if `limit_cycle` is specified. If both are specified, the longer time is added.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from frictool.documents.model import Model
from frictool.documents.quantity import Quantity, si_unit
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spec import Spec
from frictool.synth.feasibility import resting_error, shortest_step

START, TARGETS = 0.08, (0.88, 0.08, 0.56, 0.24)  # positions, relative to the travel
PLACES = (START, *TARGETS)  # positions in the order in which the axis visits them
LONGEST = max(TARGETS) - START  # longest step, relative to the travel
SHORTEST = min(abs(b - a) for a, b in pairwise(PLACES))  # shortest step, relative to the travel
SHORT_PART = 0.1  # length of the short step, relative to the longest step
SAME = 1.2  # steps with a smaller ratio of their lengths count as equally long
PART = 5.0  # duration of each step, in response times
WITHOUT_TRAVEL = 1000.0  # longest step on a bench without travel, in encoder steps
WITHOUT_RESPONSE = 1000.0  # response time [samples] if response_time_95_s is not specified
CYCLE_S = 30.0  # s, additional duration of the last step for a requirement on limit cycles


def longest_step(model: Model) -> float:
    """Return the length of the longest default step [rad | m]."""
    travel, resolution = model.bench.mechanics.travel, model.bench.encoder.resolution
    return WITHOUT_TRAVEL * resolution if travel is None else LONGEST * (travel.high - travel.low)


def response_time(model: Model, spec: Spec) -> float:
    """Return the specified response time [s], by default WITHOUT_RESPONSE sample periods."""
    specified: float | None = spec.response_time_95_s
    return specified or WITHOUT_RESPONSE * model.bench.sample_period_s


def short_step(model: Model, spec: Spec) -> float | None:
    """Return the length of the short default step [rad | m]; None if it is left out."""
    length = max(SHORT_PART * longest_step(model), shortest_step(model, spec))
    overshoot = spec.overshoot_percent
    if overshoot is not None:  # the axis may rest beyond the target
        error = 100.0 * resting_error(model, spec)
        length = max(length, error / overshoot if overshoot > 0.0 else math.inf)
    return length if SAME * length < shortest_travel_step(model) else None


def shortest_travel_step(model: Model) -> float:
    """Return the length [rad | m] of the shortest default step, apart from the short step."""
    return SHORTEST / LONGEST * longest_step(model)


def default_scenario(model: Model, spec: Spec) -> Scenario:
    """Return a scenario with steps within the travel of the model's bench.

    The last step is long enough to decide `rest` and `limit_cycle`, if they are specified.
    """
    targets = [place_on_travel(model, share) for share in TARGETS]
    short = short_step(model, spec)
    if short is not None:
        targets.insert(1, targets[0] - short)
    seconds = step_duration(model, spec)
    hold = max(
        0.0 if spec.rest is None else spec.rest.after_s,
        0.0 if spec.limit_cycle is None else CYCLE_S,
    )
    durations = [seconds] * (len(targets) - 1) + [seconds + hold]
    return steps_scenario(model, place_on_travel(model, START), targets, durations)


def place_on_travel(model: Model, share: float) -> float:
    """Return the position [rad | m] at `share` of the travel, 0 (low end) to 1 (high end)."""
    travel = model.bench.mechanics.travel
    low = 0.0 if travel is None else travel.low
    return low + share * (longest_step(model) / LONGEST)


def step_duration(model: Model, spec: Spec) -> float:
    """Return the duration of a default step [s], a multiple of the sample period."""
    period = model.bench.sample_period_s
    return math.ceil(PART * response_time(model, spec) / period) * period


def steps_scenario(
    model: Model, start: float, targets: Sequence[float], durations: Sequence[float]
) -> Scenario:
    """Return a scenario that steps from `start` to each of `targets` [rad | m].

    `durations`: duration of each step [s].
    """
    unit = si_unit("position", model.axis)
    return Scenario(
        format="scenario/1",
        name="steps over the travel",
        axis=model.axis,
        drive=model.bench.actuator.drive,
        start=Quantity(value=start, unit=unit),
        steps=tuple(
            Step(reference=Quantity(value=target, unit=unit), duration_s=duration)
            for target, duration in zip(targets, durations, strict=True)
        ),
    )
