"""Flat tops: a signal that stays at its extreme value because its amplifier, its sensor or its
converter goes no further.

Around a maximum a smooth signal is a parabola: in classes of one width its topmost holds at most
1/(sqrt(2) - 1) = 2.4 times the samples of the next, however it is quantised. A clipped one has most
of them in the topmost, in runs of the same value. A signal that repeats its values everywhere (a
command between two updates) says nothing by repeating them at the top, and one that ends at 0 is at
rest there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.logs.log import Vector

SHORTEST = 4  # samples in a row at the extreme
SHARP = 5.0  # times the samples of the class beside it; a parabola has 2.4
CLASS = 1e-3  # of the range: the width of a class, where the quantisation is finer
# share of samples that repeat the one before, away from the extremes: a signal that is held
REPEATING = 0.5


@dataclass(frozen=True)
class FlatTop:
    """A signal is flat at the value `at` for `samples` samples, `longest` of them in a row."""

    at: float
    samples: int
    longest: int


class FlatTopDetector:
    """The extremes of one signal whose lowest and highest value, and step where it has one, are
    known from a first pass."""

    def __init__(self, low: float, high: float, step: float | None) -> None:
        self._low, self._high = low, high
        self._width = max(step or 0.0, CLASS * (high - low))
        self._sides = (_ExtremeCounts(), _ExtremeCounts())
        self._last = np.nan
        self._repeats = self._others = 0

    def take(self, values: Vector) -> None:
        """Adds values (n,) that follow those before."""
        if not values.size:
            return
        for side, depth in zip(self._sides, (values - self._low, self._high - values), strict=True):
            side.take(
                depth < 0.5 * self._width,
                (depth >= 0.5 * self._width) & (depth < 1.5 * self._width),
            )
        inside = (values - self._low >= 0.5 * self._width) & (
            self._high - values >= 0.5 * self._width
        )
        self._repeats += int(np.sum(inside & (np.diff(values, prepend=self._last) == 0.0)))
        self._others += int(np.sum(inside))
        self._last = float(values[-1])

    def found(self) -> tuple[FlatTop, ...]:
        """The flat tops, the lower before the upper."""
        if (
            self._high <= self._low
            or self._others < SHORTEST
            or self._repeats > REPEATING * self._others
        ):
            return ()
        ends = zip((self._low, self._high), self._sides, strict=True)
        return tuple(
            FlatTop(at, side.samples, side.longest)
            for at, side in ends
            if side.is_flat and abs(at) > 0.5 * self._width
        )


class _ExtremeCounts:
    """How many samples lie in the outermost class and in the next, and the longest run in the
    outermost."""

    def __init__(self) -> None:
        self.samples = self.beside = self.longest = self._run = 0

    def take(self, outermost: NDArray[np.bool_], beside: NDArray[np.bool_]) -> None:
        self.samples += int(outermost.sum())
        self.beside += int(beside.sum())
        breaks = np.flatnonzero(~outermost)
        if not breaks.size:
            self._run += outermost.size
            self.longest = max(self.longest, self._run)
            return
        between = int(np.diff(breaks).max(initial=1)) - 1
        self.longest = max(self.longest, self._run + int(breaks[0]), between)
        self._run = outermost.size - 1 - int(breaks[-1])
        self.longest = max(self.longest, self._run)

    @property
    def is_flat(self) -> bool:
        return self.longest >= SHORTEST and self.samples > SHARP * max(self.beside, 1)
