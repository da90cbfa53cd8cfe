"""Markdown view of the verdict, for a merge request."""

from __future__ import annotations

import re

from frictool.documents.metric_table import requirement_title
from frictool.presentation.sections import plain
from frictool.report.requirement import Verdict, number, unit_shown

MARKS = {"MET": "✅ met", "NOT MET": "❌ **not met**", "UNDECIDED": "❔ undecided"}


def markdown(verdict: Verdict) -> str:
    """Return a heading with the verdict and a table with one row per requirement."""
    rows = [
        f"### {_plain(verdict.name)}: {verdict.headline}",
        "",
        "| requirement | value | limit | | where, why |",
        "| --- | ---: | ---: | --- | --- |",
    ]
    for r in verdict.requirements:
        remark = "; ".join(part for part in (str(r.where or ""), r.reason) if part)
        value = "–" if r.value is None else f"{number(r.value)} {unit_shown(r.unit)}".strip()
        limit = (
            f"{'≤' if r.relation == '<=' else '≥'} {number(r.limit)} {unit_shown(r.unit)}".strip()
        )
        rows.append(
            f"| {requirement_title(r.name)} | {value} | {limit} | {MARKS[r.outcome]} | "
            f"{_plain(remark)} |"
        )
    rows += [f"\n**Warning:** {_plain(remark)}" for remark in verdict.remarks]
    return "\n".join(rows) + "\n"


def _plain(text: str) -> str:
    """Return text from a file with Markdown and HTML syntax escaped."""
    literal = plain(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_{}\[\]#|~@])", r"\\\1", literal)
