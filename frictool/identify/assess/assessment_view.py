"""Text view and JSON view of an assessment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from frictool.adapters.shortest_step import ShortestStepTimes
from frictool.documents.quantity import si_unit
from frictool.identify.assess.assessment import Assessment, ParameterAssessment
from frictool.identify.assess.decision_text import scheme
from frictool.identify.assess.identifiability import NO_LOADS


def unreachable(rows: Sequence[ParameterAssessment]) -> str:
    """Return a line that names the precisions that cannot be reached, and the remedies."""
    out = []
    by_encoder = {row.step: row for row in rows if row.step is not None}
    if by_encoder:
        finest = by_encoder[min(by_encoder)]
        encoder = (
            f"a step of {finest.step:.3g} m"
            if finest.counts is None
            else f"{math.ceil(finest.counts)} counts per revolution "
            f"(a step of {finest.step:.3g} rad)"
        )
        coarse = [row for row in rows if row.step is not None]
        loaded = any(NO_LOADS in row.verdict.why for row in coarse)
        reason = f", since {NO_LOADS}; remove the load, or try" if loaded else "; try"
        out.append(f"{_wanted(coarse)} cannot be reached with this encoder{reason} {encoder}")
    longer = {row.parameter: _times_as_long(row) for row in rows if row.step is None}
    by_test = [row for row in rows if math.isfinite(longer.get(row.parameter, math.inf))]
    if by_test:
        factor = max(longer[row.parameter] for row in by_test)
        out.append(
            f"{_wanted(by_test)} cannot be reached with any encoder; try a test that is "
            f"{factor:.3g} times as long, or reduce the noise of the measured drive"
        )
    out += [
        f"{_wanted([row])} cannot be reached: {row.verdict.why}"
        for row in rows
        if row.step is None and row not in by_test
    ]
    return "; ".join(out)


def _wanted(rows: Sequence[ParameterAssessment]) -> str:
    return ", ".join(f"{row.parameter}: {100.0 * row.target:.3g} %" for row in rows)


def _times_as_long(row: ParameterAssessment) -> float:
    """Return the factor by which the test must be longer to reach the precision; inf if unknown."""
    precision = row.verdict.precision
    return math.inf if precision is None else (precision / row.target) ** 2


def json_view(assessment: Assessment) -> dict[str, Any]:
    """Return an assessment as JSON values."""
    facts, entropy = assessment.facts, assessment.entropy
    return {
        "bench": assessment.bench.name,
        "step": facts.sensing.step,
        "period_s": facts.sensing.period,
        "top_speed": facts.speed,
        "effort": facts.effort,
        "effort_noise": facts.sensing.noise,
        "effort_constant_error": assessment.constant,
        "entropy": {
            "counts": entropy.counts,
            "nats": entropy.nats,
            "bits": entropy.bits,
            "gain_of_doubling": entropy.gain,
        }
        if entropy
        else None,
        "time_optimal": None if assessment.drive is None else _drive(assessment.drive),
        "parameters": [_row(row) for row in assessment.rows],
        "scheme": scheme(assessment),
    }


def _drive(bound: ShortestStepTimes) -> dict[str, Any]:
    times = {"best_s": bound.best, "worst_s": bound.worst}
    return {
        "step": bound.length,
        **{name: time if math.isfinite(time) else None for name, time in times.items()},
    }


def _row(row: ParameterAssessment) -> dict[str, Any]:
    verdict = row.verdict
    return {
        "parameter": row.parameter,
        "identifiable": verdict.identifiable,
        "method": verdict.method,
        "test": verdict.test,
        "precision": verdict.precision,
        "bound": verdict.bound,
        "cramer_rao": row.least,
        "wanted": row.wanted,
        "known": row.known,
        "filter_s": verdict.filter,
        "precision_at_half_the_step": row.doubled,
        "step_needed": row.step,
        "counts_needed": row.counts,
        "why": verdict.why,
    }


def lines(assessment: Assessment) -> list[str]:
    """Return an assessment as lines of text."""
    facts, bench = assessment.facts, assessment.bench
    unit, speed, effort = (si_unit(name, bench.axis) for name in ("position", "velocity", "effort"))
    output = [
        f"{bench.name}: step {facts.sensing.step:.4g} {unit}, period "
        f"{facts.sensing.period:g} s, top speed {facts.speed:.4g} {speed}, "
        f"effort {facts.effort:.4g} {effort}",
        *scheme(assessment),
        f"{'parameter':<11}{'method':<15}{'precision':>11}{'half step':>11}"
        f"{'least (CR)':>12}{'worst case':>12}{'known':>9}  test",
    ]
    for row in assessment.rows:
        verdict = row.verdict
        figures = (verdict.precision, row.doubled, row.least, verdict.bound, row.known)
        shown = "".join(
            f"{_percent(figure):>{width}}"
            for figure, width in zip(figures, (11, 11, 12, 12, 9), strict=True)
        )
        output.append(
            f"{row.parameter:<11}{verdict.method or '-':<15}{shown}  {verdict.test or '-'}"
        )
    output += [f"{row.parameter}: {row.verdict.why}" for row in assessment.rows]
    if assessment.entropy is not None:
        output.append(
            f"the sensor gives {assessment.entropy.bits:.3g} bits over the travel (metric "
            f"entropy {assessment.entropy.nats:.3g} nats, "
            f"{assessment.entropy.counts:.0f} counts); twice the resolution adds 1 bit, "
            f"{100.0 * assessment.entropy.gain:.3g} %"
        )
    if assessment.drive is not None:
        output.append(
            f"{assessment.drive.words(bench)}, {1e3 * assessment.drive.best:.4g} ms on the fastest "
            "(time-optimal control, with lag and delay)"
        )
    if assessment.constant > 0.0:
        output.append(
            f"not included: the error of the effort constant, up to "
            f"+-{100.0 * assessment.constant:.3g} %, which scales all parameters by the same factor"
        )
    return output


def _percent(part: float | None) -> str:
    return "-" if part is None or not math.isfinite(part) else f"{100.0 * part:.3g} %"
