"""Views of an automatic design: text, JSON, and the reason if there is no design."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from frictool.adapters.model_polytope import polytope
from frictool.adapters.shortest_step import shortest_step_times
from frictool.campaign.automatic_design import AutomaticDesign
from frictool.campaign.design_trial import DesignTest, longest_step_of
from frictool.campaign.narrower_range import widest_ranges
from frictool.campaign.search_findings import SearchFindings, others_missed
from frictool.documents.metric_table import requirement_title
from frictool.documents.model import Model
from frictool.synth.search.nearest_text import distinguished, number_words, value_words
from frictool.synth.search.played_search import Candidate, FamilyOutcome, PlayedExtent
from frictool.synth.search.played_tests import RESERVE

MOST_RANGES = 3  # largest number of ranges that a refusal lists


class ReachedValue(NamedTuple):
    """Best value of one requirement among the candidates of a search.

    The value of a candidate is the worst value in its tests. A candidate with a large violation was
    tested with few plants only.

    `alone`: best value of all candidates.
    `together`: best value of the candidates that meet all other requirements on all plants of the
    shortened test, or None.
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
    elif best.largest_missing <= 0.0 and refusals:
        reason = f"the candidates that meet the specification in simulation are {refusals[-1]}"
    else:
        reason = _missed(best, {} if found.findings is None else found.findings.places)
    return f"no design found: {reason}"


def refusal_lines(found: AutomaticDesign, test: DesignTest) -> list[str]:
    """Return lines with the details if no design was found.

    The lines state the number of candidates, the fastest response that the drive allows, and the
    values of the best candidate. They also list relaxed limits and a narrower parameter range; each
    of these alone would let a candidate pass every test.
    """
    bench = test.model.bench
    overshoot = test.spec.overshoot_percent
    bound = shortest_step_times(
        bench,
        polytope(test.model).vertices,
        longest_step_of(test.scenario),
        None if overshoot is None else overshoot / 100.0,
    )
    findings = found.findings or SearchFindings()
    relaxed = relaxation_lines(findings)
    narrower = narrower_words(found)
    ranges = [
        "narrow the range of a parameter; with this range, a candidate passes every test:",
        f"  {narrower}",
    ]
    return [
        *(f"searched: {one.family}, {_candidates(one)}" for one in found.outcomes),
        f"bound: {bound.words(bench)}",
        *best_lines(found, test),
        *(relaxed or ([] if narrower else _several_lines(findings, test.model))),
        *(ranges if narrower else []),
    ]


def _several_lines(findings: SearchFindings, model: Model) -> list[str]:
    """Return lines with remedies if no single relaxed limit or narrower range allows a design."""
    wide = widest_ranges(model) if findings.nominal else []
    if not wide:
        return ["no candidate passes every test if only one limit is relaxed: relax several limits"]
    offset = model.parameters.offset.interval
    ranges = []
    for name, one in wide[:MOST_RANGES]:
        factor = f" (factor {one.high / one.low:.3g})" if one.low > 0.0 else ""
        ends = f"{one.low:.4g} to {one.high:.4g} {one.unit}{factor}"
        remedy = f"test: `frictool excite --for {name}=10%`"
        if name == "breakaway" and max(offset[0], -offset[1]) > one.high:
            remedy = (
                "the offset is above this range, so that ramps cannot show the breakaway; state it "
                "in bench.yaml"
            )
        ranges.append(f"  {name}: {ends}; {remedy}")
    return [
        "a candidate passes with the nominal plant, but no candidate passes with all plants, even "
        "if one limit is relaxed: narrow the widest ranges",
        *ranges,
    ]


def relaxation_lines(findings: SearchFindings) -> list[str]:
    """Return a heading and one line for each relaxed limit; [] without relaxed limits.

    Each of these limits alone lets a candidate pass. A smaller change may suffice.
    """
    relaxed = [
        f"  {one.metric.key}: {number_words(one.limit, one.metric.unit)}"
        for one in findings.relaxations
    ]
    head = "relax one limit; each of these values suffices, and a smaller change may also suffice:"
    return [head, *relaxed] if relaxed else []


def narrower_words(found: AutomaticDesign) -> str:
    """Return a text on the range with which a candidate passes every test; "" without a range."""
    one = None if found.findings is None else found.findings.narrower
    if one is None:
        return ""
    low, high = one.whole
    return (
        f"{one.parameter}: {one.low:.4g} to {one.high:.4g} {one.unit} "
        f"(range: {low:.4g} to {high:.4g} {one.unit})"
    )


def interruption_lines(found: AutomaticDesign, test: DesignTest) -> list[str]:
    """Return lines on an interrupted search: number of candidates, values of the best candidate."""
    searched = [f"searched: {one.family}, {_candidates(one)}" for one in found.outcomes]
    return [*searched, *best_lines(found, test)]


def best_lines(found: AutomaticDesign, test: DesignTest) -> list[str]:
    """Return lines with the best candidate's value of each requirement, below a heading."""
    best = _best(found)
    if best is None:
        return []
    places = {} if found.findings is None else found.findings.places
    lines = []
    for metric in best.metrics:
        value = value_words(metric, best.worst(metric))
        broken = best.missing[metric.key] > 0.0
        words = f"missed: {places[metric.key]}" if metric.key in places else "missed"
        lines.append(f"  {requirement_title(metric.name)} {value}{f', {words}' if broken else ''}")
    return [f"best candidate, on {best.plants} of {len(test.plants)} plants:", *lines]


def search_json(found: AutomaticDesign) -> dict[str, Any]:
    """Return the search as JSON values."""
    findings = found.findings or SearchFindings()
    narrower = findings.narrower
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
        "narrower_range": None
        if narrower is None
        else {
            "parameter": narrower.parameter,
            "unit": narrower.unit,
            "low": narrower.low,
            "high": narrower.high,
            "range": list(narrower.whole),
        },
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
        if one.extent == PlayedExtent.ALL and not others_missed(one.missing, metric.key)
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


def _missed(best: Candidate, places: Mapping[str, str]) -> str:
    worst = best.worst_requirement
    reached, limit = distinguished(best.worst(worst), worst.limit, worst.unit)
    place = f" ({places[worst.key]})" if worst.key in places else ""
    return (
        f"{requirement_title(worst.name)} is {reached} for the best candidate, specified "
        f"{worst.relation} {limit}{place}"
    )


def _best(found: AutomaticDesign) -> Candidate | None:
    if found.findings is not None and found.findings.best is not None:
        return found.findings.best
    candidates = [one.best for one in found.outcomes if one.best is not None]
    return min(candidates, key=lambda one: one.distance, default=None)


def _candidates(one: FamilyOutcome) -> str:
    return f"{one.candidates} candidate{'s' if one.candidates != 1 else ''}"
