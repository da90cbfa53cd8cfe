"""Plot of a weight relaxation: gamma against W1 for each W3, and the trade-off curve."""

from __future__ import annotations

import math
from itertools import groupby

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictool.presentation.svg import drawing, render
from frictool.synth.weight_relaxation import Trade

WIDTH, HEIGHT = 7.0, 6.0  # inches
CURVE, CHOSEN, REQUIRED = "#444444", "#c0392b", "#1f5fa8"


def picture(trade: Trade, name: str) -> str:
    """Return the plot as an `<svg>` element; the same trade-off gives the same bytes."""
    with drawing("relax"):
        return render(
            figure(trade),
            f"{name}: gamma against the weights W1 and W3, and the chosen weights",
        )


def figure(trade: Trade) -> Figure:
    """Return the plot with two logarithmic axes; the lines of a larger W3 are darker."""
    drawn = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
    upper, lower = drawn.subplots(2, 1)
    _levels(upper, trade)
    lower.loglog(
        [p.drive for p in trade.curve],
        [p.disturbance for p in trade.curve],
        "o-",
        color=CURVE,
        markersize=3,
        label="achievable below",
    )
    lower.loglog(
        trade.start.drive,
        trade.start.disturbance,
        "s",
        color=REQUIRED,
        markersize=5,
        label="strictest",
    )
    lower.loglog(
        trade.chosen.drive,
        trade.chosen.disturbance,
        "o",
        color=CHOSEN,
        markersize=7,
        label="chosen",
    )
    lower.set_xlabel("W3, effort")
    lower.set_ylabel("W1, disturbance rejection")
    lower.legend(loc="lower left")
    return drawn


def _levels(axes: Axes, trade: Trade) -> None:
    finite = sorted(
        (p for p in trade.points if math.isfinite(p.level)), key=lambda p: (-p.drive, p.disturbance)
    )
    lines = [list(group) for _, group in groupby(finite, key=lambda p: p.drive)]
    for index, line in enumerate(lines):
        shade = str(0.15 + 0.65 * index / max(1, len(lines) - 1))
        axes.loglog(
            [p.disturbance for p in line],
            [p.level for p in line],
            ".-",
            color=shade,
            label=f"W3 {line[0].drive:.3g}",
        )
    axes.axhline(trade.required, color=REQUIRED, linewidth=0.9)
    axes.loglog(trade.chosen.disturbance, trade.chosen.level, "o", color=CHOSEN, markersize=7)
    axes.set_xlabel("W1, disturbance rejection")
    axes.set_ylabel("gamma")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="x-small")
