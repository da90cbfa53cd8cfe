"""HTML page with plot, verdict and results of one log or of a fleet."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.observe.fleet_table import FleetRow, headline, text_table
from frictool.observe.observation_outcome import ObservationOutcome, facts, heading
from frictool.presentation.page import render_page
from frictool.presentation.sections import PageFigure

FOLDER = Path(__file__).parent
TONES = {True: "broken", False: "met", None: "open"}


def page_of_log(
    outcome: ObservationOutcome, model: Model, picture: str, provenance: Provenance
) -> str:
    """Return the HTML page of one log; the same inputs give the same bytes.

    `picture` is the plot of the log as an `<svg>` element.
    """
    verdict = outcome.verdict
    caption = (
        "Estimates with their intervals; the wear is updated at the end of each move. "
        "The limit is dashed."
    )
    return render_page(
        FOLDER,
        provenance,
        title=heading(outcome),
        banner="" if verdict is None else f"wear limit {verdict.limit:g}: {verdict.reason}",
        tone=TONES[None if verdict is None else verdict.exceeded],
        picture=PageFigure("", picture, caption),
        table=facts(outcome, model),
        remarks=outcome.warnings,
    )


def page_of_fleet(
    table: Sequence[FleetRow], limit: float | None, picture: str, provenance: Provenance
) -> str:
    """Return the HTML page of a fleet; `picture` is the plot of the trend as an `<svg>` element."""
    alarms = {row.alarm for row in table} if limit is not None else {None}
    return render_page(
        FOLDER,
        provenance,
        title="Wear of a fleet",
        banner=headline(table, limit),
        tone=TONES[True if True in alarms else None if None in alarms else False],
        picture=PageFigure("", picture, "Each log with its interval. The limit is dashed."),
        table=text_table(table),
        remarks=[],
    )
