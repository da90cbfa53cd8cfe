"""Plot of wear, friction and velocity against time, each with its interval, as SVG.

The signals are reduced to minima and maxima while the log is read (streamed_decimation.py), so that
memory does not grow with the length of the log, and peaks stay visible.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

import numpy as np

from frictool.documents.quantity import Axis, si_unit
from frictool.observe.combined_estimator import EstimateBlock
from frictool.observe.streamed_decimation import DecimatedTrace, zigzag
from frictool.presentation import svg
from frictool.presentation.plot import FigureMargins
from frictool.presentation.svg import PAGE, panels, render
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LIMIT = "#b3261e"
WEAR, FRICTION, VELOCITY = "#1f5fa8", "#c4620a", "#2f7d4f"
WIDTH, HEIGHT = 7.0, 6.6  # inches
MARGINS = FigureMargins(left=0.9, right=0.15, bottom=0.5, top=0.15, label=0.22)
BAND = 0.25  # opacity of the area that shows an interval
LONG_S, LONGER_S = 600.0, 7200.0  # s, durations above which time is drawn in minutes, in hours
STYLE: dict[str, Any] = {**PAGE, "lines.linewidth": 1.2}


def drawing(name: str) -> AbstractContextManager[None]:
    """Return a context manager with the plot settings of the figure `name`."""
    return svg.drawing(name, STYLE)


class EstimatePlot:
    """Plot of the estimates of one log, to which blocks are added one by one."""

    def __init__(self, axis: Axis) -> None:
        self._axis = axis
        self._trace = DecimatedTrace(9)

    def take(self, part: EstimateBlock) -> None:
        """Add the estimates of a block."""
        self._trace.take(part.piece.time, np.concatenate([part.wear, part.friction, part.velocity]))

    def drawn(self, name: str, limit: float | None) -> str:
        """Return the plot as an `<svg>` element.

        - name: name of the log, for the alternative text
        - limit: largest allowed wear, which is drawn as a line; None for no line
        """
        time, low, high = self._trace.drawn()
        scale, unit = _scale(float(time[-1] - time[0]) if time.size else 0.0)
        with drawing("observe"):
            figure, axes = panels((WIDTH, HEIGHT), MARGINS, 3, ratios=[1.2, 1.0, 1.0], space=0.12)
            rows = (
                (WEAR, "wear [1]"),
                (FRICTION, f"friction [{si_unit('effort', self._axis)}]"),
                (VELOCITY, _velocity(self._axis)),
            )
            for number, (one, (colour, label)) in enumerate(zip(axes, rows, strict=True)):
                first = 3 * number
                one.fill_between(
                    time / scale,
                    low[first + 1],
                    high[first + 2],
                    color=colour,
                    alpha=BAND,
                    linewidth=0.0,
                )
                one.plot(*zigzag(time / scale, low[first], high[first]), color=colour)
                one.set_ylabel(label)
            _limit(axes[0], limit)
            axes[0].set_ylim(*_range(low[0], high[0], float(low[1, -1]), float(high[2, -1]), limit))
            axes[-1].set_xlabel(f"time [{unit}]")
            return render(figure, f"wear, friction and velocity against time, {name}")


def _velocity(axis: Axis) -> str:
    return f"velocity [{si_unit('velocity', axis)}]"


def _range(
    low: Vector, high: Vector, least: float, most: float, limit: float | None
) -> tuple[float, float]:
    shown = [float(low.min()), float(high.max()), least, most, *([] if limit is None else [limit])]
    margin = 0.3 * max(max(shown) - min(shown), 0.1)
    return min(shown) - margin, max(shown) + margin


def _limit(axes: Axes, limit: float | None) -> None:
    if limit is not None:
        axes.axhline(limit, color=LIMIT, linestyle=(0, (4, 2)), linewidth=1.0)


def _scale(duration: float) -> tuple[float, str]:
    """Return the unit of the time axis: its length [s] and its symbol."""
    if duration >= LONGER_S:
        return 3600.0, "h"
    return (60.0, "min") if duration >= LONG_S else (1.0, "s")
