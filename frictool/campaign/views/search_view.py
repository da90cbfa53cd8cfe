"""Views of an automatic design: text, JSON, and the reason if there is no design."""

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
    """Best value of a requirement that the candidates of a search reached.

    The value of a candidate is the worst value in its tests. A candidate far from the limits was
    tested with few plants.

    `alone`: best value of all candidates.
    `together`: best value of the candidates that meet all other requirements, or None.
    """

    key: str
    title: str
    unit: str
    relation: str
    limit: float
    alone: float
    together: float | None


def design_line(found: AutomaticDesign) -> str:
    """Return a sentence on the search that led to the design."""
    last = found.outcomes[-1]
    reserve = f"a reserve of {100.0 * RESERVE:g} %" if last.with_reserve else "less reserve"
    without = "oscillations, drive and rest"
    before = "".join(f"{one.family} failed; " for one in found.outcomes[:-1])
    return (
        f"designed: {before}{last.family}, {_candidates(last)}, meets every requirement, with "
        f"{reserve} (none for {without})"
    )


def refusal(found: AutomaticDesign) -> str:
    """Return why no design was found: the requirement that the best candidate violates."""
    best = _best(found)
    refusals = [reason for one in found.outcomes for reason in one.refusals]
    if best is None:
        reason = "no candidate can be simulated"
    elif max(best.missing.values()) <= 0.0 and refusals:
        reason = f"the candidates that meet the specification in simulation are {refusals[-1]}"
    else:
        reason = _missed(best)
    return f"no design found: {reason}"


def refusal_lines(found: AutomaticDesign, test: DesignTest) -> list[str]:
    """Return lines with the details if no design was found.

    The lines state the number of candidates and the fastest response that the drive allows. They
    also list the violated requirements, at least one of which must be relaxed. For each, they state
    the best value of the candidates that meet all other requirements.
    """
    bench = test.model.bench
    overshoot = test.spec.overshoot_percent
    bound = drive_bound(
        bench,
        polytope(test.model).vertices,
        longest_step_of(test.scenario),
        None if overshoot is None else overshoot / 100.0,
    )
    lines = [f"searched: {one.family}, {_candidates(one)}" for one in found.outcomes]
    lines.append(f"bound: {bound.words(bench)}")
    rows = [row for row in reached(found) if row.together is not None and row.key in TRADED]
    broken = [row for row in rows if not _meets(row)]
    if broken:
        lines.append("relax one requirement, to the best value of candidates that meet all others:")
        lines += [f"  {row.key}: {_number(row.together, row.unit)}" for row in broken]
        lines.append("  (with the plants for which each candidate was simulated)")
    return lines


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
    """Return the best value of each requirement that the candidates reached."""
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


def _missed(best: Candidate) -> str:
    key = max(best.missing, key=best.missing.__getitem__)
    first = next(one for one in best.metrics if one.key == key)
    reached, limit = _told_apart(best.worst(first), first.limit, first.unit)
    return (
        f"{requirement_title(first.name)} is {reached} for the best candidate, specified "
        f"{first.relation} {limit}"
    )


def _told_apart(value: float, limit: float, unit: str) -> tuple[str, str]:
    for digits in range(4, 17):
        texts = _number(value, unit, digits), _number(limit, unit, digits)
        if texts[0] != texts[1]:
            break
    return texts


def _meets(row: ReachedValue) -> bool:
    assert row.together is not None
    return row.together <= row.limit if row.relation == "<=" else row.together >= row.limit


TRADED = ("response_time_95_s", "rise_time_s", "overshoot_percent", "modulus_margin", "drive_peak")


def _best(found: AutomaticDesign) -> Candidate | None:
    candidates = [one.best for one in found.outcomes if one.best is not None]
    return min(candidates, key=lambda one: max(one.missing.values()), default=None)


def _candidates(one: FamilyOutcome) -> str:
    return f"{one.candidates} candidate{'s' if one.candidates != 1 else ''}"


def _number(value: float | None, unit: str, digits: int = 4) -> str:
    known = value is not None and math.isfinite(value)
    return f"{value:.{digits}g} {unit}".rstrip() if known else "none"
