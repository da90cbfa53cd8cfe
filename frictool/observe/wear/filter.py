"""A Kalman filter over moves, whose measurement is the Gram matrix of a move; one for each kind of wear.

    prior N(m, P)   ──move: information A/r, b/r──▶   P' = (P^-1 + A/r)^-1,  m' = P' (P^-1 m + b/r)   ──walk──▶  the next move

Rows overlap and their errors are not independent: r is the variance of a row's residual times how many rows tell as much as one
(`inflation`). The residual's variance is learned from the moves; parameters are counted in deviations of what is known of them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.observe.wear.moves import Move
from frictool.observe.wear.restriction import Restriction

Vector = NDArray[np.float64]

PRIOR_ROWS = 20.0  # for how many rows the variance known beforehand counts
MEMORY_ROWS = 5000.0  # over how many rows the variance is a mean


class Filter:
    """state (r,), spread (r, r): mean and covariance of the restriction's parameters, from what is known of them, in deviations of that.

    variance: known beforehand of a row's residual [(N m)^2 | N^2]. inflation: rows that tell as much as one with independent errors.
    """

    def __init__(self, restricted: Restriction, variance: float, inflation: float) -> None:
        self.restricted, self.inflation = restricted, inflation
        self.state, self.spread = np.zeros(restricted.mean.size), np.eye(restricted.mean.size)
        self._matrix = restricted.matrix * restricted.deviation
        self._known = restricted.fixed + restricted.matrix @ restricted.mean
        self._squares, self._rows = variance * PRIOR_ROWS, PRIOR_ROWS

    @property
    def variance(self) -> float:
        """Of a row's residual [(N m)^2 | N^2]."""
        return self._squares / self._rows

    @property
    def noise(self) -> float:
        """r: of as many rows as tell what one with independent errors would [(N m)^2 | N^2]."""
        return self.variance * self.inflation

    def value(self, name: str) -> tuple[float, float]:
        """A parameter's mean and deviation [SI]."""
        place = self.restricted.place(name)
        scale = float(self.restricted.deviation[place])
        return float(self.restricted.mean[place]) + scale * float(self.state[place]), scale * float(np.sqrt(self.spread[place, place]))

    def information(self, move: Move) -> tuple[Vector, Vector, float]:
        """A (r, r), b (r,) and the sum of squares of a move, beside what is known beforehand, parameters in deviations."""
        gram, size, known = move.gram, move.gram.shape[0] - 1, self._known
        columns = gram[:size, :size]
        left = gram[:size, size] - columns @ known
        squares = float(gram[size, size] - known @ gram[:size, size] - known @ left)
        return self._matrix.T @ columns @ self._matrix, self._matrix.T @ left, squares

    def walk(self, name: str, deviation: float) -> None:
        """The parameter may have moved by `deviation` [SI]."""
        place = self.restricted.place(name)
        self.spread[place, place] += (deviation / self.restricted.deviation[place]) ** 2

    def evidence(self, move: Move, noise: float) -> float:
        """ln p of a move to come, but for what depends on `noise` [(N m)^2 | N^2], its r, alone; to compare filters at one noise."""
        information, right, squares = self.information(move)
        missed = right - information @ self.state
        left = squares - self.state @ (right + missed)
        whole = np.eye(right.size) + self.spread @ information / noise
        _, logarithm = np.linalg.slogdet(whole)
        explained = missed @ np.linalg.solve(whole, self.spread @ missed)
        return float(-0.5 * (logarithm + left / noise - explained / noise**2))

    def update(self, move: Move) -> None:
        """Takes a move."""
        information, right, squares = self.information(move)
        before = np.linalg.inv(self.spread)
        spread = np.linalg.inv(before + information / self.noise)
        self.state = spread @ (before @ self.state + right / self.noise)
        self.spread = 0.5 * (spread + spread.T)
        left = max(squares - 2.0 * float(self.state @ right) + float(self.state @ information @ self.state), 0.0)
        self._squares, self._rows = self._squares + left, self._rows + move.rows
        if self._rows > MEMORY_ROWS:
            self._squares, self._rows = self._squares * MEMORY_ROWS / self._rows, MEMORY_ROWS
