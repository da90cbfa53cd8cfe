"""Bank of filters, updated by moves; the filters allow different slopes of friction against speed.

    prior N(m, P)  ──move: information A/r, b/r──▶  P' = (P^-1 + A/r)^-1,  m' = m + P' (b - A m)/r
                   ──random walk──▶  the next move
    UNMODELLED     ──evidence of each move──▶ weights ──▶ mean and deviation of the mixture

If all moves are alike, a slope of friction against speed that the model does not include looks much
like wear. A filter without the slope is biased on a plant that has it; a filter with the slope is
less precise. The evidence of the moves decides between the filters (docs/theory/wear.md). Similar
moves repeat the rounding errors of the encoder; the evidence of a move is therefore multiplied by
EVIDENCE and decays within MEMORY moves.

A and b are the Gram matrix C'C and C' effort of the move's rows C. The rows overlap, so that their
errors are correlated. r is the variance of a row's residual, estimated from the moves, times
`inflation`, the number of overlapping rows that count as one independent row. Parameters are in
units of their prior standard deviations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from frictool.observe.wear.change_detection import ChangeDetector
from frictool.observe.wear.log_moves import Move
from frictool.observe.wear.parameter_restriction import ParameterRestriction, UnmodelledFriction
from frictool.typing import Vector

SLOPES = (0.003, 0.03, 0.1, 0.3, 1.0)  # friction at top speed relative to the dry friction
BEFOREHAND = (0.0, -2.0, -3.0, -4.0, -5.0)  # log prior probability of each slope
UNMODELLED = tuple(UnmodelledFriction(slope, 0.5 * slope, 0.3 * slope) for slope in SLOPES)
EVIDENCE = 0.5  # weight of a move's log evidence
MEMORY = 50.0  # moves, time constant of forgetting the evidence
RESTLESS = 0.5  # size of the walk at the next move, relative to that of this move
PRIOR_ROWS = 20.0  # rows that the prior variance counts for
NOISIER = 5.0  # standard deviations by which a move's variance must exceed the known one to be used
PASSES = 3  # iterations for a move's noise
UNSPENT = 0.25  # least fraction of its rows that count after the parameters have used theirs up
MEMORY_ROWS = 5000.0  # rows, memory of the variance


class FilterBank:
    """Bank of k filters for the same n parameters.

    With each move, the parameter `name` makes a random step with the standard deviation `walk`
    [SI]; the other parameters step only after a detected change. restrictions: one for each slope
    in UNMODELLED; they differ only in the prior. variance: prior variance of a row's residual [(N
    m)^2 | N^2]. states (k, n), spreads (k, n, n): means and covariances, relative to the prior
    mean, in units of the prior standard deviations.
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
        self.names = first.names
        self.inflation = inflation
        self.means, self.deviations = (
            np.stack([getattr(one, field) for one in restrictions])
            for field in ("mean", "deviation")
        )
        self.states = np.zeros_like(self.means)
        self.spreads = np.tile(np.eye(len(self.names)), (len(restrictions), 1, 1))
        self._matrix, self._fixed = first.matrix, first.fixed
        self._index = self.names.index(name)
        self._walk = walk / self.deviations[:, self._index]
        self._changes = ChangeDetector(self.means.shape, self._index)
        self._evidence = np.zeros(len(restrictions))
        self._restless = np.zeros_like(self.means)
        self._squares = np.full(len(restrictions), variance * PRIOR_ROWS)
        self._rows = PRIOR_ROWS

    @property
    def weights(self) -> Vector:
        """Weights of the filters, with sum 1."""
        likely = np.array(BEFOREHAND) + self._evidence
        over = np.exp(likely - np.max(likely))
        return np.asarray(over / np.sum(over))

    @property
    def noise(self) -> float:
        """Noise variance r of the filter with the smallest residual [(N m)^2 | N^2]."""
        return self.inflation * float(np.min(self._squares)) / self._rows

    def take(self, move: Move) -> bool:
        """Update the filters with a move; return True if the parameter `name` has changed."""
        information, right, squares = self._information(move)
        missed = right - _times(information, self.states)
        index = self._index
        noise = self._noise_of(
            information,
            missed,
            squares - np.einsum("ki,ki->k", self.states, right + missed),
            move.rows,
        )
        self.spreads[:, index, index] += self._walk**2
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
        self.states = self.states + moved
        self.spreads = 0.5 * (spreads + spreads.transpose(0, 2, 1))
        self._learn(
            squares
            - np.einsum("ki,ki->k", self.states, 2.0 * right - _times(information, self.states)),
            move.rows,
        )
        return bool(walked[int(np.argmax(self.weights)), index] > 0.0)

    def value(self, name: str) -> tuple[float, float]:
        """Return mean and standard deviation of a parameter [SI]."""
        index = self.names.index(name)
        weights = self.weights
        values = self.means[:, index] + self.deviations[:, index] * self.states[:, index]
        variances = self.deviations[:, index] ** 2 * self.spreads[:, index, index]
        mean = float(weights @ values)
        return mean, math.sqrt(float(weights @ (variances + (values - mean) ** 2)))

    def _loosen(self, walked: Vector) -> None:
        """Add steps of the parameters with standard deviations `walked` (k, n)."""
        self.spreads += walked[:, :, None] ** 2 * np.eye(walked.shape[1])

    def _information(self, move: Move) -> tuple[Vector, Vector, Vector]:
        """Return A (k, n, n), b (k, n) and sum of squares (k,) of a move.

        All are relative to the prior mean and in units of the prior standard deviations.
        """
        size = move.gram.shape[0] - 1
        columns = move.gram[:size, :size]
        fixed = self._fixed
        remainder = move.gram[:size, size] - columns @ fixed
        gram = self._matrix.T @ columns @ self._matrix
        right = self._matrix.T @ remainder
        squares = float(move.gram[size, size] - fixed @ move.gram[:size, size] - fixed @ remainder)
        left = right - self.means @ gram
        scale = self.deviations
        return (
            gram * scale[:, :, None] * scale[:, None, :],
            scale * left,
            squares - np.einsum("ki,ki->k", self.means, right + left),
        )

    def _noise_of(self, information: Vector, missed: Vector, left: Vector, rows: int) -> float:
        """Return the noise variance r of a move [(N m)^2 | N^2].

        r is the variance learned so far, unless the residual of the move is significantly larger; r
        then includes this residual. Otherwise a noisy first move would be weighted by the prior
        variance, and its weight would stay too large. left: (k,), residuals of the present filters.
        """
        known = noise = self.noise
        # free of earlier moves, because a changed parameter is not noise
        free = np.broadcast_to(np.eye(missed.shape[1]), information.shape)
        for _ in range(PASSES):
            spreads = _gain(free, information, noise)
            moved = _times(spreads, missed) / noise
            squares = (
                left
                - 2.0 * np.einsum("ki,ki->k", moved, missed)
                + np.einsum("ki,kij,kj->k", moved, information, moved)
            )
            # rows that the parameters have used up
            spent = self.inflation * np.einsum("kij,kji->k", spreads, information) / noise
            left_over = np.maximum(rows - spent, UNSPENT * rows)
            fair = np.maximum(squares, 0.0) * rows / left_over
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
        """Add a move's residual squares `left` and its number of rows to the variance estimate."""
        self._squares = self._squares + np.maximum(left, 0.0)
        self._rows = self._rows + rows
        if self._rows > MEMORY_ROWS:
            self._squares = self._squares * MEMORY_ROWS / self._rows
            self._rows = MEMORY_ROWS


def _times(matrices: Vector, vectors: Vector) -> Vector:
    """Return the products (k, n) of matrices (k, n, n) and vectors (k, n)."""
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])


def _gain(spreads: Vector, information: Vector, noise: float) -> Vector:
    """Return the inverses (k, n, n) of 1 + P A/r; r is the noise variance `noise`.

    P is the covariance `spreads` and A the matrix `information` of a move. The result times P is
    the new covariance. The result's transpose, divided by r and times the innovation e, is A S^-1 e
    with the covariance S of e.
    """
    return np.asarray(np.linalg.inv(np.eye(spreads.shape[1]) + spreads @ information / noise))
