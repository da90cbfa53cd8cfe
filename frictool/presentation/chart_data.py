"""Data of a drawn figure for the charts of a page, read from the figure itself.

explore.js draws these data with uPlot in place of the `<svg>` element. The data are read from the
figure that matplotlib drew, so that chart and `<svg>` element show the same. A number is stored as
16 bits: its error is at most 1/130000 of the range of its curve.
"""

from __future__ import annotations

import base64
import json
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.ticker import FixedLocator

from frictool.presentation.decimation import straightened_indices
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEVELS = 8000  # smallest visible difference of a chart, relative to the height of the panel
STEPS = 65534  # steps of a stored number; the next number stands for a gap
SCALES = {"linear", "log"}
DETAIL = "frictool_detail"  # attribute of a line: (abscissa, ordinate) with more samples


def with_detail(line: Line2D, abscissa: Vector, ordinate: Vector) -> None:
    """Give a line the samples (n,) that a chart shows when a reader zooms in."""
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
        "xlim": _numbers(axes.get_xlim()),
        "ylim": _numbers(axes.get_ylim()),
        "log": [axes.get_xscale() == "log", axes.get_yscale() == "log"],
        "ticks": ticks,
        "height": round(float(box.height), 4),
        "series": series,
    }


def _numbers(values: Any) -> list[float]:
    return [float(f"{value:.9g}") for value in values]


def _series(axes: Axes, artist: Artist) -> dict[str, Any] | None:
    """Return one curve, set of points, area or straight line; None if a chart cannot show it."""
    data: tuple[Vector, Vector]
    if isinstance(artist, Line2D):
        along = _in_data(axes, artist)
        if not any(along):
            return None
        data = getattr(artist, DETAIL, None) or (
            np.asarray(artist.get_xdata(), dtype=np.float64),
            np.asarray(artist.get_ydata(), dtype=np.float64),
        )
        drawn = artist.get_linestyle() not in ("None", "", " ")
        kind = "line" if drawn else "points"
        if not all(along):
            kind = "vertical" if along[0] else "horizontal"
        if kind == "line" and drawn and np.all(np.diff(data[0]) >= 0.0):
            tolerance = 0.0
            if axes.get_yscale() == "linear":
                tolerance = abs(axes.get_ylim()[1] - axes.get_ylim()[0]) / LEVELS
            kept = straightened_indices(data[0], data[1], tolerance)
            data = (data[0][kept], data[1][kept])
        pattern: Any = getattr(artist, "_dash_pattern", (0.0, None))
        dashes = pattern[1] if drawn else None
        return _entry(artist, kind, to_hex(artist.get_color()), data) | {
            "width": float(artist.get_linewidth() if drawn else artist.get_markersize()),
            "dash": None if dashes is None else [round(float(one), 2) for one in dashes],
        }
    if isinstance(artist, Patch) and not isinstance(artist, PathPatch):
        along = _in_data(axes, artist)
        corners = artist.get_patch_transform().transform(artist.get_path().vertices)
        kind = "area" if all(along) else "across" if along[1] else "along"
        colour = to_hex(artist.get_facecolor())
        return _entry(artist, kind, colour, (corners[:, 0], corners[:, 1])) | {
            "alpha": to_rgba(artist.get_facecolor())[3]
        }
    if isinstance(artist, PolyCollection):
        outlines = [path.vertices for path in artist.get_paths()]
        points = np.concatenate([np.vstack([one, [[np.nan, np.nan]]]) for one in outlines])
        face = np.atleast_2d(artist.get_facecolor())[0]
        return _entry(artist, "area", to_hex(face), (points[:, 0], points[:, 1])) | {
            "alpha": float(face[3])
        }
    if isinstance(artist, LineCollection):
        segments = [np.vstack([one, [[np.nan, np.nan]]]) for one in artist.get_segments()]
        points = np.concatenate(segments) if segments else np.empty((0, 2))
        edge = np.atleast_2d(artist.get_edgecolor())[0]
        return _entry(artist, "line", to_hex(edge), (points[:, 0], points[:, 1])) | {
            "width": float(np.atleast_1d(artist.get_linewidth())[0]),
            "alpha": float(edge[3]),
        }
    return None


def _in_data(axes: Axes, artist: Artist) -> tuple[bool, bool]:
    """Return (abscissa, ordinate): True if the artist gives the coordinate in units of the data."""
    along: Any = artist.get_transform().contains_branch_seperately(axes.transData)
    return bool(along[0]), bool(along[1])


def _entry(artist: Artist, kind: str, colour: str, data: tuple[Vector, Vector]) -> dict[str, Any]:
    label = str(artist.get_label())
    group = artist.get_gid() or label
    alpha = artist.get_alpha()
    return {
        "label": "" if label.startswith("_") else label,
        "group": "" if group.startswith("_") else group,
        "kind": kind,
        "colour": colour,
        "alpha": 1.0 if alpha is None else float(alpha),
        "data": [_packed(values) for values in data],
    }


def _packed(values: Vector) -> list[Any]:
    """Return [lowest, highest, base64 of 16-bit numbers] of a signal (n,)."""
    finite = np.isfinite(values)
    if not finite.any():
        return [
            0.0,
            0.0,
            base64.b64encode(np.full(values.size, STEPS + 1, "<u2").tobytes()).decode(),
        ]
    low, high = float(values[finite].min()), float(values[finite].max())
    span = high - low or 1.0
    steps = np.full(values.size, STEPS + 1, dtype="<u2")
    steps[finite] = np.rint((values[finite] - low) / span * STEPS)
    return [low, high, base64.b64encode(steps.tobytes()).decode()]
