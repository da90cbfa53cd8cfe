"""Campaign report as one HTML file that works without other files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from frictool.campaign.statistics.distribution import COVERED
from frictool.campaign.statistics.findings import Findings
from frictool.campaign.statistics.sensitivity import FailureComparison, MetricInfluence
from frictool.campaign.views.campaign_figures import causes, failing_plane, metric, rates
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
from frictool.campaign.views.text_view import fails_where, question_text, share_text
from frictool.documents.metric_table import requirement_title
from frictool.documents.provenance import Provenance
from frictool.presentation.page import render_page

TONES = {"PASS": "met", "FAIL": "broken", "UNDECIDED": "open", "NOT SHOWN": "open"}
# largest number of columns of the table of shares; largest number of rows of the other tables
FACTORS, MORE = 12, 40


@dataclass(frozen=True)
class ShareCell:
    """Cell of the table of variance shares.

    `weight`: shading, 0 to 1.
    `title`: tooltip.
    """

    text: str
    weight: float
    title: str


def page(findings: Findings, provenance: Provenance) -> str:
    """Return the campaign report as HTML text; the same inputs give the same bytes."""
    metrics = [
        picture for one in findings.distributions if (picture := metric(findings, one)) is not None
    ]
    plane = failing_plane(findings)
    return render_page(
        Path(__file__).parent,
        provenance,
        headline=headline(findings),
        tone=TONES[findings.outcome],
        caveat=caveat(findings),
        remarks=findings.remarks,
        noun=findings.rate.noun,
        rates=rates(findings),
        distributions=findings.distributions,
        covered=percent_text(COVERED),
        sure=percent_text(findings.rate.confidence),
        drawn=not findings.rate.whole,
        reasons=failure_reasons(findings)[:MORE],
        questions=[
            (question_text(one), one, _rows(findings, one))
            for one in findings.sensitivity.questions
        ],
        causes=([plane] if plane else []) + causes(findings),
        metrics=metrics,
        constant=[one for one in findings.distributions if one.has_values and not one.varies],
        columns=_columns(findings),
        silent=[
            factor.label
            for i, factor in enumerate(findings.trials.space.factors)
            if i not in _columns(findings)
        ],
        table=_table(findings),
        worst=[(one, worst_values(findings, one)) for one in findings.worst],
        factors=findings.trials.space.factors,
        number=number,
        quantity=quantity,
        unit_shown=unit_shown,
        requirement_title=requirement_title,
    )


def _rows(findings: Findings, question: FailureComparison) -> list[tuple[str, str, str, str]]:
    factors = findings.trials.space.factors
    return [
        (
            factors[i].label,
            region.direction,
            fails_where(findings, i, region),
            chance_text(region.chance).removeprefix("chance "),
        )
        for i in question.named[:MORE]
        for region in (question.regions[i],)
    ]


def _columns(findings: Findings) -> list[int]:
    influences = findings.sensitivity.influences
    named = {i for one in influences for i in one.named}
    largest = {
        i: max(max(one.shares[i].share, one.shares[i].of_ranks) for one in influences if one.shares)
        for i in named
    }
    return sorted(sorted(named, key=lambda i: (-largest[i], i))[:FACTORS])


def _table(findings: Findings) -> list[tuple[str, str, list[ShareCell], float | None]]:
    rows = []
    for one, influence in zip(findings.distributions, findings.sensitivity.influences, strict=True):
        name = requirement_title(one.metric.name)
        rows.append(
            (name, influence.reason, _cells(findings, influence, ranks=False), influence.rest)
        )
        if influence.by_rank:
            rows.append(
                (
                    f"{name}, by ranks",
                    "",
                    _cells(findings, influence, ranks=True),
                    influence.rest_of_ranks,
                )
            )
    return rows


def _cells(findings: Findings, influence: MetricInfluence, ranks: bool) -> list[ShareCell]:
    cells = []
    for i in _columns(findings) if influence.shares else []:
        one = influence.shares[i]
        named = i in influence.named
        share, error = (one.of_ranks, one.error_of_ranks) if ranks else (one.share, one.error)
        share = max(0.0, share)
        arrow = {"rises": " ↗", "falls": " ↘"}.get(one.direction, "") if named else ""
        text = share_text(share, error) if named else "·"
        title = f"{one.of_ranks if ranks else one.share:.3f} ± {error:.3f}; " if error > 0.0 else ""
        title += one.direction + (f"; {chance_text(one.chance)}" if one.chance is not None else "")
        cells.append(ShareCell(text + arrow, min(1.0, share) if named else 0.0, title))
    return cells
