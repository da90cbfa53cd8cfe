"""Figures as SVG text, the same bytes for the same data: no date, no random ids, no user settings.

Every text in a figure is the program's own; names from files stand in the page's legend, where they are escaped.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK = "#1d2733"
MUTED = "#6b7785"
GRID = "#e3e7ec"
ZONE = "#cfe3d4"
LIMIT = "#b3261e"
# one per log, told apart with deficient colour vision and in grey
LOG_COLOURS = ("#1f5fa8", "#c4620a", "#2f7d4f", "#8a3d8f", "#5c6b00", "#8c2f39")
WIDTH, HEIGHT = 5.0, 2.7  # inches: a phone's width shows it at three quarters, half a desktop page at 1.2

STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "text.parse_math": False,
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
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
    """An empty figure with `rows` axes over one abscissa, the first the tallest."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=[1.6, *[1.0] * (rows - 1)])
    return figure, [row[0] for row in axes]


def render(figure: Figure, label: str) -> str:
    """The figure as an `<svg>` element to stand in a page; `label` is what a screen reader says (the program's own text)."""
    buffer = io.StringIO()
    canvas: Any = FigureCanvasSVG(figure)
    canvas.print_svg(buffer, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r'(<g) id="[^"]*"', r"\1", text)  # ids of groups repeat from figure to figure and nothing refers to them
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'<svg([^>]*?) width="[^"]*"', r"<svg\1", text, count=1)
    text = re.sub(r'<svg([^>]*?) height="[^"]*"', r"<svg\1", text, count=1)
    return text.replace("<svg", f'<svg role="img" aria-label="{label}"', 1).strip()
