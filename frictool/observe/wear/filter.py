"""A Kalman filter over moves, whose measurement is the Gram matrix of a move; one for each kind of wear.

    prior N(m, P)   ──move: information A/r, b/r──▶   P' = (P^-1 + A/r)^-1,  m' = P' (P^-1 m + b/r)   ──walk Q──▶  the next move

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
    """mean (r,), covariance (r, r): of the restriction's parameters, SI. variance: of a row's residual [(N m)^2 | N^2]."""

    def __init__(self, restricted: Restriction, variance: float, inflation: float) -> None:
        self.restricted, self.inflation = restricted, inflation
        self._matrix = restricted.matrix * restricted.deviation
        self._fixed = restricted.fixed + restricted.matrix @ restricted.mean
        self.state, self.spread = np.zeros(restricted.mean.size), np.eye(restricted.mean.size)
        self._squares, self._rows = variance * PRIOR_ROWS, PRIOR_ROWS

    @property
    def variance(self) -> float:
        """Of a row's residual."""
        return self._squares / self._rows

    @property
    def mean(self) -> Vector:
        """Of the parameters (r,)."""
        return np.asarray(self.restricted.mean + self.restricted.deviation * self.state)

    @property
    def covariance(self) -> Vector:
        """Of the parameters (r, r)."""
        scale = self.restricted.deviation
        return self.spread * np.outer(scale, scale)

    def information(self, move: Move) -> tuple[Vector, Vector, float]:
        """A (r, r), b (r,) and the sum of squares of a move, of what the fixed part of the columns leaves, parameters in deviations."""
        gram, size = move.gram, move.gram.shape[0] - 1
        columns, own = gram[:size, :size], self._fixed
        right = gram[:size, size] - columns @ own
        squares = float(gram[size, size] - 2.0 * own @ gram[:size, size] + own @ columns @ own)
        return self._matrix.T @ columns @ self._matrix, self._matrix.T @ right, squares

    def walk(self, name: str, deviation: float) -> None:
        """The parameter may have moved by `deviation` [SI]."""
        place = self.restricted.place(name)
        self.spread[place, place] += (deviation / self.restricted.deviation[place]) ** 2

    def surprise(self, move: Move, name: str) -> tuple[float, float]:
        """By how much a move alone would move a parameter [SI], the others as they are known now, and that number's deviation.

        0 and inf where the move does not tell of it.
        """
        place, scale = self.restricted.place(name), float(self.restricted.deviation[self.restricted.place(name)])
        a, b, _ = self.information(move)
        noise = self.variance * self.inflation
        known = self.spread.copy()
        loose = 1e6  # the parameter is free, its correlation with the others kept out
        known[place, :] = known[:, place] = 0.0
        known[place, place] = loose
        posterior = np.linalg.inv(np.linalg.inv(known) + a / noise)
        moved = float((posterior @ ((b - a @ self.state) / noise))[place])
        own = float(posterior[place, place])
        return (0.0, np.inf) if own > 0.5 * loose else (scale * moved, scale * float(np.sqrt(own + self.spread[place, place])))

    def update(self, move: Move) -> None:
        """Takes a move."""
        a, b, squares = self.information(move)
        noise = self.variance * self.inflation
        before = np.linalg.inv(self.spread)
        spread = np.linalg.inv(before + a / noise)
        self.spread = 0.5 * (spread + spread.T)
        self.state = self.spread @ (before @ self.state + b / noise)
        left = max(squares - 2.0 * float(self.state @ b) + float(self.state @ a @ self.state), 0.0)
        self._squares, self._rows = self._squares + left, self._rows + move.rows
        if self._rows > MEMORY_ROWS:
            self._squares *= MEMORY_ROWS / self._rows
            self._rows = MEMORY_ROWS
