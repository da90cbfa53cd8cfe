"""Variance of a least-squares fit whose residual repeats at the same positions or phases.

An effect that the model lacks leaves the same residual in every stroke, at the same positions or at
the same phases of the strokes. The variance over strokes does not see it. Rows are therefore
grouped a second time, by bins of the position, of the phase or of the time, and the variance over
these groups is added, less the part that both groupings share (Cameron, Gelbach and Miller, 2011):

    V = V_strokes + (V_bins - V_both),    V_groups = sum over groups (sum over rows psi)^2

"Both" are the runs of rows in one stroke and one bin. psi = (X^T X)^-1 x r is the influence of a
row x with the residual r. The residual of a model that lacks nothing is independent between these
runs. The two terms in brackets are then equal on average; the first one has a relative standard
deviation of sqrt(2/bins), and only what exceeds it counts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictool.typing import IntVector, Matrix, Vector


def shared_variance(
    columns: Matrix, residual: Vector, stroke: IntVector, groups: Sequence[IntVector]
) -> Vector:
    """Return the variance (p,) that each further grouping adds to the variance over strokes.

    Parameters
    ----------
    columns
        Regressors (n, p).
    residual
        Residuals (n,) of the fit.
    stroke
        Stroke (n,) of each row.
    groups
        Further groupings; each is the number (n,) of the group of each row, from 0.

    Returns
    -------
    Vector
        Sum over the groupings, (p,), in squares of the parameters' units.
    """
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / scale
    influence = (scaled * residual[:, None]) @ np.linalg.pinv(scaled.T @ scaled)
    out = np.zeros(scale.size)
    for group in groups:
        count = int(group.max()) + 1
        # the residual is orthogonal to p regressors, which lowers the squares of a few groups
        factor = count / max(count - scale.size, 1.0)
        both = np.unique(stroke.astype(np.int64) * count + group, return_inverse=True)[1]
        chance = 1.0 + np.sqrt(2.0 / count)
        squares = factor * _squares(influence, group) - chance * _squares(influence, both)
        out += np.maximum(squares, 0.0)
    return np.asarray(out / scale**2)


def _squares(influence: Matrix, group: IntVector) -> Vector:
    """Return the sums (p,) over groups of the squared sums of the influences (n, p)."""
    sums = np.array([np.bincount(group, one) for one in influence.T])
    return np.asarray(np.sum(sums**2, axis=1))


def equal_bins(values: Vector, count: int) -> IntVector:
    """Return the number (n,) of the bin of each value; each bin has as many values."""
    edges = np.quantile(values, np.arange(1, count) / count)
    return np.searchsorted(edges, values).astype(np.int64)
