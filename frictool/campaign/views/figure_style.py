"""Common style of a campaign's figures: settings, margins and colours."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from frictool.presentation import svg
from frictool.presentation.colours import INK
from frictool.presentation.plot import FigureMargins
from frictool.presentation.svg import PAGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GOOD, BAD, OPEN, BAND = "#1f5fa8", "#b3261e", "#8a5a00", "#c9d8ea"
WIDTH, HEIGHT = 5.0, 2.9  # inches
MARGINS = FigureMargins(left=0.8, right=0.15, bottom=0.5, top=0.15, label=0.14)
STYLE: dict[str, Any] = {
    **PAGE,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.4,
}


def drawing(name: str) -> AbstractContextManager[None]:
    """Return a context manager with the matplotlib settings for the figure `name`."""
    return svg.drawing(name, STYLE)


def new_figure(
    rows: int = 1, height: float = HEIGHT, left: float = MARGINS.left
) -> tuple[Figure, list[Axes]]:
    """Return a figure with `rows` axes, one above the other, with a common abscissa."""
    return svg.panels((WIDTH, height), MARGINS._replace(left=left), rows)


def axis_label(name: str, unit: str, number: int) -> str:
    """Return an axis label with the factor's name, or with its number if the name does not fit.

    A name does not fit if it is long, or has letters that the font of the figures may lack.
    """
    shown = (
        name
        if name.isascii() and name.isprintable() and len(name) <= 40
        else f"factor {number + 1}"
    )
    return shown if unit in ("", "1") else f"{shown} [{unit}]"
