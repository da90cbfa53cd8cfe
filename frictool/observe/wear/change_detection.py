"""Which parameter has changed, if any: what moves say of a step of it beyond what a filter expects,
one by one and together.

With e the part of a move that the filter did not foresee, of covariance S = r A + A P A, and h =
A[:, w] what a step of parameter w would add to it, the likelihood is greatest for the step delta =
h'S^-1 e / h'S^-1 h, of deviation (h'S^-1 h)^-1/2. Numerators and denominators of moves that follow
each other add up; weighed with `memory` to the power of their age they tell of a drift that no
single move would show. Where nothing has changed, all of them are normal with the deviation that is
told (innovations are white).

A change of one parameter looks a little like one of each other: only the likeliest is told, and one
parameter, the wear, is the likelier beforehand by FAVOUR.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

MEMORIES = np.array([0.0, 0.8, 0.95])
SURPRISE = 4.0  # deviations
FAVOUR = 6.0  # natural logarithm
EXPLAINED = 2.0  # deviations that are left where the parameter was let walk


class ChangeDetector:
    """Watches the parameters of some filters; `shape` (k, r), `favoured`: the place of the wear
    among the r."""

    def __init__(self, shape: tuple[int, ...], favoured: int) -> None:
        self._favour = 2.0 * FAVOUR * (np.arange(shape[1]) == favoured)[:, None]
        self._steps, self._weights, self._squares = (
            np.zeros((*shape, MEMORIES.size)) for _ in range(3)
        )

    def seen(self, step: Vector, weight: Vector) -> Vector:
        """By how much a parameter is likely to have changed with this move (k, r), a deviation; 0
        where nothing says that it has.

        step, weight (k, r): h'S^-1 e and h'S^-1 h. A filter that tells of a change forgets what it
        has seen before.
        """
        self._steps = MEMORIES * self._steps + step[..., None]
        self._weights = MEMORIES * self._weights + weight[..., None]
        self._squares = MEMORIES**2 * self._squares + weight[..., None]
        with np.errstate(
            divide="ignore", invalid="ignore"
        ):  # a move that tells nothing of a parameter
            surprise = np.nan_to_num(
                np.abs(self._steps) / np.sqrt(self._squares), nan=0.0, posinf=0.0
            )
            size, deviation = (
                np.abs(self._steps) / self._weights,
                np.sqrt(self._squares) / self._weights,
            )
        likely = np.where(
            surprise > SURPRISE, surprise**2 + self._favour, 0.0
        )  # twice the logarithm
        told = (likely > 0.0) & (likely == np.max(likely, axis=(1, 2), keepdims=True))
        walked = np.sqrt(
            np.max(np.where(told, (size / EXPLAINED) ** 2 - deviation**2, 0.0), axis=2)
        )
        for sums in (self._steps, self._weights, self._squares):
            sums[np.any(walked > 0.0, axis=1)] = 0.0
        return np.asarray(walked)
