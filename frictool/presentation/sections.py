"""Tables and figures of a stage's result, for its text and its page.

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
    """Named range that a reader can choose in a figure.

    - abscissa, ordinate: ends of the range; None for the whole range
    - panel: index of the panel of the figure
    """

    name: str
    abscissa: tuple[float, float] | None = None
    ordinate: tuple[float, float] | None = None
    panel: int = 0

    def as_json(self) -> dict[str, Any]:
        """Return the range as explore.js reads it."""
        return {
            "name": self.name,
            "panel": self.panel,
            "xlim": self.abscissa,
            "ylim": self.ordinate,
        }


@dataclass(frozen=True)
class PageFigure:
    """Figure: title and caption as plain text, and the text of the `<svg>` element.

    - key: name of the figure, to which other parts of the page link
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
        """Return the `<svg>` element, marked so that a page does not escape it."""
        return Markup(self.svg)


@dataclass(frozen=True)
class TextTable:
    """Table of texts, one tuple per row.

    - title: title on the page
    - headings: one heading per column, or none
    - names: number of left-aligned columns, which name the row; the other columns contain values
      and are aligned on the right. None: all columns are aligned on the left
    - left_out: number of rows that are not shown
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
    """Return rows of equal length as lines; the first `names` columns are left-aligned.

    Without `names` all columns are aligned on the left.
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
    """Return text from a file without control characters, which terminals obey and XML forbids."""
    return "".join(c if c.isprintable() else "?" for c in text)
