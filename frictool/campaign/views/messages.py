"""Numbers and sentences on a campaign, for the text and the page."""

from __future__ import annotations

import math
from typing import Literal

from frictool.campaign.statistics.findings import Findings
from frictool.campaign.statistics.pass_rate import PassRate
from frictool.campaign.trials.worst_case import WorstCase
from frictool.documents.metric_table import requirement_title


def number(value: float | None) -> str:
    """Return the number with four digits; "never" for infinity, a dash for None or NaN."""
    if value is None or math.isnan(value):
        return "–"
    return "never" if math.isinf(value) else f"{value + 0.0:.4g}"


def unit_shown(unit: str) -> str:
    """Return the unit with "²" in place of "^2"; "" for a dimensionless number."""
    return "" if unit == "1" else unit.replace("^2", "²")


def quantity(value: float | None, unit: str) -> str:
    """Return a number with its unit."""
    text, unit = number(value), unit_shown(unit)
    return f"{text} {unit}" if unit and text not in ("–", "never") else text


def percent(share: float, toward: Literal["nearest", "down", "up"] = "nearest") -> str:
    """Return `share` (0 to 1) in % with one decimal.

    Close to 0 or 100 %, more decimals show two significant digits of the distance to 0 or 100 %.

    `toward`: direction of rounding; a lower bound must be rounded down, an upper bound up.
    """
    if share in (0.0, 1.0):
        return f"{100.0 * share:.0f} %"
    digits = min(9, max(1, 1 - math.floor(math.log10(100.000001 * min(share, 1.0 - share)))))
    scaled = share * 100.0 * 10.0**digits
    whole = {
        "down": math.floor(scaled + 1e-6),
        "up": math.ceil(scaled - 1e-6),
        "nearest": round(scaled),
    }[toward]
    return f"{whole / 10.0**digits:.{digits}f} %"


def percent_text(share: float) -> str:
    """Return a share (0 to 1) that the user stated, in % with all its digits."""
    return f"{100.0 * share:.12g} %"


def chance_text(chance: float | None) -> str:
    """Return a text on a p-value, such as "chance 0.02"; "" for None.

    Trials that are not random have no p-value.
    """
    if chance is None:
        return ""
    return "chance below 1e-4" if chance < 1e-4 else f"chance {chance:.1g}"


def headline(findings: Findings) -> str:
    """Return the outcome of a campaign, the numbers of trials and the pass rate as one sentence."""
    rate = findings.rate
    undecided_requirements = [requirement_title(name) for name in findings.undecided_requirements]
    undecided = (
        f"; undecided in every trial: {', '.join(undecided_requirements)}"
        if undecided_requirements
        else ""
    )
    doubted = findings.doubt and findings.outcome == "UNDECIDED"
    doubt = f"; {findings.doubt}" if doubted else ""
    counts = f"{_counted(rate)}{_rated(rate)}{_required_text(findings)}"
    return f"{findings.outcome}: {counts}{undecided}{doubt}"


def _counted(rate: PassRate) -> str:
    all_of = (
        f"all {rate.count}" if rate.passed == rate.count > 1 else f"{rate.passed} of {rate.count}"
    )
    passes = "passes" if rate.count == 1 else "pass"
    parts = [f"{all_of} {rate.noun} {passes}"]
    if rate.failed:
        not_run = f" ({rate.not_run} could not be simulated)" if rate.not_run else ""
        parts.append(f"{rate.failed} {'fails' if rate.count == 1 else 'fail'}{not_run}")
    if rate.undecided:
        parts.append(f"{rate.undecided} undecided")
    return ", ".join(parts)


def _rated(rate: PassRate) -> str:
    if rate.at_least is None or rate.low is None or rate.high is None:
        return ""
    population = "of all vertices " if rate.method == "vertices" else ""
    confidence = percent_text(rate.confidence)
    if rate.passed == rate.count:
        return (
            f"; at most {percent(1.0 - rate.at_least, 'up')} {population}fail ({confidence} "
            "confidence)"
        )
    if rate.failed == rate.count:
        return f"; at most {percent(rate.high, 'up')} {population}pass ({confidence} interval)"
    share = (
        f"{percent(rate.share)} {population}pass"
        if not rate.undecided
        else f"the share {population}that passes"
    )
    between = f"{percent(rate.low, 'down')} to {percent(rate.high, 'up')}"
    return (
        f"; {share} ({confidence} interval {between})"
        if not rate.undecided
        else f"; {share} is {between} ({confidence} interval)"
    )


def _required_text(findings: Findings) -> str:
    rate, required = findings.rate, findings.required
    if required is None:
        return ""
    if rate.at_least is None:
        return f"; {percent(rate.share)} of the vertices pass, required: {percent_text(required)}"
    shown = f"; shown: {percent(rate.at_least, 'down')} pass, required: {percent_text(required)}"
    if required == 1.0:
        return (
            f"{shown}; no number of draws can show this; lower --at-least, or leave it out: then "
            "every draw must pass"
        )
    needed = findings.draws_needed
    return shown if needed is None else f"{shown}; {needed} draws suffice if the same share passes"


def caveat(findings: Findings) -> str:
    """Return a sentence that says to which plants the pass rate refers."""
    rate = findings.rate
    if rate.whole:
        return (
            "Every combination of the ranges' ends was simulated once. The combinations are not "
            "random: they give no pass rate, and say nothing about values between the ends."
        )
    if rate.method == "vertices":
        return (
            "A random part of all combinations of the ranges' ends was simulated; the interval "
            "is for all combinations, not for values between the ends."
        )
    drawn = "independently" if rate.method == "random" else "as a Latin hypercube"
    limited = [one for one in findings.trials.space.factors if one.least is not None]
    over = "its range"
    if any(factor.ratio is None for factor in limited):
        over += " (a breakaway over the part of its range that is not below the Coulomb friction)"
    elif limited:
        over += " (for a breakaway, its ratio to the Coulomb friction was drawn)"
    return (
        f"The factors were drawn {drawn}, each uniformly over {over}. The rate refers "
        "to plants of this distribution; it is a probability in the field only if the product has "
        "this distribution."
    )


def failure_reasons(findings: Findings) -> list[tuple[str, int, int]]:
    """Return (reason, number of trials, first draw) of failed simulations, most frequent first."""
    draws: dict[str, list[int]] = {}
    for draw, reason in findings.trials.failed.items():
        draws.setdefault(reason, []).append(draw)
    counted = [(reason, len(each), each[0]) for reason, each in draws.items()]
    return sorted(counted, key=lambda item: (-item[1], item[2]))


def worst_values(findings: Findings, one: WorstCase) -> str:
    """Return a worst case's factor values as text, such as "Coulomb friction 0.14 N m, ..."."""
    known = {factor.name: factor for factor in findings.trials.space.factors}
    return ", ".join(
        f"{known[name].label} {quantity(value, known[name].unit)}"
        if name in known
        else f"{name} {number(value)}"
        for name, value in one.values.items()
    )
