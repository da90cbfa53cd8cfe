"""Bank of filters for wear and friction, with different slopes of friction over speed.

    each move         P' = (P^-1 + A/r)^-1      m' = m + P' (b - A m)/r
    then              a random step of the wear, which increases P'
    over all filters  evidence of the moves ──▶ weights ──▶ mean and deviation of the mixture

m and P are mean and covariance of a filter's parameters, in units of their prior standard
deviations. A = C'C and b = C' effort with the rows C of the move. The rows overlap, so that their
errors are correlated. r is the variance of a row's residual, estimated from the moves and
multiplied by `inflation`. This factor is the number of overlapping rows that are as precise as one
independent row.

If all moves have similar speeds, a slope of friction over speed that the model does not include
cannot be distinguished from wear. If the friction of the axis has such a slope, a filter without
this slope is biased; a filter with this slope is less precise. The evidence of the moves decides
between the filters (docs/theory/wear.md). Other filters assume friction that falls with speed.
Similar moves repeat the rounding errors of the encoder; the evidence of a move is therefore
multiplied by EVIDENCE and decays within MEMORY moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy

from frictool.observe.wear.change_detection import ChangeDetector
from frictool.observe.wear.log_moves import Move
from frictool.observe.wear.parameter_restriction import ParameterRestriction, UnmodelledFriction
from frictool.observe.wear.weak_form_layout import FALLS
from frictool.typing import Matrix, Vector

SLOPES = (0.003, 0.03, 0.1, 0.3, 1.0)  # friction at top speed relative to the dry friction
# mean and standard deviation of an unmodelled fall of the friction, relative to the dry friction
FALL, FALL_SPREAD = 0.25, 0.15
# standard deviation of a small fall on one scale, relative to the dry friction
SMALL_FALL = 3e-3


def falling(at: int) -> UnmodelledFriction:
    """Return unmodelled friction that falls by about FALL over the speed scale of index `at`.

    The neighbouring scales may contain a part of the fall.
    """
    fallen = [FALL_SPREAD if abs(index - at) <= 1 else SMALL_FALL for index in range(len(FALLS))]
    return UnmodelledFriction(0.0, 0.03, 0.01, FALL, at, tuple(fallen))


# log prior probability of each slope, and of each fall on each scale
BEFOREHAND = (0.0, -2.0, -3.0, -4.0, -5.0, *(-4.0,) * len(FALLS))
UNMODELLED = (
    UnmodelledFriction(SLOPES[0], 0.5 * SLOPES[0], 0.3 * SLOPES[0]),
    *(
        UnmodelledFriction(slope, 0.5 * slope, 0.3 * slope, fallen=(SMALL_FALL,) * len(FALLS))
        for slope in SLOPES[1:]
    ),
    *(falling(at) for at in range(len(FALLS))),
)
NEGATIVE = 1.0 / 3.0  # standard deviation of a negative part of a fall, in prior deviations
EVIDENCE = 0.5  # weight of a move's log evidence
MEMORY = 50.0  # moves, time constant of forgetting the evidence
RESTLESS = 0.5  # factor by which an enlarged random step decays per move
PRIOR_ROWS = 20.0  # weight of the prior variance, in rows
# a move's variance is used if it exceeds the known variance by this number of standard deviations
NOISIER = 5.0
PASSES = 3  # iterations for a move's noise
UNSPENT = 0.25  # smallest number of degrees of freedom of a move's residual, per row
HALVINGS = 40  # bisections for the end of an interval
MEMORY_ROWS = 5000.0  # number of rows that determine the variance; older rows fade


class FilterBank:
    """Bank of k filters for the same n parameters.

    After each move, the parameter `name` makes a random step with the standard deviation `walk`
    [SI]. The other parameters make a step only after a detected change.

    - restrictions: for each filter, map from the parameters to the coefficients of a row; the maps
      differ only in the prior
    - variance: prior variance of a row's residual, (N m)^2 | N^2
    - inflation: number of overlapping rows that are as precise as one independent row
    - states, spreads: means (k, n) and covariances (k, n, n), relative to the prior mean, in units
      of the prior standard deviations
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
        self._falls = [name.startswith("fall_") for name in self.names]
        self._restless = np.zeros_like(self.means)
        self._squares = np.full(len(restrictions), variance * PRIOR_ROWS)
        self._rows = PRIOR_ROWS

    @property
    def weights(self) -> Vector:
        """Return the weights of the filters (k,), with sum 1.

        A filter for friction that falls with speed has a small weight if its estimate rises.
        """
        falls = (self.means + self.deviations * self.states)[:, self._falls]
        likely = (
            np.array(BEFOREHAND)
            + self._evidence
            + rising_penalty(falls, self.means[:, self._falls], self.deviations[:, self._falls])
        )
        over = np.exp(likely - np.max(likely))
        return np.asarray(over / np.sum(over))

    @property
    def noise(self) -> float:
        """Return the noise variance r of the filter with the smallest residual [(N m)^2 | N^2]."""
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
        walked = self._changes.add_move(
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

    def moments(self, *names: str) -> tuple[Vector, Matrix]:
        """Return means (m,) and covariance (m, m) of the m parameters `names` [SI]."""
        chosen = [self.names.index(name) for name in names]
        weights = self.weights
        deviations = self.deviations[:, chosen]
        values = self.means[:, chosen] + deviations * self.states[:, chosen]
        spreads = self.spreads[:, chosen][:, :, chosen]
        mean = weights @ values
        parts = deviations[:, :, None] * spreads * deviations[:, None, :]
        off = values - mean
        return mean, np.tensordot(weights, parts, 1) + (weights[:, None] * off).T @ off

    def value(self, name: str) -> tuple[float, float]:
        """Return mean and standard deviation of a parameter [SI]."""
        mean, covariance = self.moments(name)
        return float(mean[0]), math.sqrt(float(covariance[0, 0]))

    def interval(self, name: str, confidence: float) -> tuple[float, float]:
        """Return the central interval of a parameter's distribution, which is a mixture [SI]."""
        index = self.names.index(name)
        values = self.means[:, index] + self.deviations[:, index] * self.states[:, index]
        deviations = self.deviations[:, index] * np.sqrt(self.spreads[:, index, index])
        weights = self.weights
        # the quantile of a mixture lies between the quantiles of its parts
        parts = weights > 0.0
        tail = 0.5 * (1.0 - confidence)
        ends = []
        for share in (tail, 1.0 - tail):
            quantiles = (values + deviations * scipy.special.ndtri(share))[parts]
            low, high = float(np.min(quantiles)), float(np.max(quantiles))
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                below = float(weights @ scipy.special.ndtr((middle - values) / deviations))
                low, high = (middle, high) if below < share else (low, middle)
            ends.append(0.5 * (low + high))
        return ends[0], ends[1]

    def prior_deviation(self, name: str) -> float:
        """Return the largest prior standard deviation of a parameter over all filters [SI]."""
        return float(np.max(self.deviations[:, self.names.index(name)]))

    def unexplained(self, name: str, gram: Vector, rows: int) -> float:
        """Return the rms of the part of a regressor that the other regressors do not explain.

        The regressor is that of the parameter `name`. The other parameters are limited by their
        priors. `gram` (p + 1, p + 1) is the sum of row' row over `rows` rows.
        """
        size = gram.shape[0] - 1
        best = int(np.argmax(self.weights))
        columns = self._matrix * self.deviations[best]
        information = columns.T @ gram[:size, :size] @ columns / self.noise
        index = self.names.index(name)
        spread = np.linalg.inv(np.eye(len(self.names)) + information)[index, index]
        square = (1.0 / float(spread) - 1.0) * self.noise / self.deviations[best, index] ** 2
        return math.sqrt(max(square, 0.0) / rows)

    def _loosen(self, walked: Vector) -> None:
        """Increase the covariances by random steps with the standard deviations `walked` (k, n)."""
        self.spreads += walked[:, :, None] ** 2 * np.eye(walked.shape[1])

    def _information(self, move: Move) -> tuple[Vector, Vector, Vector]:
        """Return A (k, n, n), b (k, n) and the sum of the squared efforts (k,) of a move.

        A, b and the sum are relative to the prior mean; A and b are in units of the prior standard
        deviations.
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
        """Return the noise variance r for a move [(N m)^2 | N^2].

        r is the variance that earlier moves show. If the residual of this move is significantly
        larger, r includes this residual, so that a noisy first move has less weight. `left` (k,):
        squared residuals of the filters.
        """
        known = noise = self.noise
        # fitted without earlier moves, because a changed parameter is not noise
        free = np.broadcast_to(np.eye(missed.shape[1]), information.shape)
        for _ in range(PASSES):
            spreads = _gain(free, information, noise)
            moved = _times(spreads, missed) / noise
            squares = (
                left
                - 2.0 * np.einsum("ki,ki->k", moved, missed)
                + np.einsum("ki,kij,kj->k", moved, information, moved)
            )
            # degrees of freedom that the parameters take, in rows
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
        """Update the learned variance with the sums of squared residuals `left` (k,) of a move."""
        self._squares = self._squares + np.maximum(left, 0.0)
        self._rows = self._rows + rows
        if self._rows > MEMORY_ROWS:
            self._squares = self._squares * MEMORY_ROWS / self._rows
            self._rows = MEMORY_ROWS


def rising_penalty(falls: Vector, means: Vector, deviations: Vector) -> Vector:
    """Return log weights (k,) of filters: small if a filter estimates a negative fall.

    A fall is the friction that disappears as the speed rises; a negative fall means that friction
    rises. `falls`, and the prior `means` and `deviations` of the falls, are (k, m). The log weight
    is 0 if the prior contains no fall.
    """
    largest = np.max(deviations, axis=1, keepdims=True, initial=0.0)
    parts = (deviations > 0.5 * largest) & np.any(means > 0.0, axis=1, keepdims=True)
    negative = np.where(
        parts, np.minimum(falls, 0.0) / (NEGATIVE * np.where(largest > 0.0, largest, 1.0)), 0.0
    )
    return np.asarray(np.sum(scipy.special.log_ndtr(negative) + math.log(2.0), axis=1))


def _times(matrices: Vector, vectors: Vector) -> Vector:
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])


def _gain(spreads: Vector, information: Vector, noise: float) -> Vector:
    """Return K = (1 + P A/r)^-1 (k, n, n) with P `spreads`, A `information` and r `noise`.

    K P is the new covariance. K' e/r = A S^-1 e for an innovation e with the covariance S.
    """
    return np.asarray(np.linalg.inv(np.eye(spreads.shape[1]) + spreads @ information / noise))
