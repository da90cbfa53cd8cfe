"""Plot of a fleet's wear against the date, with one line per unit and an interval per log."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

import numpy as np
from matplotlib import dates
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from frictool.observe.estimate_plot import LIMIT, MARGINS, WIDTH, drawing
from frictool.observe.fleet_table import FleetRow
from frictool.observe.wear_estimate import EstimateRange
from frictool.presentation.svg import panels, render

COLOURS = ("#1f5fa8", "#c4620a", "#2f7d4f", "#8a3d8f", "#5c6b00", "#8c2f39")
MARKS = ("o", "s", "^", "D", "v", "P")
HEIGHT = 3.8  # inches
MOST_NAMED = 12  # largest number of units in a legend; colours cannot distinguish more
UNNAMED = "no unit"


def trend(table: Sequence[FleetRow], limit: float | None) -> str:
    """Return the plot as an `<svg>` element.

    If ratios to commissioning are known, the plot shows them (1 for the first log of a unit), else
    the wear. If a log has no date, the abscissa is the order of the logs in the table.
    """
    ratios = any(row.ratio is not None for row in table)
    shown = [(row, estimate) for row in table if (estimate := _shown(row, ratios)) is not None]
    dated = bool(shown) and all(row.date is not None for row, _ in shown)
    units = list(dict.fromkeys(row.unit or UNNAMED for row, _ in shown))
    with drawing("trend"):
        figure, (axes,) = panels((WIDTH, HEIGHT), MARGINS)
        where = {
            row.file: _day(row.date or "") if dated else float(index)
            for index, (row, _) in enumerate(shown, start=1)
        }
        for number, unit in enumerate(units):
            points = [
                (where[row.file], estimate)
                for row, estimate in shown
                if (row.unit or UNNAMED) == unit
            ]
            points.sort(key=lambda one: one[0])
            _draw(axes, number, unit, points)
        if limit is not None:
            axes.axhline(limit, color=LIMIT, linestyle=(0, (4, 2)), linewidth=1.0)
        axes.set_ylabel("wear relative to commissioning [1]" if ratios else "wear [1]")
        _abscissa(axes, dated)
        if 1 < len(units) <= MOST_NAMED:
            axes.legend(loc="best", fontsize="small", framealpha=0.9)
        return render(figure, "wear of each unit against the date")


def _abscissa(axes: Axes, dated: bool) -> None:
    if not dated:
        axes.set_xlabel("log, in the table's order")
        axes.xaxis.set_major_locator(MaxNLocator(10, integer=True, min_n_ticks=1))
        return
    locator: Any = dates.AutoDateLocator(minticks=3, maxticks=7)  # type: ignore[no-untyped-call]  # has no types
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(dates.ConciseDateFormatter(locator))  # type: ignore[no-untyped-call]  # has no types


def _draw(axes: Any, number: int, unit: str, points: Sequence[tuple[float, EstimateRange]]) -> None:
    value = np.array([estimate.value for _, estimate in points])
    reach = np.array(
        [
            [max(0.0, estimate.value - estimate.low), max(0.0, estimate.high - estimate.value)]
            for _, estimate in points
        ]
    ).T
    style = {
        "color": COLOURS[number % len(COLOURS)],
        "marker": MARKS[number % len(MARKS)],
        "markersize": 3.5,
        "linewidth": 1.0,
    }
    # matplotlib leaves out labels that begin with an underscore
    label = unit.replace("_", " ") if unit.startswith("_") else unit
    axes.errorbar(
        [index for index, _ in points],
        value,
        yerr=reach,
        label=label,
        capsize=2.0,
        elinewidth=0.9,
        **style,
    )


def _shown(row: FleetRow, ratios: bool) -> EstimateRange | None:
    if row.outcome is None or not row.outcome.estimate.moves:
        return None
    if ratios:
        return EstimateRange(1.0, 1.0, 1.0) if row.first else row.ratio
    return row.outcome.estimate.wear


def _day(date: str) -> float:
    day: float = dates.date2num(datetime.fromisoformat(date).replace(tzinfo=None))  # type: ignore[no-untyped-call]  # has no types
    return day
