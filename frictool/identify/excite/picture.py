"""A test as an SVG: what is played over time, one axes for each column."""

from __future__ import annotations

from itertools import pairwise

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from frictool.identify.excite.sequence import Sequence
from frictool.svg import render

POINTS = 4000  # of a curve; more is thinned to the extremes of each stretch
WIDTH, HEIGHT = 7.0, 1.8  # inches; of each axes


def picture(sequence: Sequence) -> str:
    """The `<svg>` element, the same bytes for the same test."""
    with mpl.rc_context({"svg.hashsalt": sequence.kind, "svg.fonttype": "none", "font.family": ["sans-serif"], "axes.grid": True}):
        figure = Figure(figsize=(WIDTH, HEIGHT * len(sequence.columns)), layout="constrained")
        axes = figure.subplots(len(sequence.columns), 1, sharex=True, squeeze=False)[:, 0]
        for ax, (name, values) in zip(axes, sequence.columns.items(), strict=True):
            shown = _extremes(values)
            ax.plot(sequence.time[shown], values[shown], linewidth=0.9, color="#1f5fa8")
            unit = sequence.units[name]
            ax.set_ylabel(name.replace("_", "\n") + (f"\n{unit}" if unit != "1" else ""))
        axes[-1].set_xlabel("time, s")
        return render(figure, f"{sequence.kind} test over time")


def _extremes(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Samples to draw: all, or the lowest and the highest of each stretch."""
    if values.size <= POINTS:
        return np.arange(values.size)
    edges = np.linspace(0, values.size, POINTS // 2 + 1).astype(np.int64)
    pairs = [(a + int(np.argmin(values[a:b])), a + int(np.argmax(values[a:b]))) for a, b in pairwise(edges)]
    return np.unique(np.array([0, *(index for pair in pairs for index in pair), values.size - 1]))
