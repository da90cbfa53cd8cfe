"""What two factors do only together: the part of the variance of a value that cells of their plane
explain, and neither factor alone.

    S_ij = Var(E[Y | X_i, X_j] - E[Y | X_i] - E[Y | X_j] + E[Y]) / Var(Y)        Sobol 1993, second
                                                                                 order

Cell means are taken of what the slices of each factor leave, so that unequal cells carry nothing of
what one factor does alone. What they vary by chance is taken off cell by cell, since pass or fail
varies more where both happen; so is the error, of cells where nothing is beyond.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.campaign.statistics.slices import Slices, cross_slices
from frictool.campaign.statistics.sobol_indices import variance_share

Vector = NDArray[np.float64]


class JointShare(NamedTuple):
    """joint: the share of the variance that the cells explain; beyond: S_ij; error: its standard
    deviation where there is none."""

    joint: float
    beyond: float
    error: float


def joint_share(first: Slices, second: Slices, values: Vector, drawn: bool) -> JointShare:
    """Of values (n,) in the plane of two factors; of vertices that were all played (not drawn),
    exact and without an error."""
    centred = values - values.mean()
    total = float(centred @ centred)
    cells = cross_slices(first, second)
    if total == 0.0 or (drawn and values.size <= cells.count):
        return JointShare(0.0, 0.0, 0.0)
    left = (
        centred
        - (first.sums(centred) / first.sizes)[first.of]
        - (second.sums(centred) / second.sizes)[second.of]
    )
    means = cells.sums(left) / cells.sizes
    explained = float(cells.sizes @ means**2)
    joint = variance_share(cells, values, drawn)[0]
    if not drawn:
        return JointShare(joint, explained / total, 0.0)
    noise = _noise(cells, left - means[cells.of])
    freedom = max(0.0, cells.count - first.count - second.count + 1.0) / cells.count
    beyond = (explained - freedom * float(noise.sum())) / total
    return JointShare(joint, beyond, float(np.sqrt(2.0 * freedom * float(noise @ noise))) / total)


def _noise(cells: Slices, inside: Vector) -> Vector:
    """The variance (k,) inside of each cell; of a cell with one draw, that of all."""
    squares, sizes = cells.sums(inside**2), cells.sizes
    pooled = float(squares.sum()) / max(1, inside.size - cells.count)
    return np.where(sizes > 1, squares / np.maximum(1, sizes - 1), pooled)
