"""Default scenario that tests a controller: four steps, from the bench and the specification.

The axis starts at 8 % of the travel and steps to 88, 8, 56 and 24 %, as in thesis 5.4.1 (5, 55, 5,
35 and 15 rad of 63 rad). Each step lasts 5 response times. The last step is longer if `rest` or
`limit_cycle` is specified: by `rest.after_s` for `rest`, by 30 s for `limit_cycle`, and by the
longer time for both.
"""

from __future__ import annotations

import math

from frictool.documents.model import Model
from frictool.documents.quantity import Quantity, si_unit
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spec import Spec

START, TARGETS = 0.08, (0.88, 0.08, 0.56, 0.24)  # positions, relative to the travel
LONGEST = max(TARGETS) - START  # longest step, relative to the travel
PART = 5.0  # duration of each step, in response times
WITHOUT_TRAVEL = 1000.0  # longest step on a bench without travel, in encoder steps
WITHOUT_RESPONSE = 1000.0  # response time without response_time_95_s, in samples
CYCLE_S = 30.0  # s, additional duration of the last step for a requirement on limit cycles


def longest_step(model: Model) -> float:
    """Return the length of the longest default step [rad | m]."""
    travel, resolution = model.bench.mechanics.travel, model.bench.encoder.resolution
    return WITHOUT_TRAVEL * resolution if travel is None else LONGEST * (travel.high - travel.low)


def response_time(model: Model, spec: Spec) -> float:
    """Return the specified response time [s]; WITHOUT_RESPONSE sample periods if there is none."""
    specified: float | None = spec.response_time_95_s
    return specified or WITHOUT_RESPONSE * model.bench.sample_period_s


def default_scenario(model: Model, spec: Spec) -> Scenario:
    """Return a scenario with four steps within the travel of the model's bench.

    The last step is long enough to decide `rest` and `limit_cycle`, if they are specified.
    """
    travel, unit = model.bench.mechanics.travel, si_unit("position", model.axis)
    low = 0.0 if travel is None else travel.low
    span = longest_step(model) / LONGEST
    period = model.bench.sample_period_s
    seconds = math.ceil(PART * response_time(model, spec) / period) * period
    hold = max(
        0.0 if spec.rest is None else spec.rest.after_s,
        0.0 if spec.limit_cycle is None else CYCLE_S,
    )
    last = len(TARGETS) - 1
    return Scenario(
        format="scenario/1",
        name="steps over the travel",
        axis=model.axis,
        drive=model.bench.actuator.drive,
        start=Quantity(value=low + START * span, unit=unit),
        steps=tuple(
            Step(
                reference=Quantity(value=low + share * span, unit=unit),
                duration_s=seconds + (hold if index == last else 0.0),
            )
            for index, share in enumerate(TARGETS)
        ),
    )
