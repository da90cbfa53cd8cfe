"""Data for the charts of a page, read from the figures that matplotlib drew.

explore.js draws these data with uPlot in place of the `<svg>` element. The chart shows the curves
of the figure.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cbook import STEP_LOOKUP_MAP
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.ticker import FixedLocator

from frictool.presentation.series_data import logarithm, numbers, series_data, straightened
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCALES = {"linear", "log"}
DETAIL = "frictool_detail"  # attribute of a line: (abscissa, ordinate) with more samples


def with_detail(line: Line2D, abscissa: Vector, ordinate: Vector) -> None:
    """Attach samples (n,) to a line; the chart shows them when a reader zooms in."""
    setattr(line, DETAIL, (abscissa, ordinate))


def chart_json(figure: Figure) -> str | None:
    """Return the data of a figure as JSON; None if a part of the figure cannot be in a chart."""
    panels = []
    for axes in figure.axes:
        panel = _panel(axes)
        if panel is None:
            return None
        panels.append(panel)
    return json.dumps(panels, separators=(",", ":"), ensure_ascii=False)


def _panel(axes: Axes) -> dict[str, Any] | None:
    if {axes.get_xscale(), axes.get_yscale()} - SCALES or axes.images or axes.texts:
        return None
    series = []
    for artist in sorted(
        (*axes.lines, *axes.patches, *axes.collections), key=lambda one: one.get_zorder()
    ):
        part = _series(axes, artist)
        if part is None:
            return None
        series.append(part)
    ticks = None
    if isinstance(axes.yaxis.get_major_locator(), FixedLocator):
        ticks = [
            [float(at) for at in axes.get_yticks()],
            [label.get_text() for label in axes.get_yticklabels()],
        ]
    box = axes.get_position()
    return {
        "x": axes.get_xlabel(),
        "y": axes.get_ylabel().replace("\n", " "),
        "xlim": numbers(axes.get_xlim()),
        "ylim": numbers(axes.get_ylim()),
        "log": [axes.get_xscale() == "log", axes.get_yscale() == "log"],
        "ticks": ticks,
        "height": round(float(box.height), 4),
        "series": series,
    }


def _series(axes: Axes, artist: Artist) -> dict[str, Any] | None:
    data: tuple[Vector, Vector]
    if isinstance(artist, Line2D):
        along = _in_data(axes, artist)
        if not any(along):
            return None
        data = getattr(artist, DETAIL, None) or (
            np.asarray(artist.get_xdata(), dtype=np.float64),
            np.asarray(artist.get_ydata(), dtype=np.float64),
        )
        data = tuple(STEP_LOOKUP_MAP[artist.get_drawstyle()](*data))
        drawn = artist.get_linestyle() not in ("None", "", " ")
        kind = "line" if drawn else "points"
        if not all(along):
            kind = "vertical" if along[0] else "horizontal"
        if kind == "line" and drawn:
            is_linear = axes.get_yscale() == "linear"
            data = straightened(data, abs(np.ptp(axes.get_ylim())) if is_linear else 0.0)
        pattern: Any = getattr(artist, "_dash_pattern", (0.0, None))
        dashes = pattern[1] if drawn else None
        return _entry(axes, artist, (kind, to_hex(artist.get_color())), data) | {
            "width": float(artist.get_linewidth() if drawn else artist.get_markersize()),
            "dash": None if dashes is None else [round(float(one), 2) for one in dashes],
        }
    if isinstance(artist, PathPatch):
        return _path(axes, artist)
    if isinstance(artist, Patch):
        along = _in_data(axes, artist)
        corners = artist.get_patch_transform().transform(artist.get_path().vertices)
        kind = "area" if all(along) else "across" if along[1] else "along"
        colour = to_hex(artist.get_facecolor())
        return _entry(axes, artist, (kind, colour), (corners[:, 0], corners[:, 1])) | {
            "alpha": to_rgba(artist.get_facecolor())[3]
        }
    if isinstance(artist, PolyCollection):
        outlines = [path.vertices for path in artist.get_paths()]
        points = np.concatenate([np.vstack([one, [[np.nan, np.nan]]]) for one in outlines])
        face = np.atleast_2d(artist.get_facecolor())[0]
        return _entry(axes, artist, ("area", to_hex(face)), (points[:, 0], points[:, 1])) | {
            "alpha": float(face[3])
        }
    if isinstance(artist, LineCollection):
        segments = [np.vstack([one, [[np.nan, np.nan]]]) for one in artist.get_segments()]
        points = np.concatenate(segments) if segments else np.empty((0, 2))
        edge = np.atleast_2d(artist.get_edgecolor())[0]
        return _entry(axes, artist, ("line", to_hex(edge)), (points[:, 0], points[:, 1])) | {
            "width": float(np.atleast_1d(artist.get_linewidth())[0]),
            "alpha": float(edge[3]),
        }
    return None


def _path(axes: Axes, artist: PathPatch) -> dict[str, Any] | None:
    path = artist.get_path()
    vertices = np.asarray(path.vertices, dtype=np.float64)
    starts = np.flatnonzero(path.codes == Path.MOVETO)
    if artist.get_fill():
        face = artist.get_facecolor()
        points = np.insert(vertices, starts, np.nan, axis=0)
        return _entry(axes, artist, ("area", to_hex(face)), (points[:, 0], points[:, 1])) | {
            "alpha": to_rgba(face)[3]
        }
    if 2 * starts.size != len(vertices) or np.any(vertices[starts] != vertices[starts + 1]):
        return None
    look = "points", to_hex(artist.get_edgecolor())
    return _entry(axes, artist, look, (vertices[starts, 0], vertices[starts, 1])) | {
        "width": float(artist.get_linewidth())
    }


def _in_data(axes: Axes, artist: Artist) -> tuple[bool, bool]:
    along: Any = artist.get_transform().contains_branch_seperately(axes.transData)
    return bool(along[0]), bool(along[1])


def _entry(
    axes: Axes, artist: Artist, look: tuple[str, str], data: tuple[Vector, Vector]
) -> dict[str, Any]:
    label = str(artist.get_label())
    alpha = artist.get_alpha()
    names = label, str(artist.get_gid() or label)
    stored = (
        logarithm(data[0]) if axes.get_xscale() == "log" else data[0],
        logarithm(data[1]) if axes.get_yscale() == "log" else data[1],
    )
    return series_data(*look, 1.0 if alpha is None else float(alpha), names, stored)
