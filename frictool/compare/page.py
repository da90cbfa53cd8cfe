"""The comparison as one HTML file: tables and figures. No script, no request to anywhere."""

from __future__ import annotations

from pathlib import Path

from markupsafe import Markup

from frictool.compare import text
from frictool.compare.comparison import Comparison
from frictool.compare.pictures import pictures
from frictool.documents.provenance import Provenance
from frictool.page import filled


def page(found: Comparison, provenance: Provenance) -> str:
    """The HTML text; the same inputs give the same bytes. Every text from a file is escaped by the template."""
    return filled(
        Path(__file__).parent,
        provenance,
        setting=found.setting,
        scaling=text.scaling(found),
        tables=[
            ("What was measured", text.figures(found)),
            ("The four tests of 3.7", text.verdicts(found)),
            ("Properties of the laws", text.properties(found)),
        ],
        differences=found.differences,
        rows=text.ROWS,
        pictures=[(picture.number, picture.title, Markup(picture.svg)) for picture in pictures(found)],
    )
