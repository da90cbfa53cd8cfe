"""Filters over moves that differ in how far friction over speed may be from the model's, weighed by
how well they foresee the moves.

    prior N(m, P)   ──move: information A/r, b/r──▶   P' = (P^-1 + A/r)^-1,  m' = m + P' (b - A m)/r
                    ──walk──▶  the next move
    UNMODELLED      ──evidence of each move──▶ weights ──▶ mean and deviation of the mixture

A slope of friction over speed that the model has not looks much like wear on moves that are all
alike. Excluded beforehand it costs no precision and biases the wear of a plant that has it; left
open it costs three times the precision on a plant that has not. Here the moves say which of the two
it is, and until they do the interval holds both. A slope is positive, as all viscous friction is,
and the less of it, the likelier beforehand. Moves that repeat each other repeat the errors of the
encoder's counts: their evidence counts for EVIDENCE, and is forgotten in MEMORY moves.

A move measures by its Gram matrix. Its rows overlap and their errors are not independent: r is the
variance of a row's residual, learned from the moves, times how many rows tell as much as one
(`inflation`). Parameters are counted in deviations of what is known of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from frictool.observe.wear.change_detection import ChangeDetector
from frictool.observe.wear.moves import Move
from frictool.observe.wear.restriction import ParameterRestriction, UnmodelledFriction

Vector = NDArray[np.float64]

SLOPES = (0.003, 0.03, 0.1, 0.3, 1.0)  # of the dry friction at top speed
BEFOREHAND = (0.0, -2.0, -3.0, -4.0, -5.0)  # natural logarithms of how likely each is
UNMODELLED = tuple(UnmodelledFriction(slope, 0.5 * slope, 0.3 * slope) for slope in SLOPES)
EVIDENCE = 0.5
MEMORY = 50.0  # moves, over which it is kept
RESTLESS = 0.5  # of what a parameter has changed by: what it may change by with the next move
PRIOR_ROWS = 20.0  # for how many rows the variance known beforehand counts
NOISIER = 5.0  # deviations, by which the variance that a move leaves is above the one that is known
PASSES = 3  # until its noise no longer moves
UNSPENT = 0.25  # of its rows at least, when parameters have used theirs up
MEMORY_ROWS = 5000.0  # over how many rows the variance is a mean


class FilterBank:
    """Filters of the same parameters, one of which, `name`, walks by `walk` [SI] a move, and all
    further where they have changed.

    restrictions: one for each of UNMODELLED, in that order, of one matrix. variance: known
    beforehand of a row's residual [(N m)^2 | N^2]. states (k, r), spreads (k, r, r): mean and
    covariance of filter k, from what is known of the parameters, in deviations of that.
    """

    def __init__(
        self,
        restrictions: Sequence[ParameterRestriction],
        variance: float,
        inflation: float,
        name: str,
        walk: float,
    ) -> None:
        first = restrictions[0]
        self.names, self.inflation = first.names, inflation
        self.means, self.deviations = (
            np.stack([getattr(one, field) for one in restrictions])
            for field in ("mean", "deviation")
        )
        self.states, self.spreads = (
            np.zeros_like(self.means),
            np.tile(np.eye(len(self.names)), (len(restrictions), 1, 1)),
        )
        self._matrix, self._fixed = first.matrix, first.fixed
        self._place = self.names.index(name)
        self._walk, self._changes = (
            walk / self.deviations[:, self._place],
            ChangeDetector(self.means.shape, self._place),
        )
        self._evidence, self._restless = np.zeros(len(restrictions)), np.zeros_like(self.means)
        self._squares, self._rows = np.full(len(restrictions), variance * PRIOR_ROWS), PRIOR_ROWS

    @property
    def weights(self) -> Vector:
        """Of each filter, their sum 1."""
        likely = np.array(BEFOREHAND) + self._evidence
        over = np.exp(likely - np.max(likely))
        return np.asarray(over / np.sum(over))

    @property
    def noise(self) -> float:
        """r, by the filter that leaves least [(N m)^2 | N^2]."""
        return self.inflation * float(np.min(self._squares)) / self._rows

    def take(self, move: Move) -> bool:
        """Takes a move; whether it tells, with those before it, that the parameter has changed."""
        information, right, squares = self._information(move)
        missed, place = right - _times(information, self.states), self._place
        noise = self._noise_of(
            information,
            missed,
            squares - np.einsum("ki,ki->k", self.states, right + missed),
            move.rows,
        )
        self.spreads[:, place, place] += self._walk**2
        self._restless *= RESTLESS
        self._loosen(self._restless)
        gain = _gain(self.spreads, information, noise)
        back = gain.transpose(0, 2, 1)
        walked = self._changes.seen(
            _times(back, missed) / noise, np.einsum("kij,kji->ki", back, information) / noise
        )
        if np.any(walked > 0.0):
            self._loosen(walked)
            self._restless = np.maximum(self._restless, walked)
            gain = _gain(self.spreads, information, noise)
        spreads = gain @ self.spreads
        moved = _times(spreads, missed) / noise
        left = squares - np.einsum("ki,ki->k", self.states, right + missed)
        _, logarithm = np.linalg.slogdet(gain)
        foreseen = (
            EVIDENCE * 0.5 * (logarithm - (left - np.einsum("ki,ki->k", moved, missed)) / noise)
        )
        self._evidence = (1.0 - 1.0 / MEMORY) * self._evidence + foreseen - np.max(foreseen)
        self.states, self.spreads = (
            self.states + moved,
            0.5 * (spreads + spreads.transpose(0, 2, 1)),
        )
        self._learn(
            squares
            - np.einsum("ki,ki->k", self.states, 2.0 * right - _times(information, self.states)),
            move.rows,
        )
        return bool(walked[int(np.argmax(self.weights)), place] > 0.0)

    def value(self, name: str) -> tuple[float, float]:
        """A parameter's mean and deviation [SI]."""
        place, weights = self.names.index(name), self.weights
        values = self.means[:, place] + self.deviations[:, place] * self.states[:, place]
        variances = self.deviations[:, place] ** 2 * self.spreads[:, place, place]
        mean = float(weights @ values)
        return mean, math.sqrt(float(weights @ (variances + (values - mean) ** 2)))

    def _loosen(self, walked: Vector) -> None:
        """The parameters may have moved by `walked` (k, r)."""
        self.spreads += walked[:, :, None] ** 2 * np.eye(walked.shape[1])

    def _information(self, move: Move) -> tuple[Vector, Vector, Vector]:
        """A (k, r, r), b (k, r) and the sum of squares (k,) of a move, beside what is known
        beforehand, parameters in deviations."""
        size = move.gram.shape[0] - 1
        columns, fixed = move.gram[:size, :size], self._fixed
        beside = move.gram[:size, size] - columns @ fixed
        own, right = self._matrix.T @ columns @ self._matrix, self._matrix.T @ beside
        squares = float(move.gram[size, size] - fixed @ move.gram[:size, size] - fixed @ beside)
        left, scale = right - self.means @ own, self.deviations
        return (
            own * scale[:, :, None] * scale[:, None, :],
            scale * left,
            squares - np.einsum("ki,ki->k", self.means, right + left),
        )

    def _noise_of(self, information: Vector, missed: Vector, left: Vector, rows: int) -> float:
        """r of a move [(N m)^2 | N^2]: what it leaves itself, among all rows before, where that is
        more than what was known for certain.

        Else a noisy first move would weigh by what was known beforehand, and too much for good.
        left (k,): with the filters as they are.
        """
        known = noise = self.noise
        free = np.broadcast_to(
            np.eye(missed.shape[1]), information.shape
        )  # of what moves before told: one that has changed is no noise
        for _ in range(PASSES):
            spreads = _gain(free, information, noise)
            moved = _times(spreads, missed) / noise
            own = (
                left
                - 2.0 * np.einsum("ki,ki->k", moved, missed)
                + np.einsum("ki,kij,kj->k", moved, information, moved)
            )
            spent = (
                self.inflation * np.einsum("kij,kji->k", spreads, information) / noise
            )  # rows that the parameters have used up
            left_over = np.maximum(rows - spent, UNSPENT * rows)
            fair = np.maximum(own, 0.0) * rows / left_over
            if np.any(
                self.inflation * fair
                < known * rows * (1.0 + NOISIER * np.sqrt(2.0 * self.inflation / left_over))
            ):
                return known
            noise = max(
                noise, self.inflation * float(np.min(self._squares + fair)) / (self._rows + rows)
            )
        return noise

    def _learn(self, left: Vector, rows: int) -> None:
        """The residual's variance, from what the filters leave of a move."""
        self._squares, self._rows = self._squares + np.maximum(left, 0.0), self._rows + rows
        if self._rows > MEMORY_ROWS:
            self._squares, self._rows = self._squares * MEMORY_ROWS / self._rows, MEMORY_ROWS


def _times(matrices: Vector, vectors: Vector) -> Vector:
    """(k, r, r) times (k, r)."""
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])


def _gain(spreads: Vector, information: Vector, noise: float) -> Vector:
    """(1 + P A/r)^-1, with which P' is its product with P, and S^-1 of what a move does not foresee
    its transposed, by r."""
    return np.asarray(np.linalg.inv(np.eye(spreads.shape[1]) + spreads @ information / noise))
