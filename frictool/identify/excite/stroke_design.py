"""Optimal numbers of repetitions of candidate strokes, by a convex program with rounding.

Candidate stroke k has the duration tau_k, and is repeated x_k times. Its information matrix M_k is
the inverse of the covariance of the parameters. The shortest test for the half widths h_i of the
parameters i is the solution of

    minimise    sum tau_k x_k
    subject to  e_i' (sum x_k M_k)^-1 e_i <= (h_i/q_i)^2       for each requested parameter
                sum tau_k x_k (rms_k^2 - rms^2) <= 0           drive, if it has an rms limit
                x_k >= 0

(Pukelsheim 2006, chapter 6; Boyd and Vandenberghe 2004, 7.5). e_i is the i-th unit vector. q_i is
the expected half width of parameter i divided by its standard deviation at the Cramér-Rao bound.
rms_k is the rms drive signal of candidate k, and rms the largest allowed rms drive signal of the
test, both divided by the drive's limit.

The most precise test of a given duration minimises the largest ratio of a parameter's variance to
its limit. A pause is a candidate whose information matrix and drive signal are 0.

All x_k are rounded up. Repetitions are then removed one by one, the longest strokes first, as long
as every constraint is met.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from frictool.lmi.optimal_design import optimal_shares
from frictool.typing import IntVector, Matrix, Vector

FEWEST_PAIRS = 8  # least number of strokes forward and backward; intervals need several strokes
NEGLIGIBLE = 1e-4  # number of repetitions, or share of the duration, that is treated as 0
SCALES = 8.0  # decades below and above 1 in which the common factor of the limits is searched
BISECTIONS = 24
MOST_EXCHANGED = 40  # largest number of repetitions in a test whose strokes are exchanged
SINGULAR = 1e12  # condition number above which information is singular


@dataclass(frozen=True)
class StrokeProgram:
    """Convex program for the numbers of repetitions of k candidates and p parameters.

    - information: information matrices of the candidates, (k, p, p)
    - duration: durations of the candidates, (k,), s
    - mean_square: mean square of the ratio of drive signal to drive limit, (k,)
    - limit: largest allowed variance of each parameter, (p,); inf for a parameter that is not
      requested
    - rms: largest allowed rms drive signal of the test, divided by the drive's limit
    """

    information: Matrix
    duration: Vector
    mean_square: Vector
    limit: Vector
    rms: float = math.inf

    def variances(self, times: Vector) -> Vector:
        """Return the Cramér-Rao variances (p,) of a test.

        `times` (k,): number of repetitions of each candidate. A variance is inf if the test does
        not determine the parameter.
        """
        matrix = np.tensordot(times, self.information, axes=1)
        scale = np.sqrt(np.diag(matrix))
        if not np.all(scale > 0.0):
            return np.full(scale.size, math.inf)
        unit = matrix / np.outer(scale, scale)
        if np.linalg.cond(unit) > SINGULAR:
            return np.full(scale.size, math.inf)
        return np.asarray(np.diag(np.linalg.inv(unit)) / scale**2)

    def worst(self, times: Vector) -> float:
        """Return the largest ratio of a variance to its limit.

        `times` (k,): number of repetitions of each candidate.
        """
        known = self.requested
        return float((self.variances(times)[known] / self.limit[known]).max())

    def allowed(self, times: Vector) -> bool:
        """Return True if the rms drive signal is within its limit and there are enough strokes.

        `times` (k,): number of repetitions of each candidate.
        """
        total = float(times @ self.duration)
        square = float((times * self.duration) @ self.mean_square)
        moving = float(times[self.mean_square > 0.0].sum())
        return square <= self.rms**2 * total * (1.0 + 1e-9) and moving >= FEWEST_PAIRS

    @property
    def requested(self) -> IntVector:
        """Return the indices of the parameters for which a precision is requested."""
        return np.asarray(np.flatnonzero(np.isfinite(self.limit)), dtype=np.int64)


def shortest(program: StrokeProgram) -> Vector | None:
    """Return the repetitions (k,) of the shortest test; None if no test meets the limits."""
    shares = _shares(program)
    return None if shares is None else _rounded(program, shares)


def best_within(program: StrokeProgram, duration: float) -> Vector | None:
    """Return the repetitions (k,) of the most precise test of at most `duration` [s].

    The variance limits are multiplied by a common factor such that the shortest test has this
    duration. Return None if no factor gives such a test.
    """
    shares = _shares(program)
    if shares is None:
        return None
    best = None
    low, high = -SCALES, SCALES
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        scaled = replace(program, limit=program.limit * 10.0**middle)
        if program.worst(shares / program.duration) * 10.0**-middle > duration:
            low = middle
            continue
        times = _rounded(scaled, shares)
        if float(times @ program.duration) <= duration:
            best = times
            high = middle
        else:
            low = middle
    return best


def _rounded(program: StrokeProgram, shares: Vector) -> Vector:
    worst = program.worst(shares / program.duration)
    times = np.maximum(np.ceil(worst * shares / program.duration - NEGLIGIBLE), shares > 0.0)
    return _shortened(program, _pruned(program, times))


def _one_more(times: Vector, index: int) -> Vector:
    more = times.copy()
    more[index] += 1.0
    return more


def _shares(program: StrokeProgram) -> Vector | None:
    """Return the fraction of the duration per candidate, (k,), that minimises `worst`, or None."""
    rate = program.information / program.duration[:, None, None]
    shares = optimal_shares(rate, program.limit, program.mean_square - program.rms**2)
    if shares is None:
        return None
    shares = np.where(shares < NEGLIGIBLE, 0.0, shares)
    return np.asarray(shares / shares.sum())


def _pruned(program: StrokeProgram, times: Vector) -> Vector:
    """Add strokes to `times` (k,) until all constraints hold, then remove needless strokes."""
    while not program.allowed(times) or program.worst(times) > 1.0:
        support = np.flatnonzero(times)
        scores = [program.worst(_one_more(times, int(one))) for one in support]
        times = (
            _one_more(times, int(support[int(np.argmin(scores))]))
            if program.worst(times) > 1.0
            else _allowed_more(program, times)
        )
    removed = True
    while removed:
        removed = False
        for one in sorted(np.flatnonzero(times), key=lambda k: -float(program.duration[k])):
            fewer = times.copy()
            fewer[one] -= 1.0
            if program.allowed(fewer) and program.worst(fewer) <= 1.0:
                times = fewer
                removed = True
    return times


def _allowed_more(program: StrokeProgram, times: Vector) -> Vector:
    pauses = np.flatnonzero(program.mean_square == 0.0)
    moving = np.flatnonzero((times > 0.0) & (program.mean_square > 0.0))
    short = times[moving].sum() < FEWEST_PAIRS or not pauses.size
    chosen = int(moving[np.argmin(program.duration[moving])]) if short else int(pauses[0])
    return _one_more(times, chosen)


def _shortened(program: StrokeProgram, times: Vector) -> Vector:
    if times.sum() > MOST_EXCHANGED:
        return times
    by_duration = np.argsort(program.duration, kind="stable")
    for one in sorted(np.flatnonzero(times), key=lambda k: -float(program.duration[k])):
        for _ in range(int(times[one])):
            fewer = times.copy()
            fewer[one] -= 1.0
            shorter = by_duration[program.duration[by_duration] < program.duration[one]]
            exchanged = (
                more
                for other in shorter
                if program.mean_square[other] > 0.0
                for more in [_one_more(fewer, int(other))]
                if program.allowed(more) and program.worst(more) <= 1.0
            )
            better = next(exchanged, None)
            if better is None:
                break
            times = better
    return times
