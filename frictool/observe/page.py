"""A page with the picture, the verdict and the figures, of one log or of a fleet; every text from a file is escaped by the template."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files
from typing import Any

import jinja2
from markupsafe import Markup

from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.observe.outcome import Outcome, facts, heading
from frictool.observe.table import Row, headline, shown

TONES = {True: "bad", False: "good", None: "open"}


def page_of_log(outcome: Outcome, model: Model, picture: str, provenance: Provenance) -> str:
    """The HTML text; the same inputs give the same bytes. picture: the `<svg>` element of the log."""
    verdict = outcome.verdict
    return _page(
        title=heading(outcome),
        banner="" if verdict is None else f"wear limit {verdict.limit:g}: {verdict.reason}",
        tone=TONES[None if verdict is None else verdict.exceeded],
        picture=picture,
        caption="Each with its interval; wear changes when a move has ended, from what was known then. The limit is dashed.",
        facts=facts(outcome, model),
        rows=[],
        headings=[],
        remarks=outcome.warnings,
        provenance=provenance,
    )


def page_of_fleet(table: Sequence[Row], limit: float | None, picture: str, provenance: Provenance) -> str:
    """The same of a fleet. picture: the trend."""
    headings, rows = shown(table)
    alarm = any(row.alarm for row in table)
    return _page(
        title="Wear of a fleet",
        banner=headline(table, limit),
        tone="bad" if alarm else "open" if limit is None or any(row.alarm is None for row in table) else "good",
        picture=picture,
        caption="Each log with its interval. The limit is dashed.",
        facts=[],
        rows=rows,
        headings=headings,
        remarks=[],
        provenance=provenance,
    )


def _page(picture: str, **texts: Any) -> str:
    template = files("frictool.observe").joinpath("page.html.jinja").read_text(encoding="utf-8")
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    return environment.from_string(template).render(picture=Markup(picture), **texts)
