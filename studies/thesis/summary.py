"""Reproduction as JSON (tables.json) and as text for a terminal."""

from __future__ import annotations

import json
import math
from typing import Any

from studies.thesis.comparison import Comparison
from studies.thesis.documents import KINDS, Documents
from studies.thesis.results import ComputedValue, Part


def as_json(documents: Documents, part: Part, comparison: Comparison) -> str:
    """Return all compared values, the texts of all figures, and the problems; no SVG."""
    tables = {
        name: {
            "title": documents.tables[name].title,
            "where": documents.tables[name].where,
            "ours": documents.tables[name].ours,
            "values": {
                line.key: {
                    "name": line.name,
                    "unit": documents.tables[name].rows[line.key].unit,
                    **_number(part.values[name][line.key]),
                    "published": documents.tables[name].rows[line.key].value,
                    "within": documents.tables[name].rows[line.key].within,
                    "kind": line.kind,
                    "agrees": line.agrees,
                    "why": line.word or None,
                }
                for line in lines
            },
            "beside": part.notes.get(name, []),
        }
        for name, lines in comparison.tables.items()
    }
    figures = {
        number: {**_plain(documents, number), "here": drawn.caption}
        for number, drawn in part.figures.items()
        if number in documents.figures
    }
    counts = {
        kind: {"values": count, "agree": good} for kind, (count, good) in comparison.counts.items()
    }
    whole = {
        "counts": counts,
        "tables": tables,
        "figures": figures,
        "problems": list(comparison.problems),
    }
    return json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


def _number(found: ComputedValue) -> dict[str, Any]:
    fields: dict[str, Any] = {"ours": _finite(found.value)}
    if found.low is not None and found.high is not None:
        fields |= {"low": _finite(found.low), "high": _finite(found.high), "spread": found.spread}
    return fields


def _finite(value: float | str) -> float | str | None:
    return value if isinstance(value, str) or math.isfinite(value) else None


def _plain(documents: Documents, number: str) -> dict[str, str]:
    figure = documents.figures[number]
    return {"title": figure.title, "where": figure.where, "there": figure.shows}


def summary(documents: Documents, part: Part, comparison: Comparison) -> list[str]:
    """Return a line for each table, then the differences with their reasons, then the problems."""
    lines = [f"{'':<20}{'values':>8}{'agree':>8}{'differ':>8}"]
    for name, found in comparison.tables.items():
        good = sum(line.agrees for line in found)
        lines.append(
            f"{name:<20}{len(found):>8}{good:>8}{len(found) - good:>8}   "
            f"{documents.tables[name].title}"
        )
    every = comparison.lines
    good = sum(line.agrees for line in every)
    lines.append(
        f"{'all':<20}{len(every):>8}{good:>8}{len(every) - good:>8}   and {len(part.figures)} "
        "figures; of these:"
    )
    lines += [
        f"{kind:>18}  {count:>8}{agree:>8}{count - agree:>8}   {KINDS[kind]}"
        for kind, (count, agree) in comparison.counts.items()
    ]
    lines.append("")
    for name, found in comparison.tables.items():
        lines += [
            f"{name} {line.key}: {line.ours}, published {line.published}: "
            f"{line.word or 'NO REASON IN words.yaml'}"
            for line in found
            if not line.agrees
        ]
    if comparison.problems:
        lines += [
            "",
            f"WRONG: {len(comparison.problems)}",
            *(f"  {problem}" for problem in comparison.problems),
        ]
    return lines
