"""Detection of a step in one parameter, from the innovations of one or several moves.

Let e be the innovation b - A m of a move, with covariance S = r A + A P A (A, b, m, P and r:
filter_bank.py). Let h = A[:, w] be the effect of a unit step of parameter w on e. The
maximum-likelihood step is delta = h'S^-1 e / h'S^-1 h. Without a change, delta is normal with the
standard deviation (h'S^-1 h)^-1/2, because the innovations are white. To detect a drift that no
single move shows, numerators and denominators of successive moves are summed. There is one sum for
each q in MEMORIES; j moves later, a move has the weight q^j in this sum.

A change of one parameter resembles changes of others. Only the most likely change is therefore
reported. The log prior of a change of the wear exceeds the log prior of other changes by FAVOUR.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector

MEMORIES = np.array([0.0, 0.8, 0.95])  # weight of a move divided by the weight of the next move
SURPRISE = 4.0  # standard deviations above which a step is a change
FAVOUR = 6.0  # log of the prior odds of a change of the wear against a change of another parameter
# largest standard deviation of the random step, in prior standard deviations: a parameter that the
# moves hardly show would otherwise lose its prior
LARGEST = 10.0
EXPLAINED = 2.0  # size of a change, in standard deviations of the random step that explains it


class ChangeDetector:
    """Detector of changes of the parameters of several filters.

    - shape: (k, n), the numbers of filters and parameters
    - favoured: index of the wear among the parameters
    """

    def __init__(self, shape: tuple[int, ...], favoured: int) -> None:
        self._favour = 2.0 * FAVOUR * (np.arange(shape[1]) == favoured)[:, None]
        self._steps, self._weights, self._squares = (
            np.zeros((*shape, MEMORIES.size)) for _ in range(3)
        )

    def add_move(self, step: Vector, weight: Vector) -> Vector:
        """Add a move; return the standard deviations (k, n) of random steps that explain a change.

        The result is 0 for a parameter without a change. `step` and `weight` (k, n) are numerator
        and denominator of the maximum-likelihood step (module docstring). If a filter reports a
        change, its sums restart.
        """
        self._steps = MEMORIES * self._steps + step[..., None]
        self._weights = MEMORIES * self._weights + weight[..., None]
        self._squares = MEMORIES**2 * self._squares + weight[..., None]
        # a move may carry no information about a parameter
        with np.errstate(divide="ignore", invalid="ignore"):
            surprise = np.nan_to_num(
                np.abs(self._steps) / np.sqrt(self._squares), nan=0.0, posinf=0.0
            )
            size, deviation = (
                np.abs(self._steps) / self._weights,
                np.sqrt(self._squares) / self._weights,
            )
        # twice the log likelihood ratio
        likely = np.where(surprise > SURPRISE, surprise**2 + self._favour, 0.0)
        likeliest = (likely > 0.0) & (likely == np.max(likely, axis=(1, 2), keepdims=True))
        size, deviation = (np.where(likeliest, one, 0.0) for one in (size, deviation))
        walked = np.sqrt(np.max((size / EXPLAINED) ** 2 - deviation**2, axis=2))
        walked = np.minimum(walked, LARGEST)
        for sums in (self._steps, self._weights, self._squares):
            sums[np.any(walked > 0.0, axis=1)] = 0.0
        return np.asarray(walked)
