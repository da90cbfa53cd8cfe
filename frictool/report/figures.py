"""Figures as SVG text, the same bytes for the same data: no date, no random ids, no user settings.

Every text in a figure is the program's own; names from files stand in the page's legend, where they are escaped.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.figure import Figure

from frictool.svg import INK, PAGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ZONE = "#cfe3d4"
LIMIT = "#b3261e"
# one per log, told apart with deficient colour vision and in grey
LOG_COLOURS = ("#1f5fa8", "#c4620a", "#2f7d4f", "#8a3d8f", "#5c6b00", "#8c2f39")
LEFT, RIGHT, BOTTOM, TOP, LABEL = 0.8, 0.12, 0.5, 0.18, 0.12  # inches; LABEL: the ordinate's, from the left edge
WIDTH, HEIGHT = 5.0, 2.7  # inches: a phone's width shows it at three quarters, half a desktop page at 1.2

STYLE: dict[Any, Any] = {
    **PAGE,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.4,
    "path.simplify": True,
}


@contextmanager
def drawing(name: str) -> Iterator[None]:
    """The settings under which the figure `name` is drawn and rendered."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({**STYLE, "svg.hashsalt": name})
        yield


def new_figure(rows: int = 1, height: float = HEIGHT) -> tuple[Figure, list[Axes]]:
    """An empty figure with `rows` axes over one abscissa, the first the tallest.

    The margins are the same in all figures, so that the axes of a column of the page begin below each other; to fit them to the
    labels of each would take longer than everything else of a page.
    """
    figure = Figure(figsize=(WIDTH, height))
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=[1.6, *[1.0] * (rows - 1)])
    figure.subplots_adjust(left=LEFT / WIDTH, right=1.0 - RIGHT / WIDTH, bottom=BOTTOM / height, top=1.0 - TOP / height, hspace=0.16)
    for (one,) in axes:
        one.yaxis.set_label_coords((LABEL - LEFT) / (WIDTH - LEFT - RIGHT), 0.5)
    return figure, [row[0] for row in axes]
