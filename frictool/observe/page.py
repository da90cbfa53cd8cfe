"""HTML page with picture, verdict and figures of one log or of a fleet.

The template escapes every text that comes from a file.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.observe.fleet_table import FleetRow, headline, table_texts
from frictool.observe.observation_outcome import ObservationOutcome, facts, heading
from frictool.presentation.page import render_page

TONES = {True: "broken", False: "met", None: "open"}


def page_of_log(
    outcome: ObservationOutcome, model: Model, picture: str, provenance: Provenance
) -> str:
    """Return the HTML text for one log; the same inputs give the same bytes.

    picture: the `<svg>` element of the log.
    """
    verdict = outcome.verdict
    return _page(
        title=heading(outcome),
        banner="" if verdict is None else f"wear limit {verdict.limit:g}: {verdict.reason}",
        tone=TONES[None if verdict is None else verdict.exceeded],
        picture=picture,
        caption="Each with its interval; wear changes when a move has ended, "
        "from what was known then. The limit is dashed.",
        facts=facts(outcome, model),
        rows=[],
        headings=[],
        remarks=outcome.warnings,
        provenance=provenance,
    )


def page_of_fleet(
    table: Sequence[FleetRow], limit: float | None, picture: str, provenance: Provenance
) -> str:
    """Return the HTML text for a fleet; picture: the `<svg>` element of the trend."""
    headings, rows = table_texts(table)
    alarm = any(row.alarm for row in table)
    return _page(
        title="Wear of a fleet",
        banner=headline(table, limit),
        tone="broken"
        if alarm
        else "open"
        if limit is None or any(row.alarm is None for row in table)
        else "met",
        picture=picture,
        caption="Each log with its interval. The limit is dashed.",
        facts=[],
        rows=rows,
        headings=headings,
        remarks=[],
        provenance=provenance,
    )


def _page(picture: str, provenance: Provenance, **texts: Any) -> str:
    return render_page(Path(__file__).parent, provenance, picture=Markup(picture), **texts)
