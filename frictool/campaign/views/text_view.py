"""Text view of a campaign for the terminal: requirements, sensitivities and worst cases."""

from __future__ import annotations

from collections.abc import Sequence

import click

from frictool.campaign.statistics.distribution import COVERED, Distribution
from frictool.campaign.statistics.findings import Findings
from frictool.campaign.statistics.regional_sensitivity import FailureRegion
from frictool.campaign.statistics.sensitivity import FailureComparison, MetricInfluence
from frictool.campaign.views.messages import (
    caveat,
    chance_text,
    failure_reasons,
    headline,
    number,
    percent_text,
    quantity,
    unit_shown,
    worst_values,
)
from frictool.documents.metric_table import requirement_title
from frictool.presentation.sections import aligned, plain

COLOURS = {"PASS": "green", "FAIL": "red", "UNDECIDED": "yellow", "NOT SHOWN": "yellow"}
REASONS = 5  # largest number of reasons shown
MOST = 8  # largest number of factors shown per comparison


def lines(findings: Findings, colour: bool = False) -> list[str]:
    """Return the text lines of the findings; the outcome is the last line."""
    answer = plain(headline(findings))
    output = [
        *_requirements(findings),
        *_not_simulated(findings),
        *_failures(findings),
        *_influences(findings),
        *_worst(findings),
        "",
        caveat(findings),
        *(f"warning: {remark}" for remark in findings.remarks),
        click.style(answer, fg=COLOURS[findings.outcome], bold=True) if colour else answer,
    ]
    return [output[-1] if line is output[-1] else plain(line) for line in output]


def fails_where(findings: Findings, factor: int, region: FailureRegion) -> str:
    """Return a text on the factor values at which most and fewest trials fail.

    Example: "fails 40 % around 0.14 N m, 0 % around 0.11 N m".
    """
    one = findings.trials.space.factors[factor]
    shares = region.failing
    near = "at" if findings.rate.whole or one.whole else "around"

    def around(k: int) -> str:
        return f"{shares[k]:.0%} {near} {region.centres[k]:.3g} {unit_shown(one.unit)}".replace(
            "%", " %"
        ).rstrip()

    return f"fails {around(int(shares.argmax()))}, {around(int(shares.argmin()))}"


def influence_lines(findings: Findings, influence: MetricInfluence) -> list[str]:
    """Return a line with the significant factors and their variance shares, or why there are none.

    A second line shows the variance shares of the ranks if `influence.by_rank` is True.
    """
    if influence.reason:
        return [influence.reason]
    if not influence.named:
        return ["no factor is distinguishable from chance"]
    values = [(share.share, share.error) for share in influence.shares]
    output = [_shares_text(findings, influence, values, influence.rest)]
    if influence.by_rank:
        ranks = [(share.of_ranks, share.error_of_ranks) for share in influence.shares]
        output.append(
            f"by ranks: {_shares_text(findings, influence, ranks, influence.rest_of_ranks)}"
        )
    return output


def _shares_text(
    findings: Findings,
    influence: MetricInfluence,
    shares: Sequence[tuple[float, float]],
    rest: float | None,
) -> str:
    order = sorted(influence.named, key=lambda i: -shares[i][0])
    factors = findings.trials.space.factors
    alone = [
        f"{factors[i].label} {share_text(*shares[i])} ({influence.shares[i].direction})"
        for i in order
        if shares[i][0] >= 0.005
    ]
    others = [factors[i].label for i in order if shares[i][0] < 0.005]
    left = len(alone) - MOST
    terms = (
        alone[:MOST]
        + ([f"{left} more"] if left > 0 else [])
        + ([f"only with other factors: {', '.join(others[:MOST])}"] if others else [])
    )
    return "; ".join([*terms, f"together or unexplained {_whole(rest or 0.0)}"])


def share_text(share: float, error: float) -> str:
    """Return a share as text, with the standard deviation `error` if it is not 0."""
    digits = 0 if error >= 0.0095 else 1
    return (
        _whole(share)
        if error == 0.0
        else f"{100.0 * share:.{digits}f} ± {100.0 * error:.{digits}f} %"
    )


def _whole(share: float) -> str:
    return f"{share:.0%}".replace("%", " %")


def _requirements(findings: Findings) -> list[str]:
    head = (
        "requirement",
        "met",
        "broken",
        "undecided",
        "median",
        "5 to 95 %",
        f"{percent_text(COVERED)} of plants ({percent_text(findings.rate.confidence)} conf.)",
        "worst",
        "limit",
    )
    return aligned([head, *(_row(one) for one in findings.distributions)], 1)


def _row(one: Distribution) -> tuple[str, ...]:
    unit = unit_shown(one.metric.unit)
    relation = one.metric.relation
    values = {quantile.level: quantile.value for quantile in one.quantiles}
    spread = f"{number(values[0.05])} to {number(values[0.95])}" if values else "–"
    limit = f"{relation} {number(one.metric.limit)} {unit}".rstrip()
    counts = (str(one.met), str(one.broken), str(one.undecided))
    bound = f"{relation} {number(one.bound)}" if one.bound is not None else "–"
    return (
        requirement_title(one.metric.name),
        *counts,
        number(values.get(0.5)),
        spread,
        bound,
        number(one.worst),
        limit,
    )


def _not_simulated(findings: Findings) -> list[str]:
    common = failure_reasons(findings)
    if not common:
        return []
    reasons = [
        f"  {count} x {reason} (first: draw {first})" for reason, count, first in common[:REASONS]
    ]
    left = len(common) - REASONS
    return [
        "",
        f"not simulated, counted as failing: {len(findings.trials.failed)}",
        *reasons,
        *([f"  {left} more reasons"] if left > 0 else []),
    ]


def _failures(findings: Findings) -> list[str]:
    output: list[str] = []
    for question in findings.sensitivity.questions:
        output += [
            "",
            f"{question_text(question)} ({question.failing} trials compared with "
            f"{question.passing})",
            *(f"  {row}" for row in _causes(findings, question)),
        ]
        if question.name == "":
            output += [f"  {sentence}" for sentence in pair_lines(findings)]
    return output


def pair_lines(findings: Findings) -> list[str]:
    """Return a line on a significant interaction of two factors; no line if there is none."""
    pair = findings.sensitivity.pair
    if pair is None or pair.beyond <= max(0.01, 3.0 * pair.error):
        return []
    first, second = (findings.trials.space.factors[i].label for i in (pair.first, pair.second))
    joint, beyond = (f"{100.0 * one:.0f} %" for one in (pair.joint, pair.beyond))
    return [
        f"{first} and {second} explain {joint} of the variance of the outcome; their interaction "
        f"alone explains {beyond}"
    ]


def question_text(question: FailureComparison) -> str:
    """Return the heading of a comparison of failing with passing trials."""
    return {"": "causes of failures", "not simulated": "causes of failed simulations"}.get(
        question.name, f"causes of a broken requirement: {requirement_title(question.name)}"
    )


def _causes(findings: Findings, question: FailureComparison) -> list[str]:
    if not question.named:
        return ["no factor is distinguishable from chance"]
    rows = [_cause(findings, i, question.regions[i]) for i in question.named[:MOST]]
    left = len(question.named) - MOST
    return [*aligned(rows), *([f"{left} more factors are in --json"] if left > 0 else [])]


def _cause(findings: Findings, factor: int, region: FailureRegion) -> tuple[str, ...]:
    return (
        findings.trials.space.factors[factor].label,
        region.direction,
        fails_where(findings, factor, region),
        chance_text(region.chance),
    )


def _influences(findings: Findings) -> list[str]:
    if not findings.trials.space.size:
        return []
    names = [requirement_title(one.metric.name) for one in findings.distributions]
    width = max(map(len, names), default=0)
    output = []
    for name, one in zip(names, findings.sensitivity.influences, strict=True):
        rows = influence_lines(findings, one)
        output += [
            f"  {heading.ljust(width)}  {row}"
            for heading, row in zip([name, *[""] * len(rows)], rows, strict=False)
        ]
    drawn = any(
        share.error > 0.0 for one in findings.sensitivity.influences for share in one.shares
    )
    return (
        [
            "",
            f"where the variance comes from{' (± one standard deviation)' if drawn else ''}",
            *output,
        ]
        if output
        else []
    )


def _worst(findings: Findings) -> list[str]:
    output: list[str] = []
    for one in findings.worst:
        limit = f"{one.relation} {number(one.limit)} {unit_shown(one.unit)}".rstrip()
        output += [
            f"  {requirement_title(one.requirement)} {quantity(one.value, one.unit)} "
            f"where {limit} is required: {worst_values(findings, one)}",
            f"    {one.typed}",
        ]
    return ["", "worst cases of the search", *output] if output else []
