"""Structural alternatives, compared on strokes that a fit has not seen: a term that does not help to predict them is needless.

A term is dropped where its interval holds 0 and the held-out error is no larger without it: its value is then 0, its interval stays what
it was, since 0 is not known better than that; the others are fitted anew without its column.
"""

from __future__ import annotations

import numpy as np

from frictool.identify.record import Vector
from frictool.identify.regression import Singular, least, residual_norm
from frictool.identify.triangles import Numbers, Tensor


def held_out_norm(plain: Tensor, weighted: Tensor, half: Numbers, columns: list[int]) -> float | None:
    """Norm of the target's residuals, each predicted by a fit of `columns` to the other half of the runs; None where a half is too little.

    plain, weighted (g, q, q): the triangles of runs of rows, of q - 1 regressors and the target; half (g,) 0 or 1.
    """
    chosen, total = [*columns, -1], 0.0
    for side in (0, 1):
        seen = half != side
        try:
            value = least(weighted[seen][:, :, chosen])[0]
        except Singular:
            return None
        total += residual_norm(plain[~seen][:, :, chosen], value) ** 2
    return float(np.sqrt(total))


def needless(plain: Tensor, weighted: Tensor, half: Numbers, low: Vector, high: Vector, candidates: list[int]) -> list[int]:
    """Which of the candidate columns are needless; low, high (p,): the intervals of all columns. One after the other, the least first."""
    columns = list(range(low.size))
    told = [k for k in candidates if np.isfinite(low[k]) and np.isfinite(high[k])]
    for candidate in sorted(told, key=lambda k: abs(low[k] + high[k]) / (high[k] - low[k])):
        without = [k for k in columns if k != candidate]
        error, other = held_out_norm(plain, weighted, half, columns), held_out_norm(plain, weighted, half, without)
        if low[candidate] <= 0.0 <= high[candidate] and error is not None and other is not None and other <= error:
            columns = without
    return [k for k in candidates if k not in columns]
