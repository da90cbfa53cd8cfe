"""Curves as an `<svg>` element in the style of the page: panels over a common abscissa."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, NullFormatter

from frictool.presentation.decimation import decimated_indices
from frictool.presentation.plot import FigureMargins
from frictool.presentation.svg import PAGE, drawing, panels, render
from frictool.typing import Vector

COLOURS, DASHES = (
    ("#1f5fa8", "#c4620a", "#2f7d4f", "#8a3d8f"),
    ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (6, 1, 1, 1))),
)
REFERENCE = "#1d2733"
WIDTH, HEIGHT, LEGEND = 7.4, 1.75, 0.9  # inches; of a row; beside the first
MARGINS = FigureMargins(left=0.74, right=0.11, bottom=0.5, top=0.18, label=0.25)
STYLE = {**PAGE, "lines.linewidth": 1.3, "axes.formatter.limits": (-3, 5)}
DEEPEST = 120.0  # dB


@dataclass(frozen=True)
class Curve:
    """Curve x, y (n,); style: line, points, or reference (thin and dashed)."""

    x: Vector
    y: Vector
    label: str = ""
    style: str = "line"


Row = tuple[str, list[Curve]]


def _decades(panel: Axes) -> None:
    """Set a logarithmic abscissa; values more than DEEPEST below the largest are not shown."""
    panel.set_xscale("log")
    panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    panel.xaxis.set_minor_formatter(NullFormatter())
    low, high = panel.get_ylim()
    panel.set_ylim(max(low, high - DEEPEST), high)


def _plot(panel: Axes, curves: list[Curve], thin: bool) -> None:
    """Draw the curves; those that are no reference have colours in order."""
    drawn = 0
    for curve in curves:
        shown = decimated_indices(curve.y) if thin and curve.style != "points" else slice(None)
        x, y = curve.x[shown], curve.y[shown]
        label = curve.label or None
        if curve.style == "reference":
            panel.plot(x, y, color=REFERENCE, linewidth=0.9, linestyle=(0, (4, 2)), label=label)
            continue
        if curve.style == "points":
            panel.plot(x, y, "x", color=COLOURS[drawn % 4], markersize=3.5, label=label)
        else:
            panel.plot(x, y, color=COLOURS[drawn % 4], linestyle=DASHES[drawn % 4], label=label)
        drawn += 1


def draw(name: str, abscissa: str, rows: list[Row], *, log: bool = False, thin: bool = True) -> str:
    """Return a figure with one panel per row.

    name: description for screen readers. log: True for an abscissa in decades and ordinates in dB
    or rad. thin: True to decimate long curves to their extremes.
    """
    height = 0.75 + HEIGHT * len(rows) + LEGEND * (len(rows) == 1)
    with drawing(name, STYLE):
        figure, drawn = panels((WIDTH, height), MARGINS, len(rows), space=0.16)
        for panel, (label, curves) in zip(drawn, rows, strict=True):
            _plot(panel, curves, thin)
            if log:
                _decades(panel)
            panel.set_ylabel(label)
            if any(curve.label for curve in curves):
                panel.legend(frameon=False, loc="best")
        drawn[-1].set_xlabel(abscissa)
        return render(figure, name)
