"""JSON view of a campaign for `frictool campaign --json`.

A value that is absent or infinite is null.
"""

from __future__ import annotations

import math
from typing import Any

from frictool.campaign.statistics.distribution import COVERED, Distribution
from frictool.campaign.statistics.findings import Findings, Outcome
from frictool.campaign.statistics.regional_sensitivity import FailureRegion
from frictool.campaign.statistics.sensitivity import FailureComparison, MetricInfluence
from frictool.campaign.trials.trials import Trials
from frictool.campaign.trials.worst_case import WorstCase
from frictool.campaign.views.messages import caveat, headline

FORMAT = "campaign/2"  # since version 2 the verdict has three states
VERDICTS: dict[Outcome, str] = {
    "PASS": "pass",
    "FAIL": "fail",
    "UNDECIDED": "undecided",
    "NOT SHOWN": "fail",
}


def as_json(findings: Findings) -> dict[str, Any]:
    """Return counts, pass rate, metrics and sensitivities as JSON values.

    `verdict` is `pass`, `fail` or `undecided`. If the trials do not show the required rate,
    `verdict` is `fail` and `outcome` is NOT SHOWN.
    """
    rate = findings.rate
    pair = findings.sensitivity.pair
    factors = findings.trials.space.factors
    return {
        "format": FORMAT,
        "verdict": VERDICTS[findings.outcome],
        "outcome": findings.outcome,
        "summary": headline(findings),
        "method": rate.method,
        "trials": rate.count,
        "passed": rate.passed,
        "failed": rate.failed,
        "undecided": rate.undecided,
        "undecided_requirements": list(findings.undecided_requirements),
        "warnings": [*findings.remarks, *filter(None, (findings.doubt,))],
        "not_simulated": [
            {"draw": draw, "reason": reason} for draw, reason in findings.trials.failed.items()
        ],
        "pass_rate": {
            "share": rate.share,
            "low": rate.low,
            "high": rate.high,
            "at_least": rate.at_least,
            "confidence": rate.confidence,
            "asked": findings.required,
            "draws_needed": findings.draws_needed,
            "of": caveat(findings),
        },
        "factors": [
            {
                "name": f.name,
                "label": f.label,
                "kind": f.kind,
                "unit": f.unit,
                "low": f.low,
                "high": f.high,
                "nominal": f.nominal,
            }
            for f in factors
        ],
        "metrics": [
            _metric(findings.trials, one, rate.confidence) for one in findings.distributions
        ],
        "failures": [
            _question(findings.trials, question) for question in findings.sensitivity.questions
        ],
        "influences": [
            _influence(findings.trials, one.metric.name, influence)
            for one, influence in zip(
                findings.distributions, findings.sensitivity.influences, strict=True
            )
        ],
        "pair": None
        if pair is None
        else {
            "factors": [factors[pair.first].name, factors[pair.second].name],
            "joint": pair.joint,
            "only_together": pair.beyond,
            "error": pair.error,
        },
        "worst": [_worst(one) for one in findings.worst],
    }


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _draw(trials: Trials, draw: int | None) -> dict[str, float] | None:
    return (
        None
        if draw is None
        else {
            name: float(value)
            for name, value in zip(trials.space.names, trials.values[draw], strict=True)
        }
    )


def _metric(trials: Trials, one: Distribution, confidence: float) -> dict[str, Any]:
    metric, histogram = one.metric, one.histogram
    return {
        "name": metric.name,
        "key": metric.key,
        "unit": metric.unit,
        "relation": metric.relation,
        "limit": metric.limit,
        "met": one.met,
        "broken": one.broken,
        "undecided": one.undecided,
        "beyond_any_value": one.beyond,
        "without_value": one.missing,
        "quantiles": [
            {
                "level": q.level,
                "value": _finite(q.value),
                "low": _finite(q.low),
                "high": _finite(q.high),
            }
            for q in one.quantiles
        ],
        "tolerance": {
            "share": COVERED,
            "confidence": confidence,
            "bound": one.bound,
            "draws_needed": one.trials_for_bound,
        },
        "worst": {
            "value": _finite(one.worst),
            "draw": one.worst_trial,
            "values": _draw(trials, one.worst_trial),
        },
        "histogram": {
            "edges": histogram.edges.tolist(),
            "counts": histogram.counts.tolist(),
            "outside": histogram.outside,
        },
    }


def _question(trials: Trials, question: FailureComparison) -> dict[str, Any]:
    return {
        "question": question.name or "any",
        "failing": question.failing,
        "passing": question.passing,
        "named": [trials.space.names[i] for i in question.named],
        "factors": [_region(trials, i, question.regions[i]) for i in question.order],
    }


def _region(trials: Trials, factor: int, region: FailureRegion) -> dict[str, Any]:
    one = trials.space.factors[factor]
    slices = zip(
        region.centres.tolist(), region.failing.tolist(), region.sizes.tolist(), strict=True
    )
    return {
        "factor": one.name,
        "distance": region.distance,
        "chance": region.chance,
        "direction": region.direction,
        "leans": region.leans,
        "spread": region.spread,
        "slices": [
            {"value": value, "failing": failing, "trials": size} for value, failing, size in slices
        ],
    }


def _influence(trials: Trials, metric: str, influence: MetricInfluence) -> dict[str, Any]:
    shares = ((trials.space.names[i], influence.shares[i]) for i in influence.order)
    return {
        "metric": metric,
        "trials": influence.used,
        "missing": influence.reason or None,
        "named": [trials.space.names[i] for i in influence.named],
        "rest": influence.rest,
        "rest_of_ranks": influence.rest_of_ranks,
        "factors": [
            {
                "factor": name,
                "share": s.share,
                "error": s.error,
                "share_of_ranks": s.of_ranks,
                "error_of_ranks": s.error_of_ranks,
                "chance": s.chance,
                "direction": s.direction,
                "rank_correlation": s.rises,
            }
            for name, s in shares
        ],
    }


def _worst(one: WorstCase) -> dict[str, Any]:
    return {
        "requirement": one.requirement,
        "value": _finite(one.value),
        "limit": one.limit,
        "unit": one.unit,
        "relation": one.relation,
        "met": one.met,
        "values": dict(one.values),
        "scenario": one.scenario,
        "command": one.command,
    }
