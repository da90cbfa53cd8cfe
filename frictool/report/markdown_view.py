"""Markdown view of the verdict, for a merge request."""

from __future__ import annotations

import re

from frictool.presentation.sections import plain
from frictool.report.requirement import Verdict

MARKS = {"MET": "✅ met", "NOT MET": "❌ **not met**", "UNDECIDED": "❔ undecided"}


def markdown(verdict: Verdict) -> str:
    """Return a heading with the verdict and a table with one row per requirement."""
    requirements = [
        f"| {r.title} | {r.value_text or '–'} | {r.sign} {r.limit_text} | {MARKS[r.outcome]} | "
        f"{_plain(r.remark)} | {_plain(r.known)} |"
        for r in verdict.requirements
    ]
    rows = [
        f"### {_plain(verdict.name)}: {verdict.headline}",
        "",
        "| requirement | value | limit | | where, why | known |",
        "| --- | ---: | ---: | --- | --- | --- |",
        *requirements,
        *(f"\n**Warning:** {_plain(remark)}" for remark in verdict.remarks),
    ]
    return "\n".join(rows) + "\n"


def _plain(text: str) -> str:
    literal = plain(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_{}\[\]#|~@])", r"\\\1", literal)
