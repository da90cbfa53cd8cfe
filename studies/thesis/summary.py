"""The reproduction for machines (tables.json) and for a terminal."""

from __future__ import annotations

import json
import math
from typing import Any

from studies.thesis.comparison import Judged
from studies.thesis.documents import KINDS, Documents
from studies.thesis.results import Found, Part


def as_json(documents: Documents, part: Part, judged: Judged) -> str:
    """Every value of both, every figure's words, and what is wrong; no SVG."""
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
            "beside": part.beside.get(name, []),
        }
        for name, lines in judged.tables.items()
    }
    figures = {
        number: {**_plain(documents, number), "here": drawn.caption}
        for number, drawn in part.figures.items()
        if number in documents.figures
    }
    counts = {
        kind: {"values": count, "agree": good} for kind, (count, good) in judged.counts.items()
    }
    whole = {
        "counts": counts,
        "tables": tables,
        "figures": figures,
        "problems": list(judged.problems),
    }
    return json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


def _number(found: Found) -> dict[str, Any]:
    told: dict[str, Any] = {"ours": _finite(found.value)}
    if found.low is not None and found.high is not None:
        told |= {"low": _finite(found.low), "high": _finite(found.high), "spread": found.spread}
    return told


def _finite(value: float | str) -> float | str | None:
    return value if isinstance(value, str) or math.isfinite(value) else None


def _plain(documents: Documents, number: str) -> dict[str, str]:
    figure = documents.figures[number]
    return {"title": figure.title, "where": figure.where, "there": figure.shows}


def summary(documents: Documents, part: Part, judged: Judged) -> list[str]:
    """A line a table, then what differs and why, then what is wrong."""
    lines = [f"{'':<20}{'values':>8}{'agree':>8}{'differ':>8}"]
    for name, found in judged.tables.items():
        good = sum(line.agrees for line in found)
        lines.append(
            f"{name:<20}{len(found):>8}{good:>8}{len(found) - good:>8}   {documents.tables[name].title}"
        )
    every = judged.lines
    good = sum(line.agrees for line in every)
    lines.append(
        f"{'all':<20}{len(every):>8}{good:>8}{len(every) - good:>8}   and {len(part.figures)} figures; of these:"
    )
    lines += [
        f"{kind:>18}  {count:>8}{agree:>8}{count - agree:>8}   {KINDS[kind]}"
        for kind, (count, agree) in judged.counts.items()
    ]
    lines.append("")
    for name, found in judged.tables.items():
        lines += [
            f"{name} {line.key}: {line.ours}, published {line.published}: {line.word or 'WITHOUT A WORD'}"
            for line in found
            if not line.agrees
        ]
    if judged.problems:
        lines += [
            "",
            f"WRONG: {len(judged.problems)}",
            *(f"  {problem}" for problem in judged.problems),
        ]
    return lines
