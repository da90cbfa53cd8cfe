"""Assessment of a bench: achievable precision of each parameter, and entropy of the encoder."""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictool.adapters.parameter_intervals import bench_intervals
from frictool.adapters.shortest_step import ShortestStepTimes, shortest_step_times
from frictool.documents.bench import Bench
from frictool.documents.quantity import Axis
from frictool.errors import EXIT_NO, FrictoolError
from frictool.identify.assess.assessment_inputs import (
    AssessmentInputs,
    AssessmentRequest,
    facts_of,
)
from frictool.identify.assess.entropy import SensorEntropy, sensor_entropy
from frictool.identify.assess.identifiability import PARAMETERS, QUANTILE, Identifiability, verdict
from frictool.identify.excite.bench_limits import limits_of
from frictool.identify.excite.cramer_rao import SLIDING, cramer_rao
from frictool.plant.polytope import corner_points
from frictool.runtime.object_view import ResultView

WANTED = 0.05  # default of the requested relative half width
FINEST = 1e-6  # smallest encoder step that is tried, relative to the bench's step
BISECTIONS = 40
USUAL = AssessmentRequest()


class NotIdentifiable(FrictoolError):
    """Error: the bench cannot reach a requested precision.

    The message names the parameters that miss their precision. If a finer encoder or a longer test
    would help, the message also states this remedy.
    """

    exit_code = EXIT_NO


@dataclass(frozen=True)
class ParameterAssessment:
    """Assessment of one parameter; precisions are half widths relative to the parameter's value.

    - verdict: method, test and expected precision with the encoder of the bench
    - wanted: requested precision
    - known: precision of the a-priori interval; None if the bench states no interval
    - target: the smaller of `wanted` and `known`
    - least: precision at the Cramér-Rao bound of the proposed test; None for breakaway and
      presliding
    - doubled: precision with an encoder of twice the resolution; None if not computable
    - step: largest encoder step [rad | m] with which the parameter is identifiable; None if even a
      step of FINEST times the bench's step is too large
    - counts: counts per revolution of an encoder with this step; None for a linear axis
    """

    parameter: str
    verdict: Identifiability
    wanted: float
    known: float | None
    target: float
    least: float | None
    doubled: float | None
    step: float | None
    counts: float | None


@dataclass(frozen=True, eq=False, repr=False)
class Assessment(ResultView):
    """Assessment of all parameters of a bench.

    - entropy: metric entropy of the encoder; None if the travel is unlimited
    - constant: relative half width of the a-priori interval of the effort constant
    - drive: shortest times in which the drive can complete 95 % of a position step, for the slowest
      and the fastest plant in the a-priori intervals; None if the length of the step is unknown
    """

    bench: Bench
    facts: AssessmentInputs
    rows: tuple[ParameterAssessment, ...]
    entropy: SensorEntropy | None
    constant: float
    drive: ShortestStepTimes | None


def assess(bench: Bench, request: AssessmentRequest = USUAL) -> Assessment:
    """Assess which parameters a bench can identify, and with which precision.

    Parameters
    ----------
    bench
        Bench with its a-priori intervals.
    request
        Requested precisions, and the proposed test.

    Returns
    -------
    Assessment
        Assessment of each parameter, entropy of the encoder, and shortest response of the drive.

    Raises
    ------
    NoSolutionError
        If the drive does not overcome the friction, or if nothing limits the speed.
    """
    facts = facts_of(bench, request)
    limits = limits_of(bench)
    bounds = cramer_rao(list(facts.strokes), facts.axis, facts.sensing)
    least = {name: QUANTILE * float(bound) for name, bound in zip(SLIDING, bounds, strict=True)}
    rows = tuple(
        _row(name, facts, request.wanted.get(name, WANTED), least.get(name), bench.axis)
        for name in PARAMETERS
    )
    entropy = (
        sensor_entropy(limits.travel, facts.sensing.step) if math.isfinite(limits.travel) else None
    )
    low, high = bench.actuator.constant.interval
    constant = 0.5 * (high - low) / bench.actuator.constant.value
    travel = bench.mechanics.travel
    whole = None if travel is None else travel.high - travel.low
    length = whole if request.step is None else request.step
    plants = corner_points(bench_intervals(bench))
    drive = None if length is None else shortest_step_times(bench, plants, length)
    return Assessment(bench, facts, rows, entropy, constant, drive)


def _row(
    parameter: str, facts: AssessmentInputs, wanted: float, least: float | None, axis: Axis
) -> ParameterAssessment:
    known = facts.known.get(parameter)
    target = min(wanted, known) if known else wanted
    result = verdict(parameter, facts, target)
    doubled = verdict(parameter, facts.with_step(0.5 * facts.sensing.step), target).precision
    value = facts.value(parameter)
    relative = least / value if least is not None and value > 0.0 else None
    step = facts.sensing.step if result.identifiable else coarsest_step(parameter, facts, target)
    counts = 2.0 * math.pi / step if step is not None and axis == "rotary" else None
    return ParameterAssessment(
        parameter, result, wanted, known, target, relative, doubled, step, counts
    )


def coarsest_step(parameter: str, facts: AssessmentInputs, target: float) -> float | None:
    """Return the largest encoder step that gives the precision `target`, at most the bench's step.

    Return None if even a step of FINEST times the bench's step does not give this precision.
    """

    def fine(step: float) -> bool:
        return verdict(parameter, facts.with_step(step), target).identifiable

    high = math.log(facts.sensing.step)
    low = math.log(FINEST * facts.sensing.step)
    if not fine(math.exp(low)):
        return None
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fine(math.exp(middle)) else (low, middle)
        if high - low < 1e-3:
            break
    return math.exp(low)


def unreachable_parameters(assessment: Assessment, counted: set[str]) -> list[ParameterAssessment]:
    """Return the assessments of the parameters in `counted` that are not identifiable.

    A parameter with the value 0 is left out.
    """
    return [
        row
        for row in assessment.rows
        if row.parameter in counted
        and assessment.facts.value(row.parameter) > 0.0
        and not row.verdict.identifiable
    ]
