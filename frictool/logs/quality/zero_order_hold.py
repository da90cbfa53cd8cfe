"""Detection of zero-order hold: a signal that keeps its value for several samples of the log.

Examples are a command, and a current that is measured once per control period. A signal is held if
two conditions are met: it rarely changes at two consecutive samples, and its changes are larger
than one quantisation step. A slow position also changes rarely, but by one count each time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.typing import Vector

FEWEST = 3  # least number of changes for a decision
MOST = 100_000  # maximum number of changes evaluated
RARE = 0.05  # share of intervals between changes that may be shorter than the hold
STEPS = 1.5  # least change in quantisation steps; a smaller change is a count of a slow motion


class HoldDetector:
    """Detector of zero-order hold in one signal, block after block."""

    def __init__(self) -> None:
        self._last = np.nan
        self._seen = 0
        self._places: list[NDArray[np.int64]] = []
        self._sizes: list[Vector] = []
        self._count = 0

    def take(self, values: Vector) -> None:
        """Add the next values (n,) of the signal."""
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
        """Return the hold time in samples of the log; None without zero-order hold.

        step: quantisation step of the signal; None if the signal is not quantised.
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
