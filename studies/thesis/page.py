"""Reproduction as one HTML file: compared values, reasons of differences, figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from markupsafe import Markup

from frictool.compare.thesis_tables import TABLE_2_1, TABLE_3_2
from frictool.documents.provenance import provenance_of_command
from frictool.presentation.page import render_page
from studies.thesis.comparison import ComparedValue, Comparison
from studies.thesis.documents import GRIDS, KINDS, Documents
from studies.thesis.results import Part

CHAPTERS = {
    "2": "Mechanisms and friction",
    "3": "The hybrid model",
    "4": "Identification",
    "5": "Control",
    "6": "Observers",
    "C": "Annex C",
}


def chapter_of(name: str) -> str:
    """Return the chapter of "table_4_2", "section_5_4", "annex_c_5_2", "figure 5.13" or "5.13"."""
    return (
        "C"
        if name.startswith(("annex", "C"))
        else name.removeprefix("table_").removeprefix("section_")[0]
    )


def called(name: str) -> str:
    """Return the title: "Table 4.2" of "table_4_2", "Thesis 5.4" of "section_5_4"."""
    kind, _, number = name.partition("_")
    return (
        f"{'Thesis' if kind == 'section' else kind.capitalize()} "
        f"{number.replace('_', '.').capitalize()}"
    )


def page(documents: Documents, part: Part, comparison: Comparison) -> str:
    """Return the HTML text; the same values and figures give the same bytes."""
    chapters = [
        _chapter(number, title, documents, part, comparison) for number, title in CHAPTERS.items()
    ]
    lines = comparison.lines
    return render_page(
        Path(__file__).parent,
        provenance_of_command("python -m studies.thesis", []),
        chapters=[chapter for chapter in chapters if chapter["tables"] or chapter["figures"]],
        values=len(lines),
        agreeing=sum(line.agrees for line in lines),
        counts=[(KINDS[kind], *counted) for kind, counted in comparison.counts.items()],
        drawn=len(part.figures),
        problems=comparison.problems,
    )


def _chapter(
    number: str, title: str, documents: Documents, part: Part, comparison: Comparison
) -> dict[str, Any]:
    tables = [
        {
            "name": name,
            "called": called(name),
            "table": documents.tables[name],
            "lines": [
                line
                for line in lines
                if "." not in line.key
                or not documents.tables[name].grid
                or line.key.endswith(".speed")
            ],
            "grid": _grid(documents.tables[name].grid, lines),
            "different": [line for line in lines if not line.agrees]
            if documents.tables[name].grid
            else [],
            "notes": part.notes.get(name, []),
        }
        for name, lines in comparison.tables.items()
        if chapter_of(name) == number
    ]
    figures = [
        {
            "number": key,
            "figure": documents.figures[key],
            "caption": drawn.caption,
            "svgs": [Markup(svg) for svg in drawn.svgs],
        }
        for key, drawn in sorted(part.figures.items(), key=lambda item: _order(item[0]))
        if key in documents.figures and chapter_of(key) == number
    ]
    return {"number": number, "title": title, "tables": tables, "figures": figures}


def _order(number: str) -> tuple[str, int]:
    chapter, _, place = number.partition(".")
    return chapter, int(place)


def _grid(grid: str, lines: list[ComparedValue]) -> dict[str, Any] | None:
    """Return rows of properties over columns of laws, as the thesis prints them."""
    if not grid:
        return None
    printed, heads = GRIDS[grid]
    found = {line.key: line for line in lines}
    laws = list(TABLE_2_1 if grid == "2.1" else TABLE_3_2)
    rows = [
        (head.replace("_", " "), [found.get(f"{law}.{head}") for law in laws]) for head in heads
    ]
    rows += (
        [("speed of simulation", [found.get(f"{law}.speed") for law in laws])]
        if f"{laws[0]}.speed" in found
        else []
    )
    assert list(printed) == laws
    return {"laws": [law.replace("_", " ") for law in laws], "rows": rows, "states": grid == "2.1"}
