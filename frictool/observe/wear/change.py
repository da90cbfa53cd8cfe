"""Whether a parameter has changed: what moves say of a step of it beyond what the filter expects, one by one and together.

With e the part of a move that the filter did not foresee, of covariance S = r A + A P A, and h = A[:, w] what a step of the parameter would
add to it, the likelihood is greatest for the step delta = h'S^-1 e / h'S^-1 h, of deviation (h'S^-1 h)^-1/2. Numerators and denominators of
moves that follow each other add up; weighed with `memory` to the power of their age they tell of a drift that no single move would show.
Where nothing has changed, all of them are normal with the deviation that is told (innovations are white).
"""

from __future__ import annotations

import math

import numpy as np

from frictool.observe.wear.filter import Filter
from frictool.observe.wear.moves import Move

MEMORIES = (0.0, 0.8, 0.95)
SURPRISE = 4.0  # deviations
EXPLAINED = 2.0  # deviations that are left where the parameter was let walk


class Change:
    """Watches one parameter of a filter."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._steps, self._weights, self._squares = ([0.0] * len(MEMORIES) for _ in range(3))

    def seen(self, own: Filter, move: Move) -> float:
        """By how much [SI] the parameter is likely to have changed with this move (deviation), 0 where nothing says that it has.

        To be asked before the filter takes the move; forgets what it has seen when it says that something has changed.
        """
        step, weight = score(own, move, self.name)
        walked = 0.0
        for index, memory in enumerate(MEMORIES):
            self._steps[index] = memory * self._steps[index] + step
            self._weights[index] = memory * self._weights[index] + weight
            self._squares[index] = memory**2 * self._squares[index] + weight
            total, spread = self._steps[index], math.sqrt(self._squares[index])
            if abs(total) > SURPRISE * spread:
                size, deviation = abs(total) / self._weights[index], spread / self._weights[index]
                walked = max(walked, math.sqrt(max((size / EXPLAINED) ** 2 - deviation**2, 0.0)))
        if walked > 0.0:
            self._steps, self._weights, self._squares = ([0.0] * len(MEMORIES) for _ in range(3))
        return walked


def score(own: Filter, move: Move, name: str) -> tuple[float, float]:
    """h'S^-1 e and h'S^-1 h of a step of the parameter [1/SI, 1/SI^2]: their ratio is the step, the second its deviation to the -2."""
    place = own.restricted.place(name)
    scale = float(own.restricted.deviation[place])
    information, right, _ = own.information(move)
    mixed = own.noise * np.eye(right.size) + information @ own.spread  # S = mixed A, on what A spans
    solved = np.linalg.solve(mixed, np.column_stack([right - information @ own.state, information[:, place]]))
    return float(solved[place, 0]) / scale, max(float(solved[place, 1]), 0.0) / scale**2
