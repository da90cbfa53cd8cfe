"""Decision scheme (thesis, figure 4.4) as text, with the answers and numbers of a bench."""

from __future__ import annotations

import math

from frictool.identify.assess.assessment import Assessment, ParameterAssessment
from frictool.identify.assess.assessment_inputs import KNOWN_DYNAMICS
from frictool.identify.assess.identifiability import (
    DIFFERENTIATION,
    NO_LOADS,
    STROKE_MEANS,
    WEAK_FORM,
    Identifiability,
    percent,
    raw_bound,
    time_constants_text,
    up_to,
)
from frictool.identify.assess.noise_filter import noise_ratio

ENDS = {  # last line of the scheme of a sliding parameter, by the proposed method
    DIFFERENTIATION: "least squares weighted by the speed, conditioned",
    WEAK_FORM: "weak form (integrals over parts of a stroke)",
    STROKE_MEANS: "sines in position control",
    None: "keep the a-priori value",
}


def scheme(assessment: Assessment) -> list[str]:
    """Return the decision scheme as lines of text: questions, answers and resulting methods."""
    rows = {row.parameter: row for row in assessment.rows}
    inertia, viscous = rows["inertia"], rows["viscous"]
    lines = [
        *_differentiated(assessment, inertia, "inertia"),
        *_weak(inertia),
        f"   inertia: {ENDS[inertia.verdict.method]}{_reached(inertia.verdict)}",
        *_differentiated(assessment, viscous, "velocity"),
    ]
    lines += [
        f"   {name}: {ENDS[rows[name].verdict.method]}{_reached(rows[name].verdict)}"
        for name in ("viscous", "coulomb")
    ]
    ramps, presliding = rows["breakaway"].verdict, rows["presliding"].verdict
    lines += [
        _question(
            "onset of motion under a ramp, worst case",
            up_to(ramps.bound or 0.0) + " late, corrected",
            rows["breakaway"].target,
            ramps.identifiable,
        ),
        "   breakaway: "
        f"{'ramps in both directions over the travel' if ramps.identifiable else ENDS[None]}"
        f"{_reached(ramps)}",
        _question(
            "one count relative to the presliding distance",
            up_to(presliding.bound or 0.0),
            rows["presliding"].target,
            presliding.identifiable,
        ),
        "   presliding: "
        f"""{
            "closed loops below the breakaway"
            if presliding.identifiable
            else "not visible with this encoder"
        }""",
    ]
    return lines


def _differentiated(assessment: Assessment, row: ParameterAssessment, what: str) -> list[str]:
    facts = assessment.facts
    raw = raw_bound(row.parameter, assessment.facts)
    lines = [
        _question(
            f"{what} from differences of samples, worst case",
            up_to(raw),
            row.target,
            raw <= row.target,
        )
    ]
    if raw <= row.target:
        return lines
    if not facts.dynamics_known:
        known = f"inertia/viscous is {time_constants_text(facts)}"
        factor = f"known within a factor of {KNOWN_DYNAMICS:g}, to choose a low-pass filter"
        return [*lines, f" > {known}; {factor}?  no"]
    best = raw * math.sqrt(noise_ratio(facts.fastest, facts.sensing.period))
    return [
        *lines,
        _question(
            f"after a low-pass filter with time constant {facts.fastest:.3g} s, worst case",
            up_to(best),
            row.target,
            best <= row.target,
        ),
    ]


def _weak(row: ParameterAssessment) -> list[str]:
    verdict = row.verdict
    if (
        verdict.method == DIFFERENTIATION
        or verdict.precision is None
        or not math.isfinite(verdict.precision)
    ):
        return []
    precise = verdict.precision <= row.target
    line = _question(
        "from the weak form, expected", percent(verdict.precision), row.target, precise
    )
    return [line if precise == verdict.identifiable else f"{line}, but {NO_LOADS}"]


def _question(what: str, value: str, target: float, yes: bool) -> str:
    return f" > {what}: {value}; within {percent(target)}?  {'yes' if yes else 'no'}"


def _reached(verdict: Identifiability) -> str:
    if not verdict.identifiable or verdict.precision is None:
        return ""
    behind = f", filter of {verdict.filter:.3g} s" if verdict.filter else ""
    return f"{behind}, to {percent(verdict.precision)}"
