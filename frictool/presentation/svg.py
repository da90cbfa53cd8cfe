"""Figures as `<svg>` elements, whose size the page determines.

The same data give the same bytes: the text contains no date and no random ids, and the user's
settings have no effect.
"""

from __future__ import annotations

import html
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from frictool.presentation.chart_data import chart_json
from frictool.presentation.colours import GRID, INK, MUTED
from frictool.presentation.plot import FigureMargins

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PAGE: dict[str, Any] = {  # matplotlib settings common to all figures
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
}


@contextmanager
def drawing(name: str, style: Mapping[str, Any] = PAGE) -> Iterator[None]:
    """Set the matplotlib settings for drawing and rendering the figure `name` in the with-block.

    The user's matplotlib settings are ignored. The ids in the SVG text are derived from `name`.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        settings: dict[Any, Any] = {**style, "svg.hashsalt": name}
        mpl.rcParams.update(settings)
        yield


def panels(
    size: tuple[float, float],
    margins: FigureMargins,
    rows: int = 1,
    *,
    ratios: Sequence[float] | None = None,
    space: float = 0.14,
) -> tuple[Figure, list[Axes]]:
    """Return an empty figure with `rows` axes above each other that share one abscissa.

    - size: width and height in inches
    - ratios: relative heights of the axes; None for equal heights
    - space: gap between two axes, relative to their mean height
    """
    (width, height), (left, right, bottom, top, label) = size, margins
    figure = Figure(figsize=size)
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=ratios)
    figure.subplots_adjust(
        left=left / width,
        right=1.0 - right / width,
        bottom=bottom / height,
        top=1.0 - top / height,
        hspace=space,
    )
    for (one,) in axes:
        one.yaxis.set_label_coords((label - left) / (width - left - right), 0.5)
    return figure, [row[0] for row in axes]


def render(figure: Figure, label: str) -> str:
    """Return the text of the figure's `<svg>` element; call this function within `drawing`.

    The element contains the data of the chart that replaces it on a page (chart_data.py). `label`:
    text that screen readers read out.
    """
    buffer = io.StringIO()
    canvas: Any = FigureCanvasSVG(figure)
    canvas.print_svg(buffer, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    # group ids repeat from figure to figure, and nothing refers to them
    text = re.sub(r'(?<=<g) id="[^"]*"', "", text)
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    for size in ("width", "height"):
        text = re.sub(rf'<svg([^>]*?) {size}="[^"]*"', r"<svg\1", text, count=1)
    chart = chart_json(figure)
    if chart is not None:
        data = f'<metadata class="chart-data">{html.escape(chart, quote=False)}</metadata>'
        text = re.sub(r"(<svg[^>]*>)", lambda head: head.group() + data, text, count=1)
    escaped_label = html.escape("".join(c for c in label if c.isprintable()))
    return text.replace("<svg", f'<svg role="img" aria-label="{escaped_label}"', 1).strip()


def render_compact(figure: Figure, label: str) -> str:
    """Return the text of the figure's `<svg>` element with path coordinates cut to 0.1 point.

    The text is shorter than the result of `render`, which matters on a page with many figures.
    `label`: text that screen readers read out.
    """
    return re.sub(
        r' d="[^"]*"',
        lambda path: re.sub(r"\s*\nL ", "L", re.sub(r"(?<=\.\d)\d+", "", path.group())),
        render(figure, label),
    )
