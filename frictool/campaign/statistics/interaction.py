"""Interaction of two factors: the share of the variance that they explain only together.

    S_ij = Var(E[Y | X_i, X_j] - E[Y | X_i] - E[Y | X_j] + E[Y]) / Var(Y)

S_ij is the second-order Sobol index of the metric Y and the factors X_i, X_j (Sobol 1993). The
range of each factor is divided into slices; a cell is the intersection of a slice of X_i with a
slice of X_j. First, the mean in each slice is subtracted from Y, so that no first-order effect
remains. The variance of the cell means of this residual, minus the variance that is expected by
chance, is divided by Var(Y) to give S_ij. The standard deviation of S_ij is computed for factors
without an interaction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictool.campaign.statistics.slices import Slices, cross_slices
from frictool.campaign.statistics.sobol_indices import variance_share
from frictool.typing import Vector


class JointShare(NamedTuple):
    """Shares of the variance that two factors explain.

    `joint`: share that the two factors explain, alone or together.
    `beyond`: share that they explain only together, the second-order Sobol index.
    `error`: standard deviation of `beyond` for factors without an interaction.
    """

    joint: float
    beyond: float
    error: float


def joint_share(first: Slices, second: Slices, values: Vector, drawn: bool) -> JointShare:
    """Return the shares of two factors in the variance of `values` (n,).

    `drawn`: True for random trials; False if all vertices were simulated. The shares of all
        vertices are exact, so that their error is 0.
    """
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
    """Return the variance (k,) in each cell; a cell with a single draw gets the mean variance.

    `inside` (n,): difference of each draw's value from the mean of its cell.
    """
    squares = cells.sums(inside**2)
    sizes = cells.sizes
    pooled = float(squares.sum()) / max(1, inside.size - cells.count)
    return np.where(sizes > 1, squares / np.maximum(1, sizes - 1), pooled)
