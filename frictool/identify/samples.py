"""The rows of the regression, from the records of one or several logs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.identify.clusters import clusters
from frictool.identify.outcome import SLIDING, Fit, Interval, NothingUsable
from frictool.identify.record import Vector
from frictool.identify.regression import Singular, least, residual_norm, solve_triangles
from frictool.identify.triangles import Numbers, Tensor, triangles

ONE_DIRECTION = "the motion is in one direction only, in which Coulomb friction and offset are one number"


@dataclass(frozen=True)
class Samples:
    """Rows of effort = inertia a + viscous v + coulomb s + offset: (n,) in SI, `stroke` (n,) ascending; `sign`: s, filtered as the rest;

    `counts`: how many encoder counts pass in the row.
    """

    acceleration: Vector
    velocity: Vector
    effort: Vector
    stroke: Numbers
    sign: Vector
    counts: Vector

    @property
    def columns(self) -> tuple[Vector, ...]:
        """The regressors, each (n,), in the order of SLIDING."""
        return self.acceleration, self.velocity, self.sign, np.ones(self.sign.size)


def joined(parts: list[Samples]) -> Samples:
    """All rows, their strokes numbered through."""
    if len(parts) == 1:
        return parts[0]
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
    names, refused = parameters_of(samples)
    columns = (*samples.columns[: len(names)], samples.effort)
    cluster = clusters(samples.stroke, samples.sign, samples.counts, 3 * window)
    starts = np.flatnonzero(np.diff(cluster, prepend=-1) | np.diff(samples.stroke, prepend=-1))
    plain, weighted = triangles(columns, np.ones(weight.size), starts), triangles(columns, weight, starts)
    try:
        solution = solve_triangles(weighted, cluster[starts])
    except Singular as error:
        raise NothingUsable(str(error)) from None
    width = solution.half_width(confidence)
    found = {
        name: Interval(float(v), float(v - w), float(v + w))
        for name, v, w in zip(names, solution.value, width, strict=True)
        if name not in refused
    }
    size = float(np.linalg.norm(samples.effort))
    order = np.unique(samples.stroke[starts], return_inverse=True)[1]
    held_out = _held_out(plain, weighted, (order // 2) % 2)
    return Fit(
        found,
        refused,
        residual_norm(plain, solution.value) / size,
        None if held_out is None else held_out / size,
        solution.condition,
        samples.velocity.size,
        {**details, "strokes": int(order.max()) + 1, "clusters": int(cluster.max()) + 1},
    )


def parameters_of(samples: Samples) -> tuple[tuple[str, ...], dict[str, str]]:
    """Which columns are told apart, in the order of SLIDING, and what is refused. Raises NothingUsable where there are too few rows."""
    if samples.velocity.size < 2 * len(SLIDING):
        raise NothingUsable(f"only {samples.velocity.size} samples are certain to slip")
    if np.all(samples.sign > 0.0) or np.all(samples.sign < 0.0):
        return SLIDING[:3], {"coulomb": ONE_DIRECTION, "offset": ONE_DIRECTION}
    return SLIDING, {}


def _held_out(plain: Tensor, weighted: Tensor, half: Numbers) -> float | None:
    """Norm of the effort's residuals, each predicted by a fit to the other half of the strokes; None where a half does not suffice.

    plain, weighted (g, q, q): the triangles of runs of rows, half (g,) 0 or 1. The halves alternate in pairs of strokes, so that both
    hold both directions.
    """
    total = 0.0
    for side in (0, 1):
        seen = half != side
        try:
            total += residual_norm(plain[~seen], least(weighted[seen])[0]) ** 2
        except Singular:
            return None
    return float(np.sqrt(total))
