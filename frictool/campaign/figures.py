"""What the figures of a campaign's page have in common: style, margins, colours; the same bytes for the same data."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.figure import Figure

from frictool.svg import INK, PAGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GOOD, BAD, OPEN, BAND = "#1f5fa8", "#b3261e", "#8a5a00", "#c9d8ea"
WIDTH, HEIGHT = 5.0, 2.9  # inches
LEFT, RIGHT, BOTTOM, TOP, LABEL = 0.8, 0.15, 0.5, 0.15, 0.14  # inches; LABEL: the ordinate's, from the left edge
STYLE: dict[Any, Any] = {**PAGE, "xtick.labelcolor": INK, "ytick.labelcolor": INK, "lines.linewidth": 1.4}


@contextmanager
def drawing(name: str) -> Iterator[None]:
    """The settings under which the figure `name` is drawn and rendered."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({**STYLE, "svg.hashsalt": name})
        yield


def new_figure(rows: int = 1, height: float = HEIGHT, left: float = LEFT) -> tuple[Figure, list[Axes]]:
    """A figure with `rows` axes over one abscissa and margins in inches, which are the same in every run."""
    figure = Figure(figsize=(WIDTH, height))
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False)
    figure.subplots_adjust(left=left / WIDTH, right=1.0 - RIGHT / WIDTH, bottom=BOTTOM / height, top=1.0 - TOP / height, hspace=0.14)
    for (one,) in axes:
        one.yaxis.set_label_coords((LABEL - left) / (WIDTH - left - RIGHT), 0.5)
    return figure, [row[0] for row in axes]


def axis_label(name: str, unit: str, number: int) -> str:
    """A factor's name on an axis, if the figures' font has its letters for certain; else its number. The page's headings have it in
    full.
    """
    shown = name if name.isascii() and name.isprintable() and len(name) <= 40 else f"factor {number + 1}"
    return shown if unit in ("", "1") else f"{shown} [{unit}]"
