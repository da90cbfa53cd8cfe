"""Curves as an `<svg>` element in the page's style: axes below each other over one abscissa."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter
from numpy.typing import NDArray

from frictool.svg import PAGE, render

Vector = NDArray[np.float64]
COLOURS, DASHES = ("#1f5fa8", "#c4620a", "#2f7d4f", "#8a3d8f"), ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (6, 1, 1, 1)))
REFERENCE = "#1d2733"
WIDTH, HEIGHT, LEGEND = 7.4, 1.75, 0.9  # inches; of a row; beside the first
DEEPEST = 120.0  # dB
BUCKETS = 900  # a long curve keeps the least and the greatest of each


@dataclass(frozen=True)
class Curve:
    """x, y (n,); style: line, points, or reference (a thin dashed one in ink)."""

    x: Vector
    y: Vector
    label: str = ""
    style: str = "line"


Row = tuple[str, list[Curve]]


def kept(curve: Curve) -> tuple[Vector, Vector]:
    """What a curve of that width can show of a long record."""
    x, y = np.asarray(curve.x), np.asarray(curve.y)
    if x.size <= 2 * BUCKETS or curve.style == "points":
        return x, y
    edges = np.linspace(0, x.size, BUCKETS + 1).astype(int)
    chosen = {0, x.size - 1}
    for start, end in itertools.pairwise(edges):
        chosen |= {start + int(np.argmin(y[start:end])), start + int(np.argmax(y[start:end]))}
    index = np.array(sorted(chosen))
    return x[index], y[index]


def _decades(panel: Axes) -> None:
    """A logarithmic abscissa with plain numbers; what is more than DEEPEST below the largest is not shown."""
    panel.set_xscale("log")
    panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    panel.xaxis.set_minor_formatter(NullFormatter())
    low, high = panel.get_ylim()
    panel.set_ylim(max(low, high - DEEPEST), high)


def _plot(panel: Axes, curves: list[Curve], thin: bool) -> None:
    """The curves, those that are no reference in the colours' order."""
    drawn = 0
    for curve in curves:
        x, y = kept(curve) if thin else (curve.x, curve.y)
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
    """One axes a row; `name` is what a screen reader says.

    log: abscissa in decades, ordinates in dB or rad. thin: long curves by their extremes.
    """
    height = 0.75 + HEIGHT * len(rows) + LEGEND * (len(rows) == 1)
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({**PAGE, "svg.hashsalt": name, "lines.linewidth": 1.3, "axes.formatter.limits": (-3, 5)})
        figure = Figure(figsize=(WIDTH, height))
        figure.subplots_adjust(left=0.1, right=0.985, bottom=0.5 / height, top=1.0 - 0.18 / height, hspace=0.16)
        panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
        for panel, (label, curves) in zip(panels, rows, strict=True):
            _plot(panel, curves, thin)
            if log:
                _decades(panel)
            panel.set_ylabel(label)
            panel.yaxis.set_label_coords(-0.075, 0.5)
            if any(curve.label for curve in curves):
                panel.legend(frameon=False, loc="best")
        panels[-1].set_xlabel(abscissa)
        return render(figure, name)
