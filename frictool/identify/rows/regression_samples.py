"""Regression rows of one or several logs, and their weighted least-squares fit."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.identify.fit_result import (
    SLIDING,
    Interval,
    SlidingFit,
    UnusableLogs,
    intervals_around,
)
from frictool.identify.interval_checks import NEVER_NEGATIVE
from frictool.identify.regression.clusters import clusters
from frictool.identify.regression.regression import least, residual_norm, solve_triangles
from frictool.identify.regression.term_selection import halved, held_out_norm, needless
from frictool.identify.regression.tsqr import Tensor, triangles
from frictool.identify.rows.load_columns import by_direction, indistinct_terms
from frictool.identify.rows.omitted_parameters import OmittedParameters
from frictool.typing import IntVector, Vector

# least number of strokes in each direction; with a single stroke, a difference between directions
# cannot be separated from a difference between strokes
FEWEST_STROKES = 2
ONE_DIRECTION = (
    "the motion has one direction only, so that Coulomb friction and offset cannot be separated; "
    "record both directions, or state mechanics.offset in the bench"
)
NO_OFFSET = "the bench declares no offset (load.terms)"
KNOWN_OFFSET = {
    "offset": "the motion has one direction only; the bench's offset is subtracted from the "
    "Coulomb friction"
}
# fields of RegressionSamples with one value per row
ROW_SIGNALS = ("acceleration", "velocity", "effort", "stroke", "sign", "counts")


@dataclass(frozen=True)
class RegressionSamples:
    """Rows of the equation effort = inertia a + viscous v + coulomb s + offset.

    - acceleration, velocity, effort: signals in SI units, with the same filter, (n,)
    - stroke: ascending number of the stroke, (n,)
    - sign: direction s of the motion, filtered like the signals, (n,)
    - counts: distance between successive rows, in encoder counts, (n,)
    - known_offset: offset of the bench, N m | N, or None. Without this offset, motion in one
      direction does not determine Coulomb friction.
    - loads: column (n,) of each parameter of the declared loads, without the offset
    - terms, most: `load.terms` and `load.most` of the bench
    - fixed: parameters whose effort was subtracted from `effort` (`with_fixed`)
    - noise: rms acceleration by white noise of the position, rad/s^2 | m/s^2
    """

    acceleration: Vector
    velocity: Vector
    effort: Vector
    stroke: IntVector
    sign: Vector
    counts: Vector
    known_offset: Interval | None = None
    loads: dict[str, Vector] = field(default_factory=dict)
    terms: tuple[str, ...] | None = None
    most: float | None = None
    fixed: Mapping[str, Interval] = field(default_factory=dict)
    noise: float = 0.0

    @property
    def split_coulomb(self) -> bool:
        """Return True if Coulomb friction differs by direction; the offset is then not fitted."""
        return self.terms is not None and "coulomb_by_direction" in self.terms

    @property
    def columns(self) -> tuple[Vector, ...]:
        """Return the regressors of inertia, viscous, Coulomb and offset, each (n,)."""
        return self.acceleration, self.velocity, self.sign, np.ones(self.sign.size)

    @cached_property
    def unexplained_acceleration(self) -> float:
        """Return the rms acceleration that other regressors do not explain, rad/s^2 | m/s^2."""
        others = np.array([*self.columns[1:], *self.loads.values()])
        shared = others @ self.acceleration
        explained = shared @ np.linalg.lstsq(others @ others.T, shared, rcond=None)[0]
        left = self.acceleration @ self.acceleration - explained
        return float(np.sqrt(max(left, 0.0) / self.acceleration.size))

    @property
    def one_direction(self) -> bool:
        """Return True if the motion has one direction only."""
        return bool(np.all(self.sign > 0.0) or np.all(self.sign < 0.0))

    @property
    def known_effort(self) -> Vector:
        """Return the effort (n,) [N m | N] of the fixed parameters.

        If the motion has one direction and Coulomb friction is fixed, the effort includes the known
        offset.
        """
        out = np.zeros(self.sign.size)
        for name, column in zip(SLIDING, self.columns, strict=True):
            if name in self.fixed:
                out += self.fixed[name].value * column
        if "coulomb" in self.fixed and self.one_direction and self.known_offset is not None:
            out += self.known_offset.value
        return out

    def rows(self, chosen: NDArray[np.bool_]) -> RegressionSamples:
        """Return the rows selected by the mask `chosen` (n,)."""
        loads = {name: column[chosen] for name, column in self.loads.items()}
        signals = {name: getattr(self, name)[chosen] for name in ROW_SIGNALS}
        return replace(self, loads=loads, **signals)


def without_loads(samples: RegressionSamples, names: Collection[str]) -> RegressionSamples:
    """Return the samples without the columns of the load parameters `names`."""
    return replace(
        samples, loads={name: one for name, one in samples.loads.items() if name not in names}
    )


def with_fixed(samples: RegressionSamples, fixed: Mapping[str, Interval]) -> RegressionSamples:
    """Return the samples without the effort due to the parameters `fixed`."""
    if not fixed:
        return samples
    known = replace(samples, fixed=fixed)
    return replace(known, effort=samples.effort - known.known_effort)


def joined(parts: list[RegressionSamples]) -> RegressionSamples:
    """Return the rows of all parts in one table, with strokes numbered consecutively."""
    if len(parts) == 1:
        return parts[0]
    strokes = []
    above = 0
    for part in parts:
        strokes.append(part.stroke + above)
        above += int(part.stroke[-1]) + 1 if part.stroke.size else 0
    stacked: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ROW_SIGNALS
        if name != "stroke"
    }
    loads = {name: np.concatenate([part.loads[name] for part in parts]) for name in parts[0].loads}
    sizes = [part.velocity.size for part in parts]
    power = np.dot(sizes, [part.noise**2 for part in parts]) / max(sum(sizes), 1)
    noise = float(np.sqrt(power))
    return replace(parts[0], stroke=np.concatenate(strokes), loads=loads, noise=noise, **stacked)


def fit(
    samples: RegressionSamples,
    weight: Vector,
    window: int,
    confidence: float,
    details: dict[str, float | int],
    droppable: tuple[str, ...] = (),
) -> SlidingFit:
    """Return a least-squares fit of the samples with weights `weight` (n,).

    Residuals are assumed to be correlated over `window` rows. `details` are added to the result.

    - Parameters in `droppable` that do not improve the prediction (`term_selection`) are dropped:
      these parameters are set to 0, and the others are fitted again. The intervals of the others
      allow for every value in the interval of a dropped parameter.
    - A load is reported as not identified if the travel is too short to separate the load from
      other terms. The possible effect of this load widens the other intervals
      (`omitted_parameters`).
    - If the motion has one direction only, the offset is reported as not identified. If, in
      addition, the bench states no offset, Coulomb friction is also reported as not identified.

    Raises UnusableLogs if there are too few rows, or if the regressors are dependent.
    """
    names, refused = parameters_of(samples)
    plain, weighted, cluster, order = reduced(samples, weight, len(names), window)
    names = (*names, *samples.loads)
    whole = names, weighted
    free, free_plain, _ = _without(names, list(samples.fixed), plain, weighted)
    unknown = indistinct_terms(free_plain, free, samples.velocity.size)
    refused |= unknown
    droppable = tuple(name for name in droppable if name in names and name not in samples.fixed)
    outside = OmittedParameters(names, weighted, samples.fixed, tuple(unknown))
    outside.add_loads(samples.loads, samples.most, cluster, confidence)
    names, plain, weighted = _without(
        names, [name for name in names if name in samples.fixed or name in unknown], plain, weighted
    )
    solution = solve_triangles(weighted, cluster)
    width = outside.widened(names, solution.half_width(confidence))
    low = solution.value - width
    high = solution.value + width
    dropped = [
        names[k]
        for k in needless(
            plain, weighted, order, low, high, [names.index(name) for name in droppable]
        )
    ]
    estimates = {
        name: Interval(0.0, float(low[names.index(name)]), float(high[names.index(name)]))
        for name in dropped
    }
    if dropped:
        fixed = {**samples.fixed, **{name: _possible(name, estimates[name]) for name in dropped}}
        outside = OmittedParameters(*whole, fixed, tuple(unknown))
        outside.add_loads(samples.loads, samples.most, cluster, confidence)
    kept, plain, weighted = _without(names, dropped, plain, weighted)
    dropped_or_split = bool(dropped)
    if ("viscous_backward" in kept and "viscous" in kept) or samples.split_coulomb:
        kept, plain, weighted = by_direction(kept, samples.split_coulomb, plain, weighted)
        refused |= {"offset": NO_OFFSET} if samples.split_coulomb else {}
        dropped_or_split = True
    if dropped_or_split:
        solution = solve_triangles(weighted, cluster)
        width = outside.widened(kept, solution.half_width(confidence))
    estimates |= intervals_around(kept, solution.value, width)
    # the estimate is viscous friction backward minus forward; the forward value is added
    if "viscous_backward" in estimates and "viscous" in samples.fixed:
        estimates["viscous_backward"] = shifted(
            estimates["viscous_backward"], samples.fixed["viscous"].value
        )
    if (
        refused.get("offset") == KNOWN_OFFSET["offset"]
        and samples.known_offset is not None
        and "coulomb" in estimates
    ):
        estimates["coulomb"] = less_offset(
            estimates["coulomb"], samples.known_offset, float(samples.sign[0])
        )
    size = float(np.linalg.norm(samples.effort + samples.known_effort))
    held_out = held_out_norm(plain, weighted, halved(order), list(range(len(kept))))
    return SlidingFit(
        {
            name: estimates[name]
            for name in dict.fromkeys((*names, *kept))
            if name in estimates and name not in refused
        },
        refused,
        residual_norm(plain, solution.value) / size,
        None if held_out is None else held_out / size,
        solution.condition,
        samples.velocity.size,
        {**details, "strokes": int(order.max()) + 1, "clusters": int(cluster.max()) + 1},
        dropped=tuple(dropped),
    )


def _possible(name: str, interval: Interval) -> Interval:
    return replace(interval, low=max(interval.low, 0.0)) if name in NEVER_NEGATIVE else interval


def shifted(interval: Interval, by: float) -> Interval:
    """Return the estimate and its interval, both increased by `by`."""
    return Interval(interval.value + by, interval.low + by, interval.high + by)


def _without(
    names: tuple[str, ...], gone: list[str], plain: Tensor, weighted: Tensor
) -> tuple[tuple[str, ...], Tensor, Tensor]:
    if not gone:
        return names, plain, weighted
    chosen = [*(k for k, name in enumerate(names) if name not in gone), -1]
    return (
        tuple(name for name in names if name not in gone),
        plain[:, :, chosen],
        weighted[:, :, chosen],
    )


def less_offset(summed: Interval, offset: Interval, sign: float) -> Interval:
    """Return the Coulomb friction, which is `summed` minus `sign` times `offset`.

    `summed` is Coulomb friction plus `sign` times offset, fitted to motion in the direction `sign`
    (+-1). The interval of the result includes each offset in the interval `offset`.
    """
    value = summed.value - sign * offset.value
    half = summed.half_width
    low, high = (
        (sign * offset.low, sign * offset.high)
        if sign > 0.0
        else (sign * offset.high, sign * offset.low)
    )
    return Interval(value, summed.value - high - half, summed.value - low + half)


def reduced(
    samples: RegressionSamples, weight: Vector, parameters: int, window: int
) -> tuple[Tensor, Tensor, IntVector, IntVector]:
    """Reduce groups of rows to triangular matrices by QR.

    A group consists of successive rows of one stroke and one cluster. Return, for the g groups, the
    matrices (g, q, q) without and with weights, the cluster numbers (g,), and the stroke numbers
    (g,) from 0. The q columns are the first `parameters` sliding parameters, the loads, and the
    effort.
    """
    columns = (*samples.columns[:parameters], *samples.loads.values(), samples.effort)
    cluster = clusters(samples.stroke, samples.sign, samples.counts, 3 * window)
    starts = np.flatnonzero(np.diff(cluster, prepend=-1) | np.diff(samples.stroke, prepend=-1))
    order = np.unique(samples.stroke[starts], return_inverse=True)[1]
    plain = triangles(columns, np.ones(weight.size), starts)
    even = bool(np.all(weight == weight[0])) and weight[0] == 1.0
    return plain, plain if even else triangles(columns, weight, starts), cluster[starts], order


def residuals(samples: RegressionSamples, weight: Vector) -> Vector:
    """Return the residual effort (n,) [N m | N] of the rows in a weighted fit.

    Raises UnusableLogs if the regressors are dependent.
    """
    _, free = free_columns(samples)
    columns = (*free, *samples.loads.values())
    starts = np.flatnonzero(np.diff(samples.stroke, prepend=-1))
    value = least(triangles((*columns, samples.effort), weight, starts))[0]
    return samples.effort - sum(
        (v * column for v, column in zip(value, columns, strict=True)), np.zeros(weight.size)
    )


def cluster_products(
    samples: RegressionSamples, columns: tuple[Vector, ...], window: int
) -> tuple[Tensor, Vector, IntVector]:
    """Return Gram matrices (g, q, q), numbers of rows (g,) and cluster numbers (g,) of g groups.

    A group consists of consecutive rows of one stroke and one cluster. The Gram matrix of a group
    is C^T C, where C contains the q `columns` in the rows of the group.
    """
    cluster = clusters(samples.stroke, samples.sign, samples.counts, 3 * window)
    starts = np.flatnonzero(np.diff(cluster, prepend=-1) | np.diff(samples.stroke, prepend=-1))
    parts = triangles(columns, np.ones(samples.velocity.size), starts)
    rows = np.diff(np.append(starts, samples.velocity.size)).astype(np.float64)
    return np.swapaxes(parts, 1, 2) @ parts, rows, cluster[starts]


def intervals(
    products: Tensor,
    rows: Vector,
    cluster: IntVector,
    estimate: Callable[[Tensor, float], Vector],
    names: tuple[str, ...],
    confidence: float,
) -> dict[str, Interval]:
    """Return intervals of the parameters `names`, which the function `estimate` computes.

    `estimate` takes a sum of Gram matrices and a number of rows, and returns the parameters (p,).
    The intervals come from a jackknife that leaves out one cluster at a time.

    - products: Gram matrices of g groups of rows, (g, q, q)
    - rows, cluster: number of rows, and cluster number, of each group, (g,)
    """
    index = np.unique(cluster, return_inverse=True)[1]
    count = int(index.max()) + 1
    summed = np.zeros((count, *products.shape[1:]))
    number = np.bincount(index, rows)
    np.add.at(summed, index, products)
    whole = summed.sum(axis=0)
    total = float(number.sum())
    value = estimate(whole, total)
    if count < 2:
        return {
            name: Interval(float(v), -np.inf, np.inf) for name, v in zip(names, value, strict=True)
        }
    left_out = np.array(
        [estimate(whole - part, total - n) for part, n in zip(summed, number, strict=True)]
    )
    deviation = np.sqrt(
        (count - 1) / count * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0)
    )
    width = deviation * scipy.special.stdtrit(count - 1, 0.5 + 0.5 * confidence)
    return intervals_around(names, value, width)


def parameters_of(samples: RegressionSamples) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return the sliding parameters to fit, and the unidentifiable parameters with reasons.

    Raises UnusableLogs if there are too few rows.
    """
    if samples.velocity.size < 2 * len(SLIDING):
        raise UnusableLogs(
            f"only {samples.velocity.size} samples certainly slip; at least {2 * len(SLIDING)} are "
            "needed"
        )
    if samples.terms is not None and "offset" not in samples.terms and not samples.split_coulomb:
        return SLIDING[:3], {"offset": NO_OFFSET}
    if samples.one_direction:
        return SLIDING[:3], {
            "coulomb": ONE_DIRECTION,
            "offset": ONE_DIRECTION,
        } if samples.known_offset is None else KNOWN_OFFSET
    forward, backward = (
        np.count_nonzero(np.diff(samples.stroke[samples.sign * side > 0.0])) + 1
        for side in (1.0, -1.0)
    )
    if min(forward, backward) < FEWEST_STROKES:
        reason = (
            f"too few reversals: {forward} strokes slip forward and {backward} backward (at "
            f"least {FEWEST_STROKES} each are needed)"
        )
        return SLIDING, {"coulomb": reason, "offset": reason}
    return SLIDING, {}


def free_columns(samples: RegressionSamples) -> tuple[tuple[str, ...], tuple[Vector, ...]]:
    """Return names and columns (n,) of the identifiable sliding parameters that are not fixed.

    Raises UnusableLogs if there are too few rows.
    """
    names, _ = parameters_of(samples)
    free = [
        (name, column)
        for name, column in zip(names, samples.columns, strict=False)
        if name not in samples.fixed
    ]
    return tuple(name for name, _ in free), tuple(column for _, column in free)


def spread_as(
    plain: Mapping[str, Interval], fitted: dict[str, Interval], samples: RegressionSamples
) -> dict[str, Interval]:
    """Return the intervals `fitted`, each at least as wide as the interval in `plain`.

    `plain` are intervals by least squares that include the uncertainty of fixed parameters. Without
    fixed parameters, `fitted` is returned unchanged.
    """
    if not samples.fixed:
        return fitted
    half = {name: max(one.half_width, plain[name].half_width) for name, one in fitted.items()}
    return {name: Interval.around(one.value, half[name]) for name, one in fitted.items()}
