"""The rows of the regression, from the records of one or several logs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.identify.clusters import clusters
from frictool.identify.outcome import SLIDING, Fit, Interval, NothingUsable
from frictool.identify.record import Vector
from frictool.identify.regression import Singular, solve


@dataclass(frozen=True)
class Samples:
    """Rows of effort = inertia a + viscous v + coulomb s + offset: (n,) in SI, `stroke` (n,) ascending; `sign`: s, filtered as the rest;

    `counts`: how many encoder counts pass in the row.
    """

    acceleration: Vector
    velocity: Vector
    effort: Vector
    stroke: NDArray[np.int64]
    sign: Vector
    counts: Vector

    @property
    def regressors(self) -> NDArray[np.float64]:
        """(n, 4), in the order of SLIDING."""
        return np.column_stack((self.acceleration, self.velocity, self.sign, np.ones(self.sign.size)))


def joined(parts: list[Samples]) -> Samples:
    """All rows, their strokes numbered through."""
    strokes, above = [], 0
    for part in parts:
        strokes.append(part.stroke + above)
        above += int(part.stroke[-1]) + 1 if part.stroke.size else 0
    stack = [np.concatenate([getattr(p, name) for p in parts]) for name in ("acceleration", "velocity", "effort", "sign", "counts")]
    return Samples(stack[0], stack[1], stack[2], np.concatenate(strokes), stack[3], stack[4])


def fit(samples: Samples, weight: Vector, window: int, confidence: float, details: dict[str, float | int]) -> Fit:
    """Weighted least squares on `samples`, weight (n,); a residual is correlated over `window` rows.

    Raises NothingUsable where there are too few rows. Where the axis moves in one direction only, Coulomb friction and offset are
    one number and both are refused.
    """
    if samples.velocity.size < 2 * len(SLIDING):
        raise NothingUsable(f"only {samples.velocity.size} samples are certain to slip")
    refused: dict[str, str] = {}
    names, columns = list(SLIDING), samples.regressors
    if np.all(samples.sign > 0.0) or np.all(samples.sign < 0.0):
        names, columns = names[:3], columns[:, :3]
        reason = "the motion is in one direction only, in which Coulomb friction and offset are one number"
        refused = {"coulomb": reason, "offset": reason}
    cluster = clusters(samples.stroke, samples.sign, samples.counts, 3 * window)
    try:
        solution = solve(columns, samples.effort, weight, cluster)
    except Singular as error:
        raise NothingUsable(str(error)) from None
    width = solution.half_width(confidence)
    found = {
        name: Interval(float(v), float(v - w), float(v + w))
        for name, v, w in zip(names, solution.value, width, strict=True)
        if name not in refused
    }
    residual = samples.effort - columns @ solution.value
    size = float(np.linalg.norm(samples.effort))
    held_out = _held_out(columns, samples, weight)
    return Fit(
        found,
        refused,
        float(np.linalg.norm(residual)) / size,
        None if held_out is None else held_out / size,
        solution.condition,
        samples.velocity.size,
        {**details, "strokes": int(np.unique(samples.stroke).size), "clusters": int(cluster.max()) + 1},
    )


def _held_out(columns: NDArray[np.float64], samples: Samples, weight: Vector) -> float | None:
    """Norm of the effort's residuals, each predicted by a fit to the other half of the strokes; None where a half does not suffice.

    The halves alternate in pairs of strokes, so that both hold both directions.
    """
    order = np.unique(samples.stroke, return_inverse=True)[1]
    half, total = (order // 2) % 2, 0.0
    for side in (0, 1):
        seen, unseen = half != side, half == side
        try:
            value = solve(columns[seen], samples.effort[seen], weight[seen], order[seen]).value
        except Singular:
            return None
        total += float(np.sum((samples.effort[unseen] - columns[unseen] @ value) ** 2))
    return float(np.sqrt(total))
