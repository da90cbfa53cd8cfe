"""Figure of the candidates of a search: response time, modulus margin and drive."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictool.campaign.automatic_design import AutomaticDesign
from frictool.documents.metric_table import requirement_title
from frictool.presentation.svg import drawing, render
from frictool.synth.search.played_search import Candidate
from frictool.typing import BoolVector, Vector

WIDTH, HEIGHT = 9.0, 3.4  # inches
OTHER, MET, LIMIT = "#b9c2cc", "#1f5fa8", "#c0392b"
TRADED = ("response_time_95_s", "modulus_margin", "drive_peak", "overshoot_percent")
PANELS = 3


def search_picture(found: AutomaticDesign, name: str) -> str:
    """Return the figure of a search as `<svg>` element; the same search gives the same bytes."""
    played = [one for outcome in found.outcomes for one in outcome.trade]
    with drawing("search"):
        return render(
            figure(played), f"{name}: values of the simulated candidates, and the specified limits"
        )


def figure(played: list[Candidate]) -> Figure:
    """Return a figure of the candidates, with a panel for each pair of requirements.

    At most three requirements are shown.
    """
    drawn = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
    metrics = played[0].metrics if played else ()
    traded = [one for key in TRADED for one in metrics if one.key == key]
    pairs = list(combinations(traded[:PANELS], 2))
    if not pairs:
        return drawn
    met = np.array([max(one.missing.values()) <= 0.0 for one in played])
    for axes, pair in zip(np.atleast_1d(drawn.subplots(1, len(pairs))), pairs, strict=True):
        values = np.array([[one.worst(metric) for metric in pair] for one in played])
        _panel(axes, np.where(np.isfinite(values), values, np.nan), met, pair)
    return drawn


def _panel(axes: Axes, values: Vector, met: BoolVector, metrics: tuple[Any, Any]) -> None:
    axes.plot(*values[~met].T, ".", color=OTHER, markersize=4, label="candidate")
    axes.plot(*values[met].T, "o", color=MET, markersize=5, label="meets every requirement")
    across, up = metrics
    axes.axvline(across.limit, color=LIMIT, linewidth=1.0)
    axes.axhline(up.limit, color=LIMIT, linewidth=1.0, label="specified")
    axes.set_xlabel(_label(across))
    axes.set_ylabel(_label(up))
    axes.legend(loc="best", fontsize=7)


def _label(metric: Any) -> str:
    unit = f", {metric.unit}" if metric.unit else ""
    return f"{requirement_title(metric.name)}{unit}"
