"""Detection of flat tops, where an amplifier, sensor or converter saturates.

The values of a signal are counted in classes of equal width. Around a maximum, a smooth signal is a
parabola. Then the topmost class has at most 1/(sqrt(2) - 1) = 2.4 times as many samples as the
class below, for any quantisation. A clipped signal has most samples in the topmost class, and stays
at one value for several samples.

A signal that repeats its values everywhere, such as a command between two updates, has no flat
tops. An extreme value of 0 is not a flat top, because the axis may rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.typing import Vector

SHORTEST = 4  # least number of consecutive samples at the extreme
SHARP = 5.0  # least ratio of the outermost class to the next; a parabola has 2.4
CLASS = 1e-3  # width of a class relative to the range; it is at least one quantisation step
# a signal with a larger share of repeated values away from its extremes repeats values everywhere
REPEATING = 0.5


@dataclass(frozen=True)
class FlatTop:
    """Flat top of a signal.

    at: value of the flat top.
    longest: largest number of successive samples at this value.
    """

    at: float
    samples: int
    longest: int


class FlatTopDetector:
    """Detector of flat tops of one signal, block after block.

    low, high: smallest and largest value of the signal.
    step: quantisation step of the signal; None if the signal is not quantised.
    """

    def __init__(self, low: float, high: float, step: float | None) -> None:
        self._low, self._high = low, high
        self._width = max(step or 0.0, CLASS * (high - low))
        self._sides = (_ExtremeCounts(), _ExtremeCounts())
        self._last = np.nan
        self._repeats = self._others = 0

    def take(self, values: Vector) -> None:
        """Add the next values (n,) of the signal."""
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

    def result(self) -> tuple[FlatTop, ...]:
        """Return the flat tops: first at the lowest value, then at the highest value."""
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
    """Counts at one extreme of a signal.

    samples: number of samples in the outermost class of values.
    neighbouring: number of samples in the class next to it.

    longest: length of the longest sequence of samples in the outermost class.
    """

    def __init__(self) -> None:
        self.samples = self.neighbouring = self.longest = self._run = 0

    def take(self, outermost: NDArray[np.bool_], neighbouring: NDArray[np.bool_]) -> None:
        self.samples += int(outermost.sum())
        self.neighbouring += int(neighbouring.sum())
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
        return self.longest >= SHORTEST and self.samples > SHARP * max(self.neighbouring, 1)
