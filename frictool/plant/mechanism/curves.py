"""Curves of a mechanism.yaml: piecewise cubics through the points, constant outside their range.

Between two points a curve stays between the values at these points (Fritsch and Butland, SIAM J.
Sci. Stat. Comput. 5, 1984): the slope at a point is a weighted harmonic mean of the adjacent
secants. At the first and last point the slope follows from the three-point formula, limited to 0 to
3 times the adjacent secant.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from frictool.plant.mechanism.packed_mechanism import Curves
from frictool.typing import Vector

PRODUCT_ERROR = 1e-7  # error of a curve that replaces a function, relative to its largest value
MOST_HALVINGS = 14  # largest number of successive halvings of a piece
INSIDE = np.linspace(0.0, 1.0, 9)[1:-1]  # where the error of a piece is computed


@dataclass(frozen=True)
class PiecewiseCubic:
    """One curve of k pieces: breaks (k + 1,), and coefficients (k, 4), lowest power first.

    The variable of a piece is the distance from the break at its left end.
    """

    breaks: Vector
    cubic: Vector

    def value(self, x: Vector) -> Vector:
        """Return the curve's values at positions x (of any shape); constant outside its range."""
        return self._at(x)[0]

    def slope(self, x: Vector) -> Vector:
        """Return the derivative of the curve at positions x; 0 outside its range."""
        value = self._at(x)[1]
        return np.where(
            (np.asarray(x) < self.breaks[0]) | (np.asarray(x) > self.breaks[-1]), 0.0, value
        )

    def _at(self, x: Vector) -> tuple[Vector, Vector]:
        clamped = np.clip(np.asarray(x, dtype=np.float64), self.breaks[0], self.breaks[-1])
        piece = np.clip(
            np.searchsorted(self.breaks, clamped, side="right") - 1, 0, len(self.cubic) - 1
        )
        offset = clamped - self.breaks[piece]
        c0, c1, c2, c3 = (self.cubic[piece, power] for power in range(4))
        return ((c3 * offset + c2) * offset + c1) * offset + c0, (
            3.0 * c3 * offset + 2.0 * c2
        ) * offset + c1


def monotone_cubic(positions: Sequence[float], values: Sequence[float]) -> PiecewiseCubic:
    """Return the curve through two or more points with increasing positions."""
    x, y = np.asarray(positions, dtype=np.float64), np.asarray(values, dtype=np.float64)
    return _hermite(x, y, _slopes(x, y))


def _slopes(x: Vector, y: Vector) -> Vector:
    step = np.diff(x)
    secant = np.diff(y) / step
    if len(x) == 2:
        return np.array([secant[0], secant[0]])
    slope = np.zeros(len(x))
    rising = secant[:-1] * secant[1:] > 0.0
    before = 2.0 * step[1:] + step[:-1]
    after = step[1:] + 2.0 * step[:-1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mean = (before + after) / (before / secant[:-1] + after / secant[1:])
    slope[1:-1] = np.where(rising, mean, 0.0)
    slope[0] = _end_slope(step[0], step[1], secant[0], secant[1])
    slope[-1] = _end_slope(step[-1], step[-2], secant[-1], secant[-2])
    return slope


def _end_slope(step: float, next_step: float, secant: float, next_secant: float) -> float:
    slope = ((2.0 * step + next_step) * secant - step * next_secant) / (step + next_step)
    if slope * secant <= 0.0:
        return 0.0
    if secant * next_secant < 0.0 and abs(slope) > 3.0 * abs(secant):
        return 3.0 * secant
    return float(slope)


def _hermite(x: Vector, y: Vector, slope: Vector) -> PiecewiseCubic:
    step = np.diff(x)
    secant = np.diff(y) / step
    left, right = slope[:-1], slope[1:]
    cubic = np.column_stack(
        [
            y[:-1],
            left,
            (3.0 * secant - 2.0 * left - right) / step,
            (left + right - 2.0 * secant) / step**2,
        ]
    )
    return PiecewiseCubic(x, cubic)


def fitted(
    value: Callable[[Vector], Vector], slope: Callable[[Vector], Vector], breaks: Vector
) -> PiecewiseCubic:
    """Return a piecewise cubic that approximates a function that is smooth between `breaks`.

    Pieces are halved, at most MOST_HALVINGS times, until their error is below PRODUCT_ERROR times
    the largest value. The slope is allowed to jump at a break, because `slope` is evaluated just
    inside each piece.
    """
    pieces: list[tuple[float, float, Vector]] = []
    largest = float(np.max(np.abs(value(np.linspace(breaks[0], breaks[-1], 1001))))) or 1.0

    def add(low: float, high: float, depth: int) -> None:
        inset = 1e-9 * (high - low)
        ends = value(np.array([low, high]))
        slopes = slope(np.array([low + inset, high - inset]))
        piece = _hermite(np.array([low, high]), ends, slopes)
        inside = low + INSIDE * (high - low)
        if (
            depth < MOST_HALVINGS
            and np.max(np.abs(piece.value(inside) - value(inside))) > PRODUCT_ERROR * largest
        ):
            middle = 0.5 * (low + high)
            add(low, middle, depth + 1)
            add(middle, high, depth + 1)
        else:
            pieces.append((low, high, piece.cubic[0]))

    for low, high in itertools.pairwise(breaks):
        add(float(low), float(high), 0)
    return PiecewiseCubic(
        np.array([pieces[0][0], *(high for _, high, _ in pieces)]),
        np.array([cubic for _, _, cubic in pieces]),
    )


def cam_push(force: PiecewiseCubic, angle: PiecewiseCubic) -> PiecewiseCubic:
    """Return force tan(angle), the effort of a cam's spring on the block (thesis 2.23)."""
    if not np.any(angle.cubic):  # a flat profile: no effort
        return PiecewiseCubic(angle.breaks[[0, -1]], np.zeros((1, 4)))
    return _pushed(
        force.breaks.tobytes(), force.cubic.tobytes(), angle.breaks.tobytes(), angle.cubic.tobytes()
    )


@functools.lru_cache(maxsize=8)
def _pushed(*numbers: bytes) -> PiecewiseCubic:
    breaks_of, cubic_of, breaks_at, cubic_at = (np.frombuffer(one) for one in numbers)
    force = PiecewiseCubic(breaks_of, cubic_of.reshape(-1, 4))
    angle = PiecewiseCubic(breaks_at, cubic_at.reshape(-1, 4))
    breaks = np.unique(np.concatenate([force.breaks, angle.breaks]))

    def value(x: Vector) -> Vector:
        return np.asarray(force.value(x) * np.tan(angle.value(x)))

    def slope(x: Vector) -> Vector:
        steep = np.tan(angle.value(x))
        return np.asarray(
            force.slope(x) * steep + force.value(x) * (1.0 + steep**2) * angle.slope(x)
        )

    return fitted(value, slope, breaks)


class CurveList:
    """List of curves, to be packed into arrays for kernels."""

    def __init__(self) -> None:
        self._curves: list[PiecewiseCubic] = []

    def add(self, curve: PiecewiseCubic) -> int:
        """Add a curve and return its index."""
        self._curves.append(curve)
        return len(self._curves) - 1

    def packed(self) -> Curves:
        """Return all curves as arrays for kernels."""
        start = np.cumsum([0, *(len(curve.cubic) for curve in self._curves)]).astype(np.int64)
        breaks = (
            np.concatenate([curve.breaks for curve in self._curves])
            if self._curves
            else np.empty(0)
        )
        cubic = (
            np.concatenate([curve.cubic for curve in self._curves])
            if self._curves
            else np.empty((0, 4))
        )
        return Curves(start, breaks, np.ascontiguousarray(cubic))


def _piece(curves: Curves, curve: int, x: float) -> tuple[int, float, bool]:
    first = int(curves.start[curve])
    last = int(curves.start[curve + 1])
    breaks = curves.breaks[first + curve : last + curve + 1]
    clamped = float(np.clip(x, breaks[0], breaks[-1]))
    piece = int(np.clip(np.searchsorted(breaks, clamped, side="right") - 1, 0, last - first - 1))
    return first + piece, clamped - float(breaks[piece]), bool(clamped == x)


def curve_value(curves: Curves, curve: int, x: float) -> float:
    """Return the value at x of the packed curve with the index `curve`."""
    piece, offset, _ = _piece(curves, curve, x)
    c0, c1, c2, c3 = curves.cubic[piece].tolist()
    return float(((c3 * offset + c2) * offset + c1) * offset + c0)


def curve_slope(curves: Curves, curve: int, x: float) -> float:
    """Return the derivative at x of the packed curve with index `curve`; 0 outside its range."""
    piece, offset, within = _piece(curves, curve, x)
    _, c1, c2, c3 = curves.cubic[piece].tolist()
    return float((3.0 * c3 * offset + 2.0 * c2) * offset + c1) if within else 0.0
