"""Comparison as one HTML file with tables and figures that works without other files."""

from __future__ import annotations

from pathlib import Path

from frictool.compare import text_view
from frictool.compare.comparison import Comparison
from frictool.compare.thesis_figures import pictures
from frictool.documents.provenance import Provenance
from frictool.presentation.page import render_page


def page(comparison: Comparison, provenance: Provenance, explain: bool = False) -> str:
    """Return the comparison as HTML text; the same inputs give the same bytes.

    `explain`: True to add the table cells that differ from the thesis.
    """
    return render_page(
        Path(__file__).parent,
        provenance,
        setting=comparison.setting,
        scaling=text_view.scaling(comparison),
        tables=text_view.tables(comparison),
        differences=comparison.differences if explain else (),
        rows=text_view.ROWS,
        pictures=pictures(comparison),
    )
