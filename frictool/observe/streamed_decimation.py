"""Reduction of signals to minimum and maximum per plot column, while a log is read.

A column of the plot is a time interval; the columns become wider as the log grows.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import Matrix, Vector

MOST = 1200  # smallest number of columns of a long plot; at most twice as many are in memory


class DecimatedTrace:
    """Minimum and maximum of `count` signals in each column of a plot.

    Each column contains the same number of consecutive samples, also across gaps. The last column
    may contain fewer samples.
    """

    def __init__(self, count: int) -> None:
        self._time = np.empty(0)
        self._low, self._high = np.empty((count, 0)), np.empty((count, 0))
        self._per, self._held = 1, 1

    def take(self, time: Vector, values: Matrix) -> None:
        """Add samples with the times `time` (n,) [s] and the signals `values` (count, n)."""
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
        """Merge pairs of columns; an odd number of columns leaves the last column half full."""
        starts = np.arange(0, self._time.size, 2)
        self._held += self._per * (self._time.size % 2 == 0)
        self._time = self._time[starts]
        self._low = np.minimum.reduceat(self._low, starts, axis=1)
        self._high = np.maximum.reduceat(self._high, starts, axis=1)
        self._per *= 2

    def drawn(self) -> tuple[Vector, Matrix, Matrix]:
        """Return start times (c,) [s], minima and maxima (count, c) of the c columns."""
        return self._time, self._low, self._high


def zigzag(time: Vector, low: Vector, high: Vector) -> tuple[Vector, Vector]:
    """Return x and y, (2 c,), of a line that joins minimum and maximum of each of c columns.

    If every minimum equals its maximum, the line has one point per column; x and y are then (c,).
    """
    if np.array_equal(low, high):
        return time, low
    return np.repeat(time, 2), np.column_stack([low, high]).ravel()
