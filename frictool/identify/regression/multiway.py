"""Variance of a least-squares fit whose residual repeats at the same positions or phases.

An effect that the model does not include leaves the same residual in every stroke, at the same
positions or phases. Rows are therefore grouped twice: by strokes, and by bins of position, phase or
time (Cameron, Gelbach and Miller, 2011):

    V = V_strokes + (V_bins - V_both),    V_groups = sum over groups (sum over rows psi)^2

V_strokes has one group for each stroke, V_bins one for each bin, and V_both one for each pair of
stroke and bin. X contains the regressors of all rows. psi = (X^T X)^-1 x r is the influence of a
row x with the residual r on the parameters. If the model is complete, V_bins and V_both are equal
on average. V_bins then has a relative standard deviation of sqrt(2/bins); the part of V_bins -
V_both within this deviation is not added.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictool.typing import IntVector, Matrix, Vector


def shared_variance(
    columns: Matrix, residual: Vector, stroke: IntVector, groups: Sequence[IntVector]
) -> Vector:
    """Return the additional variance (p,) of the parameters that groups other than strokes show.

    Parameters
    ----------
    columns
        Regressors (n, p).
    residual
        Residuals (n,) of the fit.
    stroke
        Number (n,) of the stroke of each row.
    groups
        Additional groupings, each as the group number (n,) of every row, from 0.

    Returns
    -------
    Vector
        Sum of the added variances over the groupings, (p,), in squared units of the parameters.
    """
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / scale
    influence = (scaled * residual[:, None]) @ np.linalg.pinv(scaled.T @ scaled)
    out = np.zeros(scale.size)
    for group in groups:
        count = int(group.max()) + 1
        # with few groups, the fit of p parameters makes the squares too small
        factor = count / max(count - scale.size, 1.0)
        both = np.unique(stroke.astype(np.int64) * count + group, return_inverse=True)[1]
        chance = 1.0 + np.sqrt(2.0 / count)
        squares = factor * _squares(influence, group) - chance * _squares(influence, both)
        out += np.maximum(squares, 0.0)
    return np.asarray(out / scale**2)


def _squares(influence: Matrix, group: IntVector) -> Vector:
    sums = np.array([np.bincount(group, one) for one in influence.T])
    return np.asarray(np.sum(sums**2, axis=1))


def equal_bins(values: Vector, count: int) -> IntVector:
    """Return the bin number (n,) of each value, for `count` bins with equally many values."""
    edges = np.quantile(values, np.arange(1, count) / count)
    return np.searchsorted(edges, values).astype(np.int64)
