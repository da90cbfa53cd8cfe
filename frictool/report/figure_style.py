"""Common style of a report's figures: settings, margins and colours.

Texts in a figure are constants of the program. Names from files appear in the page's legend, which
escapes them.
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
# one per log, distinguishable with deficient colour vision and in grey
LOG_COLOURS = ("#1f5fa8", "#c4620a", "#2f7d4f", "#8a3d8f", "#5c6b00", "#8c2f39")
MARGINS = FigureMargins(left=0.8, right=0.12, bottom=0.5, top=0.18, label=0.12)
WIDTH, HEIGHT = (
    5.0,
    2.7,
)  # inches: scaled to three quarters on a phone, 1.2 times on half a desktop page

STYLE: dict[str, Any] = {
    **PAGE,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.4,
    "path.simplify": True,
    "path.simplify_threshold": 0.25,
}


def drawing(name: str) -> AbstractContextManager[None]:
    """Return a context manager with the matplotlib settings for the figure `name`."""
    return svg.drawing(name, STYLE)


def new_figure(rows: int = 1, height: float = HEIGHT) -> tuple[Figure, list[Axes]]:
    """Return a figure with `rows` axes with a common abscissa; the first axes are the tallest."""
    return svg.panels((WIDTH, height), MARGINS, rows, ratios=[1.6, *[1.0] * (rows - 1)], space=0.16)
