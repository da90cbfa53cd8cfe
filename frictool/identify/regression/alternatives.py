"""Structural alternatives, compared on strokes that a fit has not seen: a term that does not help to predict them is needless.

A sliding parameter is dropped where its interval holds 0 and the held-out error is no larger without it; a load beside friction also
where the error is smaller with it by no more than chance (Student's test of the strokes' squares). Its value is then 0, its interval stays
what it was, since 0 is not known better than that; the others are fitted anew without its columns.
"""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

from frictool.identify.record import Vector
from frictool.identify.regression.regression import Singular, least
from frictool.identify.regression.triangles import Numbers, Tensor


def held_out_squares(plain: Tensor, weighted: Tensor, half: Numbers, columns: list[int]) -> Vector | None:
    """Squares (g,) of each run's residuals, predicted by a fit of `columns` to the other half of the runs; None where a half is too little.

    plain, weighted (g, q, q): the triangles of runs of rows, of q - 1 regressors and the target; half (g,) 0 or 1.
    """
    chosen, squares = [*columns, -1], np.empty(half.size)
    for side in (0, 1):
        seen = half != side
        try:
            value = least(weighted[seen][:, :, chosen])[0]
        except Singular:
            return None
        parts = plain[~seen][:, :, chosen]
        squares[~seen] = np.sum((parts[:, :, -1] - parts[:, :, :-1] @ value) ** 2, axis=1)
    return squares


def held_out_norm(plain: Tensor, weighted: Tensor, half: Numbers, columns: list[int]) -> float | None:
    """The norm of all of them."""
    squares = held_out_squares(plain, weighted, half, columns)
    return None if squares is None else float(np.sqrt(np.sum(squares)))


def beyond_chance(richer: Vector, simpler: Vector, confidence: float) -> bool:
    """Whether the richer one's squares (s,), one a stroke, are smaller by more than chance: Student's test of the pairs."""
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
    candidates: list[list[int]],
    confidence: float | None = None,
    gone: list[int] | None = None,
) -> list[int]:
    """Which of the candidates' columns are needless; low, high (p,): the intervals of all columns. One after the other, the least first.

    stroke (g,): of each run. candidates: the columns of each; those of one stay or go together. confidence: of being better by more than
    chance, which is then asked for. gone: columns that are out already.
    """
    half, columns = halved(stroke), [k for k in range(low.size) if k not in (gone or [])]
    told = [own for own in candidates if np.all(np.isfinite(low[own])) and np.all(np.isfinite(high[own]))]
    for own in sorted(told, key=lambda own: float(np.max(np.abs(low[own] + high[own]) / (high[own] - low[own])))):
        without = [k for k in columns if k not in own]
        squares, other = held_out_squares(plain, weighted, half, columns), held_out_squares(plain, weighted, half, without)
        if squares is None or other is None or not np.all((low[own] <= 0.0) & (high[own] >= 0.0)):
            continue
        worth = bool(np.sum(other) > np.sum(squares))
        if confidence is not None:
            worth = worth and beyond_chance(by_stroke(squares, stroke), by_stroke(other, stroke), confidence)
        if not worth:
            columns = without
    return [k for own in candidates for k in own if k not in columns]


def halved(stroke: Numbers) -> Numbers:
    """0 or 1 (g,): pairs of strokes, so that both halves hold both directions."""
    return (stroke // 2) % 2
