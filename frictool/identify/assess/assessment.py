"""The verdict on each parameter, what another encoder would make of it, and what the sensor tells
at all."""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictool.documents.bench import Bench
from frictool.errors import EXIT_NO, FrictoolError
from frictool.identify.assess.assessment_inputs import AssessmentInputs, facts_of
from frictool.identify.assess.entropy import SensorEntropy, sensor_entropy
from frictool.identify.assess.identifiability import PARAMETERS, QUANTILE, Identifiability, verdict
from frictool.identify.excite.bench_limits import limits_of
from frictool.identify.excite.cramer_rao import SLIDING, cramer_rao

WANTED = 0.05  # relative half width, where nobody says
FINEST = 1e-6  # of the step: no finer encoder is looked for
BISECTIONS = 40


class NotIdentifiable(FrictoolError):
    """A wanted precision cannot be reached; the message names the parameters and the encoder that
    would do."""

    exit_code = EXIT_NO


@dataclass(frozen=True)
class ParameterAssessment:
    """One parameter. target: what had to be reached, of `wanted` and `known` (a priori, None where
    no interval is known) the smaller.

    least: Cramér-Rao bound of the proposed test as a relative half width, None for what is no
    parameter of sliding. doubled: the precision with half the step. step: the coarsest encoder step
    [rad | m] with which it is identifiable, None where none within FINEST is.
    """

    parameter: str
    verdict: Identifiability
    wanted: float
    known: float | None
    target: float
    least: float | None
    doubled: float | None
    step: float | None


@dataclass(frozen=True)
class Assessment:
    """rows: of all parameters. entropy: None where the travel has no end. constant: relative half
    width of the effort constant."""

    facts: AssessmentInputs
    rows: tuple[ParameterAssessment, ...]
    entropy: SensorEntropy | None
    constant: float


def assess(
    bench: Bench,
    wanted: dict[str, float],
    duration: float,
    noise: float | None = None,
    effort: float | None = None,
    presliding: float | None = None,
) -> Assessment:
    """wanted: parameter -> relative half width, WANTED where it has none; the rest as in
    `facts_of`. Raises NoSolutionError as it does."""
    facts, limits = facts_of(bench, duration, noise, effort, presliding), limits_of(bench)
    bounds = cramer_rao(list(facts.strokes), facts.axis, facts.sensing)
    least = {name: QUANTILE * float(bound) for name, bound in zip(SLIDING, bounds, strict=True)}
    rows = tuple(
        _row(name, facts, wanted.get(name, WANTED), least.get(name)) for name in PARAMETERS
    )
    entropy = (
        sensor_entropy(limits.travel, facts.sensing.step) if math.isfinite(limits.travel) else None
    )
    low, high = bench.actuator.constant.interval
    return Assessment(facts, rows, entropy, 0.5 * (high - low) / bench.actuator.constant.value)


def _row(
    parameter: str, facts: AssessmentInputs, wanted: float, least: float | None
) -> ParameterAssessment:
    known = facts.known.get(parameter)
    target = min(wanted, known) if known else wanted
    found = verdict(parameter, facts, target)
    doubled = verdict(parameter, facts.with_step(0.5 * facts.sensing.step), target).precision
    value = facts.value(parameter)
    relative = least / value if least is not None and value > 0.0 else None
    step = facts.sensing.step if found.identifiable else coarsest_step(parameter, facts, target)
    return ParameterAssessment(parameter, found, wanted, known, target, relative, doubled, step)


def coarsest_step(parameter: str, facts: AssessmentInputs, target: float) -> float | None:
    """The coarsest encoder step below the bench's with which the parameter is identifiable, by
    bisection of its logarithm."""

    def fine(step: float) -> bool:
        return verdict(parameter, facts.with_step(step), target).identifiable

    high, low = math.log(facts.sensing.step), math.log(FINEST * facts.sensing.step)
    if not fine(math.exp(low)):
        return None
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fine(math.exp(middle)) else (low, middle)
        if high - low < 1e-3:
            break
    return math.exp(low)


def unreachable_parameters(found: Assessment, counted: set[str]) -> list[ParameterAssessment]:
    """The rows of `counted` parameters that cannot be had; what is 0 for certain is not looked
    for."""
    return [
        row
        for row in found.rows
        if row.parameter in counted
        and found.facts.value(row.parameter) > 0.0
        and not row.verdict.identifiable
    ]
