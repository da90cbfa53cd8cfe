"""Tables and figures of a command's result, for its text and its HTML page.

`TextTable.lines` renders a table as text; sections.html.jinja renders tables and figures on a page.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup


@dataclass(frozen=True)
class FigureView:
    """Named range of a figure, to which a reader can zoom.

    - abscissa, ordinate: (low, high) of the values that are shown; None for all values
    - panel: index of the panel to which `ordinate` applies
    """

    name: str
    abscissa: tuple[float, float] | None = None
    ordinate: tuple[float, float] | None = None
    panel: int = 0

    def as_json(self) -> dict[str, Any]:
        """Return the range in the form that explore.js reads."""
        return {
            "name": self.name,
            "panel": self.panel,
            "xlim": self.abscissa,
            "ylim": self.ordinate,
        }


@dataclass(frozen=True)
class PageFigure:
    """Figure with its title and caption as plain text, and the text of its `<svg>` element.

    - key: name of the figure, to which links on the page refer
    - views: ranges that a reader can choose
    """

    title: str
    svg: str
    caption: str = ""
    key: str = ""
    views: tuple[FigureView, ...] = ()

    @property
    def views_json(self) -> str:
        """Return the views as JSON."""
        return json.dumps([view.as_json() for view in self.views])

    @property
    def markup(self) -> Markup:
        """Return the `<svg>` element as Markup, which the template does not escape."""
        return Markup(self.svg)


@dataclass(frozen=True)
class TextTable:
    """Table of texts, one tuple per row.

    - title: title on the page
    - headings: one heading per column; empty for a table without headings
    - names: number of columns at the left that contain names and are left-aligned; the other
      columns contain values and are right-aligned. If None, all columns are left-aligned
    - left_out: number of additional rows that are not in the table
    - notes: explanations of headings and cells, one per line below the table
    """

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    names: int | None = None
    left_out: int = 0
    notes: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """Return the table as aligned lines of text, headings first and notes last."""
        rows = [*([self.headings] if self.headings else []), *self.rows]
        return [*aligned(rows, self.names), *self.notes]


def aligned(rows: Sequence[Sequence[str]], names: int | None = None) -> list[str]:
    """Return rows of equal length as lines of text with aligned columns.

    The first `names` columns are left-aligned, all others right-aligned. If `names` is None, all
    columns are left-aligned.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    left = len(widths) if names is None else names
    return [
        "  ".join(
            text.ljust(width) if column < left else text.rjust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def plain(text: str) -> str:
    """Return the text with "?" in place of each character that cannot be printed.

    The text comes from a file: a terminal would execute its control characters, and XML forbids
    them.
    """
    return "".join(c if c.isprintable() else "?" for c in text)
