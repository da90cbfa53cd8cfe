"""Data of the charts: what matplotlib drew, to the precision that is stored."""

from __future__ import annotations

import base64
import json
import math
import re
from html import unescape
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from frictool.presentation.chart_data import chart_json, with_detail
from frictool.presentation.decimation import drawn_indices, straightened_indices
from frictool.presentation.series_data import STEPS
from frictool.presentation.svg import drawing, render
from frictool.typing import Vector


def unpacked(packed: list[Any]) -> Vector:
    """As explore.js reads a signal."""
    low, high, text = packed
    steps = np.frombuffer(base64.b64decode(text), dtype="<u2").astype(np.float64)
    return np.where(steps > STEPS, np.nan, low + steps * ((high - low) or 1.0) / STEPS)


def panels(figure: Figure) -> list[dict[str, Any]]:
    text = chart_json(figure)
    assert text is not None
    value: list[dict[str, Any]] = json.loads(text)
    return value


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-1e6, 1e6) | st.just(float("nan")), min_size=1, max_size=50))
def test_points_are_stored_to_one_step(values: list[float]) -> None:
    axes = (figure := Figure()).subplots()
    axes.plot(np.arange(len(values)), values, "x")
    (series,) = panels(figure)[0]["series"]
    known = np.array(values)[np.isfinite(values)]
    reach = float(np.ptp(known)) / STEPS if known.size else 0.0
    assert series["kind"] == "points"
    assert unpacked(series["data"][1]) == pytest.approx(
        np.array(values), abs=reach + 1e-9, nan_ok=True
    )


def test_lines_areas_and_bars_are_stored_and_a_map_is_not() -> None:
    axes = (figure := Figure()).subplots()
    axes.plot([0.0, 1.0], [2.0, 3.0], label="curve", color="#1f5fa8", linestyle=(0, (4, 2)))
    axes.axhline(2.5)
    axes.axvline(0.5)
    axes.axhspan(2.0, 2.2)
    axes.fill_between([0.0, 1.0], [2.0, 2.0], [3.0, 3.0], alpha=0.2, label="_band")
    axes.vlines([0.2, 0.4], 2.0, 3.0)
    axes.bar([0.1], [2.5])
    axes.set(xlabel="time [s]", ylabel="position\n[rad]")
    (panel,) = panels(figure)
    kinds = sorted(one["kind"] for one in panel["series"])
    assert kinds == ["across", "area", "area", "horizontal", "line", "line", "vertical"]
    assert (panel["x"], panel["y"]) == ("time [s]", "position [rad]")
    curve = next(one for one in panel["series"] if one["label"] == "curve")
    assert (curve["colour"], curve["dash"] is None) == ("#1f5fa8", False)
    assert {one["label"] for one in panel["series"]} == {"", "curve"}
    figure.subplots().contourf([[0.0, 1.0], [1.0, 2.0]])
    assert chart_json(figure) is None


def test_named_ticks_are_stored_with_their_names() -> None:
    axes = (figure := Figure()).subplots()
    axes.plot([1.0, 2.0], [0.0, 1.0])
    axes.set_yticks([0.0, 1.0], ["inertia", "viscous"])
    axes.set_ylim(1.5, -0.5)
    (panel,) = panels(figure)
    assert panel["ticks"] == [[0.0, 1.0], ["inertia", "viscous"]]
    assert panel["ylim"] == [1.5, -0.5]


def test_a_chart_has_the_detail_that_paper_has_not() -> None:
    time = np.arange(4000.0)
    noise = np.sin(time**2)
    axes = (figure := Figure()).subplots()
    (line,) = axes.plot(time[::100], noise[::100])
    with_detail(line, time, noise)
    (series,) = panels(figure)[0]["series"]
    assert unpacked(series["data"][0]).size > 3500


@given(st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=60), st.floats(0.0, 3.0))
def test_a_straightened_curve_is_within_its_tolerance(
    values: list[float], tolerance: float
) -> None:
    time, curve = np.arange(float(len(values))), np.array(values)
    kept = straightened_indices(time, curve, tolerance)
    assert kept[0] == 0
    assert kept[-1] == time.size - 1
    left = np.abs(np.interp(time, time[kept], curve[kept]) - curve)
    assert float(left.max()) <= tolerance + 1e-9


def test_a_gap_stays_a_gap_and_a_straight_part_needs_two_points() -> None:
    time = np.arange(100.0)
    curve = np.where(time < 50.0, 1.0, 2.0)
    curve[70] = np.nan
    kept = drawn_indices(time, curve)
    assert {0, 49, 50, 69, 70, 71, 99} <= set(kept.tolist())
    assert kept.size < 12


def test_a_label_cannot_end_the_data() -> None:
    hostile = "</metadata><script>alert(1)</script>&amp;"
    with drawing("test"):
        axes = (figure := Figure()).subplots()
        axes.plot([0.0, 1.0], [2.0, 3.0], label=hostile)
        text = render(figure, "a")
    (data,) = re.findall(r'<metadata class="chart-data">(.*?)</metadata>', text, re.DOTALL)
    assert "<script" not in text
    assert json.loads(unescape(data))[0]["series"][0]["label"] == hostile


def test_a_logarithmic_axis_keeps_its_smallest_values() -> None:
    """Values over five decades are stored to the same relative error; 0 is a gap."""
    axes = (figure := Figure()).subplots()
    frequency = np.geomspace(0.05, 5000.0, 400)
    axes.plot(np.concatenate([[0.0], frequency]), np.arange(401.0) % 7, "x")
    axes.set_xscale("log")
    (series,) = panels(figure)[0]["series"]
    stored = 10.0 ** unpacked(series["data"][0])
    assert np.isnan(stored[0])
    assert stored[1:] == pytest.approx(frequency, rel=math.log(1e5) / STEPS)


def test_a_step_is_stored_as_it_is_drawn() -> None:
    axes = (figure := Figure()).subplots()
    axes.step([0.0, 1.0, 2.0], [0.0, 1.0, 3.0], where="post")
    (series,) = panels(figure)[0]["series"]
    x, y = (unpacked(one) for one in series["data"])
    assert x == pytest.approx([0.0, 1.0, 1.0, 2.0, 2.0], abs=1e-4)
    assert y == pytest.approx([0.0, 0.0, 1.0, 1.0, 3.0], abs=1e-4)


def test_paths_are_stored_as_points_or_areas() -> None:
    """Segments without length are points, filled outlines are areas, other paths are no chart."""
    dots = Path([(0.0, 0.0), (0.0, 0.0), (1.0, 2.0), (1.0, 2.0)], [1, 2, 1, 2])
    box = Path([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0)] * 2, [1, 2, 2, 79] * 2)
    axes = (figure := Figure()).subplots()
    axes.add_patch(PathPatch(dots, fill=False, edgecolor="#b3261e", linewidth=3.0))
    axes.add_patch(PathPatch(box, facecolor="#1f5fa8"))
    points, area = panels(figure)[0]["series"]
    assert (points["kind"], points["colour"], points["width"]) == ("points", "#b3261e", 3.0)
    assert unpacked(points["data"][1]) == pytest.approx([0.0, 2.0])
    assert (area["kind"], area["colour"]) == ("area", "#1f5fa8")
    assert np.flatnonzero(np.isnan(unpacked(area["data"][0]))).tolist() == [0, 5]
    axes.add_patch(PathPatch(Path([(0.0, 0.0), (1.0, 1.0)]), fill=False))
    assert chart_json(figure) is None
