"""Figures without matplotlib: the same chart as matplotlib's, and coordinates read back."""

from __future__ import annotations

import html
import json
import math
import re
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.presentation.axis_ticks import MOST, linear_ticks, log_ticks
from frictool.presentation.chart_data import chart_json
from frictool.presentation.plot import DASHED, FigureMargins, Plot, PlotPanel
from frictool.presentation.svg import PAGE, drawing, panels

SIZE, MARGINS = (5.0, 4.0), FigureMargins(0.8, 0.12, 0.5, 0.18, 0.12)
TIME = np.linspace(0.0, 2.0, 300)
WAVE = 3.0 * np.sin(9.0 * TIME) + 40.0
SVG = "{http://www.w3.org/2000/svg}"


def plotted() -> Plot:
    """Return a figure with one mark of each kind."""
    upper, lower = PlotPanel("upper [m]", ratio=1.6), PlotPanel("lower & [A]")
    upper.across(38.0, 41.0, "#cfe3d4", order=0.5)
    upper.line(TIME, WAVE, "#1f5fa8", alpha=0.4, label="wave", group="waves")
    upper.horizontal(60.0, "#1d2733", width=1.2, dash=DASHED, order=4.0)
    upper.vertical(-1.0, "#6b7785", order=1.0)
    low, high = -WAVE, -WAVE + 1.0
    outline = np.concatenate((TIME, TIME[::-1])), np.concatenate((low, high[::-1]))
    lower.area(*outline, "#c4620a", alpha=0.3, order=1.0)
    return Plot(SIZE, MARGINS, [upper, lower], x_label="time [s]")


def chart(svg: str) -> list[dict[str, Any]]:
    """Return the data of the chart in an element."""
    data = ElementTree.fromstring(svg).findtext(f"{SVG}metadata")
    assert data is not None
    loaded: list[dict[str, Any]] = json.loads(html.unescape(data))
    return loaded


def test_the_chart_is_that_of_matplotlib() -> None:
    with drawing("same", PAGE):
        figure, (upper, lower) = panels(SIZE, MARGINS, 2, ratios=[1.6, 1.0], space=0.16)
        upper.plot(TIME, WAVE, color="#1f5fa8", alpha=0.4, lw=1.4, label="wave", gid="waves")
        upper.axhspan(38.0, 41.0, color="#cfe3d4", linewidth=0.0, zorder=0.5)
        upper.axhline(60.0, color="#1d2733", lw=1.2, linestyle=(0, DASHED), zorder=4.0)
        upper.axvline(-1.0, color="#6b7785", lw=1.4, zorder=1.0)
        upper.set_ylabel("upper [m]")
        lower.fill_between(TIME, -WAVE, -WAVE + 1.0, color="#c4620a", alpha=0.3)
        lower.set(xlabel="time [s]", ylabel="lower & [A]")
        expected = json.loads(chart_json(figure) or "")
    drawn = chart(plotted().svg("same"))
    # an area is an outline in another order
    outlines = [panels[1]["series"].pop()["data"] for panels in (drawn, expected)]
    assert [[part[:2] for part in one] for one in outlines[:1]] == [
        [part[:2] for part in one] for one in outlines[1:]
    ]
    assert drawn == expected


def test_curves_are_at_the_coordinates_of_the_ticks() -> None:
    """Ordinate and abscissa of the curve follow from the labels beside the panel."""
    root = ElementTree.fromstring(plotted().svg("a < b"))
    assert root.get("aria-label") == "a < b"
    texts = [(one.text or "", one) for one in root.iter(f"{SVG}text")]
    assert {"time [s]", "upper [m]", "lower & [A]"} < {text for text, _ in texts}
    group = next(one for one in root.iter(f"{SVG}g") if one.get("text-anchor") == "end")
    rows = [
        (float((one.text or "").replace("\N{MINUS SIGN}", "-")), float(one.get("y", "nan")))
        for one in group
    ]
    slope, level = np.polyfit(*np.array(rows).T, 1)
    path = next(one.get("d", "") for one in root.iter(f"{SVG}path") if one.get("opacity") == "0.4")
    points = np.array([[float(part) for part in one.split()] for one in re.split("[ML]", path)[1:]])
    shift = 0.38 * 9.5  # from the middle of a label to its base line [point]
    assert points[:, 1].min() == pytest.approx(slope * WAVE.max() + level - shift, abs=0.2)
    assert points[:, 1].max() == pytest.approx(slope * WAVE.min() + level - shift, abs=0.2)
    assert np.all(np.diff(points[:, 0]) >= 0.0)
    assert plotted().svg("a < b") == plotted().svg("a < b")


def test_a_logarithmic_abscissa_is_stored_as_logarithms() -> None:
    panel = PlotPanel()
    panel.line(np.geomspace(0.05, 5000.0, 9), np.arange(9.0) ** 2, "#1f5fa8")
    (drawn,) = chart(Plot(SIZE, MARGINS, [panel], x_range=(0.05, 5000.0), is_log=True).svg("log"))
    (series,) = drawn["series"]
    assert drawn["log"] == [True, False]
    assert series["data"][0][:2] == pytest.approx([math.log10(0.05), math.log10(5000.0)])
    assert series["data"][1][:2] == [0.0, 64.0]


def test_gaps_begin_a_new_part() -> None:
    panel = PlotPanel()
    panel.line(np.arange(6.0), np.array([0.0, 1.0, math.nan, 1.0, 0.0, 1.0]), "#1f5fa8")
    panel.line(np.arange(3.0), np.full(3, math.nan), "#c4620a")
    paths = [
        one.get("d", "")
        for one in ElementTree.fromstring(Plot(SIZE, MARGINS, [panel]).svg("gap")).iter(
            f"{SVG}path"
        )
        if one.get("stroke") in ("#1f5fa8", "#c4620a")
    ]
    assert [path.count("M") for path in paths] == [2, 0]


@given(st.floats(-1e9, 1e9), st.floats(1e-9, 1e9), st.integers(1, 12))
def test_ticks_are_round_numbers_within_the_range(low: float, span: float, most: int) -> None:
    span = max(span, 1e-6 * abs(low))
    ticks = linear_ticks((low, low + span), most)
    at = np.array(ticks.at)
    # one multiple of a step within a span below two steps; the next step is at least 2/5 of it
    assert 2 <= at.size <= max(min(most, MOST) + 1, 5)
    assert at[0] >= low - 1e-6 * span
    assert at[-1] <= low + span * (1.0 + 1e-6)
    factor = float((ticks.factor or "1").replace("\N{MINUS SIGN}", "-"))
    shown = np.array([float(one.replace("\N{MINUS SIGN}", "-")) for one in ticks.labels])
    np.testing.assert_allclose(shown * factor, at, rtol=1e-9, atol=1e-9 * span)
    assert len(set(ticks.labels)) == at.size


def test_numbered_and_logarithmic_ticks() -> None:
    assert linear_ticks((0.4, 3.6), 16, least_step=1.0).labels == ("1", "2", "3")
    assert not linear_ticks((0.4, 40.6), 16, least_step=1.0).has_grid
    ticks = log_ticks((0.3, 2000.0))
    assert ticks.labels == ("1", "10", "100", "1000")
    assert ticks.minor[:2] == pytest.approx((0.3, 0.4))
    assert ticks.minor[-1] == pytest.approx(2000.0)
