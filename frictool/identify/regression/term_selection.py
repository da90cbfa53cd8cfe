"""Selection of parameters by the prediction of strokes that the fit did not use.

Each half of the strokes is predicted by a fit to the other half. A sliding parameter is dropped if
its interval contains 0 and the prediction error does not increase without the parameter. The
dropped parameter has the value 0 but keeps its interval, since the data do not show that the
parameter is exactly 0. The other parameters are then fitted again. Load terms are never dropped:
the bench declares them, or a search has shown that they improve the prediction
(`explanation_search`, `structure_selection`).
"""

from __future__ import annotations

import numpy as np
import scipy

from frictool.identify.regression.regression import SingularRegressors, least
from frictool.identify.regression.tsqr import Tensor
from frictool.typing import IntVector, Vector

# largest rms prediction error with added parameters, relative to the error without them
WORTH = 0.8


def held_out_squares(
    plain: Tensor, weighted: Tensor, half: IntVector, columns: list[int]
) -> Vector | None:
    """Return the squared prediction error (g,) of each group of rows, by a fit to the other half.

    - plain, weighted: triangular matrices (g, q, q) of g groups of successive rows, without and
      with weights
    - half: half of the data to which each group belongs, 0 or 1, (g,)
    - columns: indices of the regressors; the last column is the target

    Return None if one half of the data does not determine the fit.
    """
    chosen = [*columns, -1]
    squares = np.empty(half.size)
    for side in (0, 1):
        seen = half != side
        try:
            value = least(weighted[seen][:, :, chosen])[0]
        except SingularRegressors:
            return None
        parts = plain[~seen][:, :, chosen]
        squares[~seen] = np.sum((parts[:, :, -1] - parts[:, :, :-1] @ value) ** 2, axis=1)
    return squares


def held_out_norm(
    plain: Tensor, weighted: Tensor, half: IntVector, columns: list[int]
) -> float | None:
    """Return the root of the sum of `held_out_squares`, or None if these are None."""
    squares = held_out_squares(plain, weighted, half, columns)
    return None if squares is None else float(np.sqrt(np.sum(squares)))


def beyond_chance(richer: Vector, simpler: Vector, confidence: float) -> bool:
    """Return True if a richer model predicts the strokes significantly better than a simpler one.

    `richer` and `simpler` are the squared prediction errors of s strokes, (s,), by the two models.
    The test is Student's test of s pairs at the level `confidence`.
    """
    gain = simpler - richer
    if gain.size < 2:
        return False
    error = float(np.std(gain, ddof=1)) / np.sqrt(gain.size)
    return bool(np.mean(gain) > float(scipy.special.stdtrit(gain.size - 1, confidence)) * error)


def clearly_better(richer: Vector | None, simpler: Vector | None, confidence: float) -> bool:
    """Return True if a richer model predicts the strokes clearly better than a simpler one.

    `richer` and `simpler` are the squared prediction errors of s strokes, (s,), by the two models.
    The errors must be significantly smaller, and their sum must be below WORTH^2 times the sum of
    `simpler`. Return False if one of the models has no errors (None).
    """
    if richer is None or simpler is None:
        return False
    small = bool(np.sum(richer) < WORTH**2 * np.sum(simpler))
    return small and beyond_chance(richer, simpler, confidence)


def by_stroke(squares: Vector, stroke: IntVector) -> Vector:
    """Return the sum of `squares` (g,) over the groups of rows in each stroke, (s,)."""
    return np.asarray(np.bincount(stroke, squares), dtype=np.float64)


def needless(
    plain: Tensor,
    weighted: Tensor,
    stroke: IntVector,
    low: Vector,
    high: Vector,
    candidates: list[int],
) -> list[int]:
    """Return the columns of `candidates` that do not improve the prediction.

    The columns are removed one at a time, beginning with the least significant column. A column
    whose interval does not contain 0 is kept.

    - plain, weighted: triangular matrices (g, q, q) of g groups of rows, without and with weights
    - stroke: number of the stroke to which each group belongs, (g,)
    - low, high: ends of the intervals of all columns, (p,)
    """
    half = halved(stroke)
    columns = list(range(low.size))
    finite = [k for k in candidates if np.isfinite(low[k]) and np.isfinite(high[k])]
    for k in sorted(finite, key=lambda k: float(abs(low[k] + high[k]) / (high[k] - low[k]))):
        without = [other for other in columns if other != k]
        error = held_out_norm(plain, weighted, half, columns)
        other_error = held_out_norm(plain, weighted, half, without)
        if (
            error is not None
            and other_error is not None
            and low[k] <= 0.0 <= high[k]
            and other_error <= error
        ):
            columns = without
    return [k for k in candidates if k not in columns]


def halved(stroke: IntVector) -> IntVector:
    """Return 0 or 1 for each group of rows (g,): the half of the strokes with this group.

    Pairs of successive strokes stay together, so that each half has both directions.
    """
    return (stroke // 2) % 2
