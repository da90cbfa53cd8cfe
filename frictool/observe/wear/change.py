"""Whether a parameter has changed: what moves say of a step of it beyond what a filter expects, one by one and together.

With e the part of a move that the filter did not foresee, of covariance S = r A + A P A, and h = A[:, w] what a step of the parameter would
add to it, the likelihood is greatest for the step delta = h'S^-1 e / h'S^-1 h, of deviation (h'S^-1 h)^-1/2. Numerators and denominators of
moves that follow each other add up; weighed with `memory` to the power of their age they tell of a drift that no single move would show.
Where nothing has changed, all of them are normal with the deviation that is told (innovations are white).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

MEMORIES = np.array([0.0, 0.8, 0.95])
SURPRISE = 4.0  # deviations
EXPLAINED = 2.0  # deviations that are left where the parameter was let walk


class Change:
    """Watches one parameter of `count` filters."""

    def __init__(self, count: int) -> None:
        self._steps, self._weights, self._squares = (np.zeros((count, MEMORIES.size)) for _ in range(3))

    def seen(self, step: Vector, weight: Vector) -> Vector:
        """By how much the parameter is likely to have changed with this move (k,), a deviation; 0 where nothing says that it has.

        step, weight (k,): h'S^-1 e and h'S^-1 h of each filter. Where something has changed, what was seen before is forgotten.
        """
        self._steps = MEMORIES * self._steps + step[:, None]
        self._weights = MEMORIES * self._weights + weight[:, None]
        self._squares = MEMORIES**2 * self._squares + weight[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):  # a move that tells nothing of the parameter
            size, deviation = np.abs(self._steps) / self._weights, np.sqrt(self._squares) / self._weights
        told = np.abs(self._steps) > SURPRISE * np.sqrt(self._squares)
        walked = np.sqrt(np.max(np.where(told, (size / EXPLAINED) ** 2 - deviation**2, 0.0), axis=1))
        for sums in (self._steps, self._weights, self._squares):
            sums[walked > 0.0] = 0.0
        return np.asarray(walked)
