"""Figures of a page without matplotlib: panels above each other that share one abscissa.

    Plot ──▶ `<svg>` element, shown if scripts are disabled and on paper
         ──▶ data of the chart that replaces it on the page (series_data.py)

The same data give the same bytes.
"""

from __future__ import annotations

import hashlib
import html
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from frictool.presentation.axis_ticks import AxisTicks, linear_ticks, log_ticks
from frictool.presentation.colours import GRID, INK, MUTED
from frictool.presentation.decimation import straightened_indices
from frictool.presentation.series_data import logarithm, numbers, series_data, straightened
from frictool.typing import BoolVector, Vector

PlotRange = tuple[float, float]
POINTS = 72.0  # per inch
FONT, TICK, PAD = 9.5, 3.5, 3.5  # size of texts, length of ticks, distance of their labels [point]
THIN = 0.8  # width of the axes and of the grid lines [point]
MARGIN = 0.05  # free part of a range on each side
FINEST = 0.1  # smallest visible difference [point]
FAR = 1e4  # largest coordinate [point]
DASHED, DOTTED = (4.0, 2.0), (1.0, 1.5)  # lengths of lines and gaps, in widths of the line


class FigureMargins(NamedTuple):
    """Margins around the panels, and distance of ordinate labels from the left edge [inch]."""

    left: float
    right: float
    bottom: float
    top: float
    label: float


@dataclass(frozen=True)
class Mark:
    """Curve, area or straight line of a panel.

    - kind: kind of the mark. `line`: curve. `area`: area with the outline (x, y). `horizontal`:
      line at the ordinate y[0]. `vertical`: line at the abscissa x[0]. `across`: area between two
      ordinates over the whole panel
    - x, y: abscissas and ordinates (n,); NaN leaves a gap
    - width: width of a line [point]
    - dash: lengths of lines and gaps, in widths of the line; empty for a solid line
    - order: a mark with a larger number covers marks with smaller numbers
    - label: name in the legend
    - group: name of the legend entry that shows or hides several marks together
    - detail: (abscissas, ordinates) with more samples, which are shown when a reader zooms in
    """

    kind: Literal["line", "area", "horizontal", "vertical", "across"]
    x: Vector
    y: Vector
    colour: str
    alpha: float = 1.0
    width: float = 1.4
    dash: tuple[float, ...] = ()
    order: float = 2.0
    label: str = ""
    group: str = ""
    detail: tuple[Vector, Vector] | None = None

    @property
    def is_area(self) -> bool:
        """Return True if the mark is filled."""
        return self.kind in ("area", "across")

    def as_json(self, height: float, is_log: bool) -> dict[str, Any]:
        """Return the mark in the form that explore.js reads.

        - height: range of ordinates that the panel shows, in the unit of the ordinates
        - is_log: True if the abscissa is logarithmic
        """
        data = self.detail or (self.x, self.y)
        if self.kind == "line":
            data = straightened(data, height)
        if is_log:
            data = logarithm(data[0]), data[1]
        names = self.label, self.group or self.label
        entry = series_data(self.kind, self.colour, self.alpha, names, data)
        if self.is_area:
            return entry
        dash = [round(self.width * one, 2) for one in self.dash] or None
        return entry | {"width": self.width, "dash": dash}


@dataclass
class PlotPanel:
    """Panel of a figure.

    - y_range: range of the ordinate; None for the range of the marks plus a margin
    - ratio: height relative to the other panels
    """

    y_label: str = ""
    y_range: PlotRange | None = None
    ratio: float = 1.0
    marks: list[Mark] = field(default_factory=list)

    def line(self, x: Vector, y: Vector, colour: str, **more: Any) -> None:
        """Add a curve; `more` sets further fields of its Mark."""
        self.marks.append(Mark("line", x, y, colour, **more))

    def area(self, x: Vector, y: Vector, colour: str, **more: Any) -> None:
        """Add an area with the outline (x, y)."""
        self.marks.append(Mark("area", x, y, colour, **more))

    def horizontal(self, y: float, colour: str, **more: Any) -> None:
        """Add a line at the ordinate y over the whole panel."""
        self.marks.append(Mark("horizontal", np.array([0.0, 1.0]), np.full(2, y), colour, **more))

    def vertical(self, x: float, colour: str, **more: Any) -> None:
        """Add a line at the abscissa x over the whole panel."""
        self.marks.append(Mark("vertical", np.full(2, x), np.array([0.0, 1.0]), colour, **more))

    def across(self, low: float, high: float, colour: str, **more: Any) -> None:
        """Add an area between the ordinates `low` and `high` over the whole panel."""
        x, y = np.array([0.0, 1.0, 1.0, 0.0, 0.0]), np.array([low, low, high, high, low])
        self.marks.append(Mark("across", x, y, colour, **more))


@dataclass
class Plot:
    """Figure of panels above each other.

    - size: width and height [inch]
    - space: gap between two panels, relative to their mean height
    - x_range: range of the abscissa; None for the range of the marks plus a margin
    - is_log: True for a logarithmic abscissa
    - is_numbered: True if the abscissa is a whole number, such as the number of a vertex
    """

    size: tuple[float, float]
    margins: FigureMargins
    panels: list[PlotPanel]
    space: float = 0.16
    x_label: str = ""
    x_range: PlotRange | None = None
    is_log: bool = False
    is_numbered: bool = False

    def svg(self, label: str) -> str:
        """Return the figure as an `<svg>` element.

        `label`: text that screen readers read out.
        """
        width, height = (POINTS * one for one in self.size)
        x_range = self.x_range or _range_of(self.panels, 0)
        data = html.escape(self._chart(x_range), quote=False)
        text = html.escape("".join(c for c in label if c.isprintable()))
        salt = hashlib.sha256(f"{text}{data}".encode()).hexdigest()[:10]
        lines = [
            f'<svg role="img" aria-label="{text}" viewBox="0 0 {width:g} {height:g}" '
            f'xmlns="http://www.w3.org/2000/svg" font-size="{FONT}" fill="{INK}" '
            "font-family=\"'DejaVu Sans', sans-serif\">"
            f'<metadata class="chart-data">{data}</metadata>'
        ]
        boxes = self._boxes()
        for index, (panel, box) in enumerate(zip(self.panels, boxes, strict=True)):
            drawn = _DrawnPanel(
                panel, box, x_range, panel.y_range or _range_of([panel], 1), self.is_log
            )
            is_last = index == len(boxes) - 1
            lines += drawn.svg(f"c{salt}{index}", self._x_ticks(x_range, box), is_last)
            middle = 0.5 * (box.top + box.bottom)
            at = POINTS * self.margins.label - 0.25 * FONT
            lines.append(
                f'<text text-anchor="middle" transform="translate({at:.1f} {middle:.1f}) '
                f'rotate(-90)">{html.escape(panel.y_label)}</text>'
            )
        middle = 0.5 * (boxes[-1].left + boxes[-1].right)
        below = boxes[-1].bottom + TICK + PAD + 2.25 * FONT
        lines.append(
            f'<text text-anchor="middle" x="{middle:.1f}" y="{below:.1f}">'
            f"{html.escape(self.x_label)}</text>"
        )
        return "\n".join([*lines, "</svg>"])

    def _chart(self, x_range: PlotRange) -> str:
        parts = []
        total = POINTS * self.size[1]
        for index, (panel, box) in enumerate(zip(self.panels, self._boxes(), strict=True)):
            y_range = panel.y_range or _range_of([panel], 1)
            height = abs(y_range[1] - y_range[0])
            marks = sorted(panel.marks, key=lambda one: one.order)
            parts.append(
                {
                    "x": self.x_label if index == len(self.panels) - 1 else "",
                    "y": panel.y_label,
                    "xlim": numbers(x_range),
                    "ylim": numbers(y_range),
                    "log": [self.is_log, False],
                    "ticks": None,
                    "height": round((box.bottom - box.top) / total, 4),
                    "series": [one.as_json(height, self.is_log) for one in marks],
                }
            )
        return json.dumps(parts, separators=(",", ":"), ensure_ascii=False)

    def _boxes(self) -> list[PanelBox]:
        (width, height), margins = self.size, self.margins
        count = len(self.panels)
        mean = (height - margins.bottom - margins.top) / (count + self.space * (count - 1))
        ratios = [panel.ratio for panel in self.panels]
        top = margins.top
        boxes = []
        for ratio in ratios:
            bottom = top + mean * count * ratio / sum(ratios)
            corners = margins.left, width - margins.right, top, bottom
            boxes.append(PanelBox(*(POINTS * one for one in corners)))
            top = bottom + self.space * mean
        return boxes

    def _x_ticks(self, x_range: PlotRange, box: PanelBox) -> AxisTicks:
        if self.is_log:
            return log_ticks(x_range)
        if self.is_numbered:
            return linear_ticks(x_range, 16, least_step=1.0)
        return linear_ticks(x_range, int((box.right - box.left) / (3.0 * FONT)))


class PanelBox(NamedTuple):
    """Edges of a panel [point], from the top left corner of the figure."""

    left: float
    right: float
    top: float
    bottom: float


class _DrawnPanel(NamedTuple):
    panel: PlotPanel
    box: PanelBox
    x_range: PlotRange
    y_range: PlotRange
    is_log: bool

    def svg(self, clip: str, x_ticks: AxisTicks, labels_abscissa: bool) -> Iterator[str]:
        left, right, top, bottom = self.box
        yield (
            f'<clipPath id="{clip}"><rect x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" '
            f'height="{bottom - top:.1f}"/></clipPath>'
        )
        y_ticks = linear_ticks(self.y_range, int((bottom - top) / (2.0 * FONT)))
        x_at, y_at = self._x(np.array(x_ticks.at)), self._y(np.array(y_ticks.at))
        short = self._x(np.array(x_ticks.minor))
        grid = [f"M{left:.1f} {y:.1f}H{right:.1f}" for y in y_at]
        if x_ticks.has_grid:
            grid += [f"M{x:.1f} {top:.1f}V{bottom:.1f}" for x in x_at]
        ticks = [f"M{left:.1f} {y:.1f}h{-TICK}" for y in y_at]
        ticks += [f"M{x:.1f} {bottom:.1f}v{TICK}" for x in x_at]
        ticks += [f"M{x:.1f} {bottom:.1f}v{0.6 * TICK:.1f}" for x in short]
        yield f'<path fill="none" stroke="{GRID}" stroke-width="{THIN}" d="{"".join(grid)}"/>'
        yield f'<g clip-path="url(#{clip})" stroke-linejoin="round">'
        for mark in sorted(self.panel.marks, key=lambda one: one.order):
            yield self._mark(mark)
        yield "</g>"
        axes = f"M{left:.1f} {top:.1f}V{bottom:.1f}H{right:.1f}"
        yield (
            f'<path fill="none" stroke="{MUTED}" stroke-width="{THIN}" d="{axes}{"".join(ticks)}"/>'
        )
        label_x = left - TICK - PAD
        yield '<g text-anchor="end">'
        for y, text in zip(y_at, y_ticks.labels, strict=True):
            yield f'<text x="{label_x:.1f}" y="{y + 0.38 * FONT:.1f}">{text}</text>'
        yield "</g>"
        if y_ticks.factor:
            yield f'<text x="{left:.1f}" y="{top - 3.0:.1f}">{y_ticks.factor}</text>'
        if labels_abscissa:
            below = bottom + TICK + PAD + 0.76 * FONT
            yield '<g text-anchor="middle">'
            for x, text in zip(x_at, x_ticks.labels, strict=True):
                yield f'<text x="{x:.1f}" y="{below:.1f}">{text}</text>'
            yield "</g>"
            if x_ticks.factor:
                below += 1.49 * FONT
                yield (
                    f'<text text-anchor="end" x="{right:.1f}" y="{below:.1f}">{x_ticks.factor}'
                    "</text>"
                )

    def _mark(self, mark: Mark) -> str:
        left, right, top, bottom = self.box
        style = f'fill="none" stroke="{mark.colour}" stroke-width="{mark.width:g}"'
        if mark.is_area:
            style = f'fill="{mark.colour}"'
        if mark.dash:
            dash = " ".join(f"{mark.width * one:g}" for one in mark.dash)
            style += f' stroke-dasharray="{dash}"'
        if mark.alpha < 1.0:
            style += f' opacity="{mark.alpha:g}"'
        if mark.kind == "line":
            path = _path(*self._visible(self._x(mark.x), self._y(mark.y)))
        elif mark.kind == "area":
            path = _path(self._x(mark.x), self._y(mark.y), "Z")
        elif mark.kind == "vertical":
            path = f"M{self._x(mark.x)[0]:.1f} {top:.1f}V{bottom:.1f}"
        elif mark.kind == "horizontal":
            path = f"M{left:.1f} {self._y(mark.y)[0]:.1f}H{right:.1f}"
        else:
            y = self._y(mark.y)
            path = f"M{left:.1f} {y.min():.1f}H{right:.1f}V{y.max():.1f}H{left:.1f}Z"
        return f'<path {style} d="{path}"/>'

    def _visible(self, x: Vector, y: Vector) -> tuple[Vector, Vector]:
        if not np.all(np.diff(x) >= 0.0):
            return x, y
        kept = straightened_indices(x, y, FINEST)
        return x[kept], y[kept]

    def _x(self, values: Vector) -> Vector:
        low, high = self.x_range
        if self.is_log:
            values, low, high = np.log10(values), math.log10(low), math.log10(high)
        left, right = self.box.left, self.box.right
        return np.clip(left + (values - low) * ((right - left) / (high - low)), -FAR, FAR)

    def _y(self, values: Vector) -> Vector:
        (low, high), bottom = self.y_range, self.box.bottom
        scale = (bottom - self.box.top) / (high - low)
        return np.clip(bottom - (values - low) * scale, -FAR, FAR)


def _path(x: Vector, y: Vector, end: str = "") -> str:
    tenths = np.rint(10.0 * np.stack((x, y), axis=1))
    valid: BoolVector = np.isfinite(tenths[:, 0] + tenths[:, 1])
    moved = np.append(True, np.any(tenths[1:] != tenths[:-1], axis=1))
    kept = valid & moved
    begins = np.append(True, ~valid[:-1])[kept]
    points = (tenths[kept] / 10.0).tolist()
    path = "".join(
        f"{'M' if is_first else 'L'}{a:g} {b:g}"
        for is_first, (a, b) in zip(begins.tolist(), points, strict=True)
    )
    return path + end


def _range_of(panels: Sequence[PlotPanel], axis: int) -> PlotRange:
    curves = ("line", "area") if axis == 0 else ("line", "area", "across")
    straight = ("vertical", "horizontal")[axis]
    marks = [(mark.kind, (mark.x, mark.y)[axis]) for panel in panels for mark in panel.marks]
    low, high = _with_margin([values for kind, values in marks if kind in curves])
    beyond = [v for kind, v in marks if kind == straight and not low <= v[0] <= high]
    if not beyond:
        return low, high
    return _with_margin([v for kind, v in marks if kind in curves] + beyond)


def _with_margin(parts: Sequence[Vector]) -> PlotRange:
    finite = [one[np.isfinite(one)] for one in parts]
    ends = [end for one in finite if one.size for end in (float(one.min()), float(one.max()))]
    low, high = min(ends, default=0.0), max(ends, default=1.0)
    if high - low <= 1e-15 * max(abs(low), abs(high)):
        spread = MARGIN * max(abs(low), abs(high)) or MARGIN
        low, high = low - spread, high + spread
    margin = MARGIN * (high - low)
    return low - margin, high + margin
