"""What the figures of a report have in common: style, margins, colours.

Every text in a figure is the program's own; names from files stand in the page's legend, where they
are escaped.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from frictool.presentation import svg
from frictool.presentation.svg import INK, PAGE, FigureMargins

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ZONE = "#cfe3d4"
LIMIT = "#b3261e"
# one per log, told apart with deficient colour vision and in grey
LOG_COLOURS = ("#1f5fa8", "#c4620a", "#2f7d4f", "#8a3d8f", "#5c6b00", "#8c2f39")
MARGINS = FigureMargins(left=0.8, right=0.12, bottom=0.5, top=0.18, label=0.12)
WIDTH, HEIGHT = (
    5.0,
    2.7,
)  # inches: a phone's width shows it at three quarters, half a desktop page at 1.2

STYLE: dict[str, Any] = {
    **PAGE,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.4,
    "path.simplify": True,
}


def drawing(name: str) -> AbstractContextManager[None]:
    """The settings under which the figure `name` is drawn and rendered."""
    return svg.drawing(name, STYLE)


def new_figure(rows: int = 1, height: float = HEIGHT) -> tuple[Figure, list[Axes]]:
    """A figure with `rows` axes over one abscissa, the first the tallest."""
    return svg.panels((WIDTH, height), MARGINS, rows, ratios=[1.6, *[1.0] * (rows - 1)], space=0.16)
