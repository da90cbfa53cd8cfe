"""Parameters that do not help to predict strokes that a fit has not seen.

A sliding parameter is dropped if its interval holds 0 and the held-out error is no larger without
it. Its value is then 0, its interval stays what it was, since 0 is not known better than that, and
the others are fitted again without its column. Loads beside friction are never dropped: the bench
declares them, or a search has already found that they help (`load_search`, `held_out`).
"""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

from frictool.identify.motion_record import Vector
from frictool.identify.regression.regression import SingularRegressors, least
from frictool.identify.regression.tsqr import Numbers, Tensor


def held_out_squares(
    plain: Tensor, weighted: Tensor, half: Numbers, columns: list[int]
) -> Vector | None:
    """Squares (g,) of each run's residuals, predicted by a fit of `columns` to the other half of
    the runs; None where a half is too little.

    plain, weighted (g, q, q): the triangles of runs of rows, of q - 1 regressors and the target;
    half (g,) 0 or 1.
    """
    chosen, squares = [*columns, -1], np.empty(half.size)
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
    plain: Tensor, weighted: Tensor, half: Numbers, columns: list[int]
) -> float | None:
    """The norm of all of them."""
    squares = held_out_squares(plain, weighted, half, columns)
    return None if squares is None else float(np.sqrt(np.sum(squares)))


def beyond_chance(richer: Vector, simpler: Vector, confidence: float) -> bool:
    """Whether the richer one's squares (s,), one a stroke, are smaller by more than chance:
    Student's test of the pairs."""
    gain = simpler - richer
    if gain.size < 2:
        return False
    error = float(np.std(gain, ddof=1)) / np.sqrt(gain.size)
    return bool(np.mean(gain) > float(stdtrit(gain.size - 1, confidence)) * error)


def by_stroke(squares: Vector, stroke: Numbers) -> Vector:
    """The sums (s,) of the runs' squares (g,) over the runs of each stroke."""
    return np.asarray(np.bincount(stroke, squares), dtype=np.float64)


def needless(
    plain: Tensor,
    weighted: Tensor,
    stroke: Numbers,
    low: Vector,
    high: Vector,
    candidates: list[int],
) -> list[int]:
    """Return the candidates' columns that are needless, tried one after the other, the least
    significant first.

    low, high (p,): the intervals of all columns. stroke (g,): of each run.
    """
    half, columns = halved(stroke), list(range(low.size))
    finite = [k for k in candidates if np.isfinite(low[k]) and np.isfinite(high[k])]
    for k in sorted(finite, key=lambda k: float(abs(low[k] + high[k]) / (high[k] - low[k]))):
        without = [other for other in columns if other != k]
        error, other_error = (
            held_out_norm(plain, weighted, half, columns),
            held_out_norm(plain, weighted, half, without),
        )
        if (
            error is not None
            and other_error is not None
            and low[k] <= 0.0 <= high[k]
            and other_error <= error
        ):
            columns = without
    return [k for k in candidates if k not in columns]


def halved(stroke: Numbers) -> Numbers:
    """0 or 1 (g,): pairs of strokes, so that both halves hold both directions."""
    return (stroke // 2) % 2
