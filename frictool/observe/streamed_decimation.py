"""Signals thinned for a picture while they pass: their lowest and highest values in columns that
grow wider as the log grows longer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.observe.motion_block import Vector

Matrix = NDArray[np.float64]
MOST = 1200  # columns, about two per printed point of width; there are never twice as many


class DecimatedTrace:
    """Of `count` signals. A column holds `per` samples that follow one another, across a gap too;
    of the last one only `held` are there."""

    def __init__(self, count: int) -> None:
        self._time = np.empty(0)
        self._low, self._high = np.empty((count, 0)), np.empty((count, 0))
        self._per, self._held = 1, 1

    def take(self, time: Vector, values: Matrix) -> None:
        """time (n,) in s, values (count, n) that follow those before."""
        missing = min(self._per - self._held, time.size)
        if missing:
            self._low[:, -1] = np.minimum(self._low[:, -1], values[:, :missing].min(axis=1))
            self._high[:, -1] = np.maximum(self._high[:, -1], values[:, :missing].max(axis=1))
            self._held += missing
        starts = np.arange(missing, time.size, self._per)
        if starts.size:
            self._time = np.append(self._time, time[starts])
            self._low = np.column_stack([self._low, np.minimum.reduceat(values, starts, axis=1)])
            self._high = np.column_stack([self._high, np.maximum.reduceat(values, starts, axis=1)])
            self._held = time.size - int(starts[-1])
        while self._time.size >= 2 * MOST:
            self._halve()

    def _halve(self) -> None:
        """Two columns become one; a last one without a neighbour is one of which half is there."""
        starts = np.arange(0, self._time.size, 2)
        self._held += self._per * (self._time.size % 2 == 0)
        self._time = self._time[starts]
        self._low = np.minimum.reduceat(self._low, starts, axis=1)
        self._high = np.maximum.reduceat(self._high, starts, axis=1)
        self._per *= 2

    def drawn(self) -> tuple[Vector, Matrix, Matrix]:
        """Times (c,) at which the columns begin, lowest and highest values (count, c) in each."""
        return self._time, self._low, self._high


def zigzag(time: Vector, low: Vector, high: Vector) -> tuple[Vector, Vector]:
    """A line through the lowest and the highest value of each column (c,): (2 c,) each; (c,) where
    they are the same throughout."""
    if np.array_equal(low, high):
        return time, low
    return np.repeat(time, 2), np.column_stack([low, high]).ravel()
