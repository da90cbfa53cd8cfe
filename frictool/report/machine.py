"""The verdict as one JSON object."""

from __future__ import annotations

from typing import Any

from frictool.report.evidence import Evidence
from frictool.report.measure import Measured
from frictool.report.requirement import Verdict


def as_json(verdict: Verdict) -> dict[str, Any]:
    """`verdict` is `pass` where no requirement is broken and one is met at least; what the logs cannot tell is under `undecided`."""
    return {
        "verdict": "pass" if verdict.passed else "fail",
        "name": verdict.name,
        "summary": verdict.headline,
        "plants": len(verdict.plants),
        "undecided": list(verdict.undecided),
        "requirements": [requirement.as_json() for requirement in verdict.requirements],
        "streams": [_stream(evidence, holds) for evidence, holds in verdict.evidence],
    }


def _stream(evidence: Evidence, holds: tuple[Measured, ...]) -> dict[str, Any]:
    time = evidence.stream.time
    return {
        "log": evidence.source,
        "stream": evidence.stream.topic,
        "samples": int(time.size),
        "duration_s": float(time[-1] - time[0]),
        "encoder_step": evidence.resolution or None,
        "gaps": evidence.gaps,
        "holds": [_hold(measured) for measured in holds],
    }


def _hold(measured: Measured) -> dict[str, Any]:
    hold = measured.hold
    place = {"number": measured.number, "start_s": measured.start_s, "from": hold.origin, "to": hold.target}
    return {**place, **measured.values, "missing": measured.missing}
