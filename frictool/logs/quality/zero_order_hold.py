"""Zero-order-hold signals: a command, or a current measured once in a control period, keeps its
value for several samples of the log.

A signal is held where it hardly ever changes from one sample to the next, and its changes are no
single steps of its quantisation: a slow position changes seldom too, by one count each time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.logs.log import Vector

FEWEST = 3  # changes
MOST = 100_000  # changes looked at
RARE = 0.05  # share of intervals between changes that may be shorter than the hold
STEPS = 1.5  # of the quantisation: a change of more is no count of a slow motion


class HoldDetector:
    """The changes of one signal, gathered block after block."""

    def __init__(self) -> None:
        self._last = np.nan
        self._seen = 0
        self._places: list[NDArray[np.int64]] = []
        self._sizes: list[Vector] = []
        self._count = 0

    def take(self, values: Vector) -> None:
        """Adds values (n,) that follow those before."""
        if not values.size:
            return
        if self._count < MOST:
            steps = np.abs(np.diff(values, prepend=self._last if self._seen else values[0]))
            changed = np.flatnonzero(steps)[: MOST - self._count]
            self._places.append(changed + self._seen)
            self._sizes.append(steps[changed])
            self._count += changed.size
        self._seen += values.size
        self._last = float(values[-1])

    def samples(self, step: float | None) -> int | None:
        """For how many samples a value is held, at least, but for rare exceptions; None where the
        signal is not held.

        step: of the signal's quantisation, where it has one.
        """
        if self._count < FEWEST:
            return None
        intervals = np.diff(np.concatenate(self._places))
        shortest = int(np.quantile(intervals, RARE, method="lower"))
        if shortest < 2 or (
            step is not None and float(np.median(np.concatenate(self._sizes))) < STEPS * step
        ):
            return None
        return shortest
