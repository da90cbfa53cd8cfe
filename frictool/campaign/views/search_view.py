"""Views of an automatic design: text, JSON, the reason of a refusal, and its trade as a picture."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from frictool.adapters.drive_bound import drive_bound
from frictool.adapters.model_polytope import polytope
from frictool.campaign.automatic_design import AutomaticDesign
from frictool.campaign.played_design import DesignTest, longest_step_of
from frictool.documents.metric_table import requirement_title
from frictool.synth.search.played_search import Candidate, FamilyOutcome
from frictool.synth.search.played_tests import RESERVE


class ReachedValue(NamedTuple):
    """Best value of a requirement over the played candidates.

    The value of a candidate is the worst of the tests in which it was played; candidates far from
    the limits were played on few plants. `alone`: best value of any candidate. `together`: best
    value of the candidates that meet all other requirements, None if there is none.
    """

    key: str
    title: str
    unit: str
    relation: str
    limit: float
    alone: float
    together: float | None


def design_line(found: AutomaticDesign) -> str:
    """Return the sentence that says how a design was found."""
    last = found.outcomes[-1]
    reserve = f"a reserve of {100.0 * RESERVE:g} %" if last.with_reserve else "less reserve"
    without = "oscillations, drive and rest"
    before = "".join(f"{one.family} failed; " for one in found.outcomes[:-1])
    return (
        f"designed: {before}{last.family}, {_candidates(last)}, meets every requirement, with "
        f"{reserve} ({without} have none)"
    )


def refusal(found: AutomaticDesign, test: DesignTest) -> str:
    """Return why no design was found: the requirement, the best value, and the trade.

    It ends with the shortest response that the drive allows.
    """
    bench = test.model.bench
    overshoot = test.spec.overshoot_percent
    bound = drive_bound(
        bench,
        polytope(test.model).vertices,
        longest_step_of(test.scenario),
        None if overshoot is None else overshoot / 100.0,
    ).words(bench)
    tried = "; ".join(f"{one.family}: {_candidates(one)}" for one in found.outcomes)
    best = _best(found)
    refusals = [reason for one in found.outcomes for reason in one.refusals]
    if best is None:
        reason = "no candidate can be played"
    elif max(best.missing.values()) <= 0.0 and refusals:
        reason = f"the candidates that meet the specification when played are {refusals[-1]}"
    else:
        reason = _missed(found, best)
    return f"no design found ({tried}): {reason}; {bound}"


def search_json(found: AutomaticDesign) -> dict[str, Any]:
    """Return the search as JSON values."""
    return {
        "passed": found.passed,
        "reserve": RESERVE if found.outcomes[-1].with_reserve else 0.0,
        "families": [
            {"family": one.family, "candidates": one.candidates, "passed": one.passed}
            for one in found.outcomes
        ],
        "reached": [
            {
                "key": one.key,
                "unit": one.unit,
                "relation": one.relation,
                "limit": one.limit,
                "best": one.alone,
                "best_with_the_others_met": one.together,
            }
            for one in reached(found)
        ],
        "refusals": [reason for one in found.outcomes for reason in one.refusals],
    }


def reached(found: AutomaticDesign) -> tuple[ReachedValue, ...]:
    """Return the best value of each requirement over all candidates."""
    played = [one for outcome in found.outcomes for one in outcome.trade]
    if not played:
        return ()
    metrics = max((one.metrics for one in played), key=len)
    return tuple(_reached(metric, played) for metric in metrics)


def _reached(metric: Any, played: list[Candidate]) -> ReachedValue:
    values = [(one, one.worst(metric)) for one in played]
    known = [(one, value) for one, value in values if not math.isnan(value)]
    alone = [value for _, value in known]
    together = [
        value
        for one, value in known
        if all(short <= 0.0 for key, short in one.missing.items() if key != metric.key)
    ]
    best = min if metric.relation == "<=" else max
    return ReachedValue(
        metric.key,
        requirement_title(metric.name),
        metric.unit,
        metric.relation,
        metric.limit,
        best(alone, default=math.nan),
        best(together) if together else None,
    )


def _missed(found: AutomaticDesign, best: Candidate) -> str:
    """Return the requirement that the best candidate misses, and what the others allow."""
    key = max(best.missing, key=best.missing.__getitem__)
    first = next(one for one in best.metrics if one.key == key)
    reason = (
        f"{requirement_title(first.name)} is {_number(best.worst(first), first.unit)} for the best "
        f"candidate, specified {first.relation} {_number(first.limit, first.unit)}"
    )
    values = [
        f"{row.title} {_number(row.together, row.unit)}"
        for row in reached(found)
        if row.together is not None and row.key in TRADED
    ]
    if not values:
        return reason
    return (
        f"{reason}; best values of candidates that meet all other requirements, on the plants on "
        f"which each was played: {', '.join(values)}"
    )


TRADED = ("response_time_95_s", "rise_time_s", "overshoot_percent", "modulus_margin", "drive_peak")


def _best(found: AutomaticDesign) -> Candidate | None:
    candidates = [one.best for one in found.outcomes if one.best is not None]
    return min(candidates, key=lambda one: max(one.missing.values()), default=None)


def _candidates(one: FamilyOutcome) -> str:
    return f"{one.candidates} candidate{'s' if one.candidates != 1 else ''}"


def _number(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".rstrip() if math.isfinite(value) else "none"
