"""Friction at the onsets of ramps: the effort at which each motion begins.

The effort at an onset depends on the rest position within an encoder count. The times at which the
count changes often do not determine this position. However, a test that ends each ramp after a
fixed number of counts brings the axis to rest at nearly the same position within a count.
Therefore, the mean rest position of all onsets is used (`OnsetData.rest`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.breakaway.onset import onset_times, search_span
from frictool.identify.breakaway.onset_detection import (
    CHANGES_USED,
    FEWEST_ONSETS,
    BreakawayOnset,
    find_onsets,
)
from frictool.identify.breakaway.position_law import FOLLOWING, BreakawayPositions, PolynomialOrders
from frictool.identify.breakaway.stribeck_velocity import (
    IMMEDIATE,
    NO_FALL,
    StribeckFall,
    StribeckVelocityRange,
    allowed_fall,
)
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.typing import IntVector, Vector

PRIOR = 12.0  # 1/variance of a rest position that is uniform within its count, 1/count^2
# largest number of onsets, evenly spaced, in the comparison of Stribeck velocities
ONSETS_COMPARED = 100
SURELY = 1.0 + 1e-9  # factor on a limit, for the rounding of a sum in another order
# largest number of results in the cache; one identification computes some 10 000
MOST_KEPT = 20_000
TOGETHER = 4  # number of onsets that one call of the kernel computes
Sliding = tuple[float, float, float, float]  # inertia, viscous, Coulomb friction, offset
SlidingOnset = tuple[BreakawayOnset, Sliding]
OnsetKey = tuple[BreakawayOnset, Sliding, float, float, StribeckFall]
Begin = tuple[float, float, float]
_KEPT: dict[OnsetKey, Begin] = {}


def efforts(
    onsets: list[BreakawayOnset],
    axis: Mapping[str, float],
    resolution: float,
    start: float,
    shape: Vector | None = None,
    fall: StribeckFall = IMMEDIATE,
) -> tuple[Vector, Vector, Vector]:
    """Return |effort| (n,), rest position (n,) and misfit (n,) of each onset.

    The rest position is a fraction of an encoder count, 0 to 1. The misfit is the sum of the
    squared differences between computed and logged travel, divided by their variance due to
    sampling.

    - axis: `inertia`, `viscous`, `coulomb` and `offset` in SI units
    - start: expected rest position, 0 to 1
    - shape: factor of `coulomb` at each onset, (n,); None if friction is constant
    - fall: fall of friction with the speed after the onset
    """
    factors = [1.0] * len(onsets) if shape is None else shape.tolist()
    slidings = [
        (axis["inertia"], axis["viscous"], axis["coulomb"] * factor, axis["offset"])
        for factor in factors
    ]
    found = _begins(list(zip(onsets, slidings, strict=True)), resolution, start, fall)
    t0, place, left = np.array(found).reshape(-1, 3).T
    level, rate, timing = np.array([(o.level, o.rate, o.timing) for o in onsets]).reshape(-1, 3).T
    return level + rate * t0, place / resolution, 12.0 * left / (timing * resolution**2)


def _begins(
    onsets: list[SlidingOnset], resolution: float, start: float, fall: StribeckFall
) -> list[Begin]:
    """Return time [s], rest position [rad | m] and misfit of each onset; NaN if not determined."""
    keys = [(*onset, resolution, start, fall) for onset in onsets]
    known = {key: _KEPT[key] for key in keys if key in _KEPT}
    new = [key for key in dict.fromkeys(keys) if key not in known]
    for first in range(0, len(new), TOGETHER):
        part = new[first : first + TOGETHER]
        immediate = [math.nan] * len(part)
        if fall != IMMEDIATE:
            without = [(onset, sliding) for onset, sliding, *_ in part]
            immediate = [t0 for t0, *_ in _begins(without, resolution, start, IMMEDIATE)]
        known |= zip(part, _computed(part, immediate), strict=True)
    if len(_KEPT) + len(new) > MOST_KEPT:
        _KEPT.clear()
    _KEPT.update((key, known[key]) for key in new)
    return [known[key] for key in keys]


def _computed(keys: list[OnsetKey], immediate: list[float]) -> list[Begin]:
    """Return the results of `_begins` for keys that have the same fall of friction.

    `immediate`: onsets [s] that result from an immediate fall.
    """
    onsets = [onset for onset, *_ in keys]
    resolution, start, fall = keys[0][2:]
    times, seen = np.zeros((2, len(onsets), max(onset.time.size for onset in onsets)))
    for k, onset in enumerate(onsets):
        times[k, : onset.time.size] = onset.time
        seen[k, : onset.seen.size] = onset.seen
    slidings = [sliding for _, sliding, *_ in keys]
    # only the effort without the offset acts against friction
    ramps = [
        (onset.level - onset.direction * offset, onset.rate)
        for onset, (*_, offset) in zip(onsets, slidings, strict=True)
    ]
    spans = [
        search_span(resolution, onset.rate, inertia, CHANGES_USED)
        for onset, (inertia, *_) in zip(onsets, slidings, strict=True)
    ]
    found = onset_times(
        times,
        seen,
        np.array([onset.time.size for onset in onsets]),
        np.array(ramps),
        np.array([sliding[:3] for sliding in slidings]),
        resolution,
        start * resolution,
        np.array([onset.timing for onset in onsets]),
        np.array(spans),
        fall.velocity,
        fall.exponent,
        np.array(immediate),
    )
    return [(t0, place, left) for t0, place, left, _ in found.tolist()]


@dataclass(frozen=True)
class OnsetData:
    """Selected onsets of breakaway ramps.

    - positions: positions and directions of the onsets
    - resolution: encoder step, rad | m
    - offset: offset of the bench, N m | N; None if all onsets have one direction; the
      argument `axis` of the methods then contains the offset
    - fall: assumed fall of friction with the speed
    """

    onsets: list[BreakawayOnset]
    positions: BreakawayPositions
    resolution: float
    offset: float | None
    fall: StribeckFall = IMMEDIATE

    def misfit(
        self,
        axis: Mapping[str, float],
        shape: Vector | None,
        order: IntVector,
        fall: StribeckFall,
        most: float = math.inf,
    ) -> float:
        """Return the mean misfit (`efforts`) of the onsets for an assumed fall of friction.

        Return inf as soon as the sum shows that the mean exceeds `most`. The onsets are evaluated
        in the order `order`, those with the largest expected misfit first.
        """
        onsets, factors = self._compared(shape)

        squares: Vector = np.empty(len(onsets))
        partial_sum = 0.0
        for first in range(0, len(onsets), TOGETHER):
            part = order[first : first + TOGETHER]
            some = [onsets[k] for k in part.tolist()]
            squares[part] = efforts(some, axis, self.resolution, 0.5, factors[part], fall)[2]
            for square in squares[part].tolist():
                partial_sum += square
                if partial_sum > most * len(onsets) * SURELY:
                    return math.inf
        total = sum(squares.tolist())
        return math.inf if total > most * len(onsets) else total / len(onsets)

    def _compared(self, shape: Vector | None) -> tuple[list[BreakawayOnset], Vector]:
        """Return at most ONSETS_COMPARED onsets, evenly spaced, and their entries of `shape`."""
        every = slice(None, None, math.ceil(len(self.onsets) / ONSETS_COMPARED))
        onsets = self.onsets[every]
        return onsets, np.ones(len(onsets)) if shape is None else shape[every]

    def fall_range(
        self, axis: Mapping[str, Interval], shape: Vector | None, confidence: float
    ) -> StribeckVelocityRange:
        """Return the falls of friction that agree with the onsets, for any parameters in `axis`."""
        nominal = {name: known.value for name, known in axis.items()}
        ends = [
            {**nominal, name: end}
            for name, known in axis.items()
            for end in (known.low, known.high)
            if end != known.value
        ]
        ends = [end for end in ends if end["inertia"] > 0.0]
        rate = float(np.mean([onset.rate for onset in self.onsets]))
        scale = float(np.cbrt(self.resolution**2 * rate / nominal["inertia"]))
        # the onsets that contradict a slow fall most come first
        onsets, factors = self._compared(shape)
        slow = efforts(onsets, nominal, self.resolution, 0.5, factors, NO_FALL)[2]
        misfits = [
            partial(self.misfit, parameters, shape, np.argsort(-slow))
            for parameters in (nominal, *ends)
        ]
        return allowed_fall(misfits[0], misfits[1:], scale, confidence)

    def rest(self, axis: Mapping[str, float], shape: Vector | None) -> tuple[float, float]:
        """Return the mean rest position within a count, 0 to 1, and its standard deviation.

        The position fitted to an onset is a linear function of the position that the fit assumes:
        fitted = a + b assumed. The two are equal at a/(1 - b), which depends only on the times at
        which the count changes. The result is the average of a/(1 - b) and the middle of the count
        (uniform distribution), with weights 1/variance.
        """
        low, high = (
            efforts(self.onsets, axis, self.resolution, expected, shape, self.fall)[1]
            for expected in (0.0, 1.0)
        )
        intercept = float(np.mean(low))
        gain = max(1.0 - float(np.mean(high - low)), 1e-6)
        independent = max(1.0, low.size / FOLLOWING)
        spread = max(float(np.var(0.5 * (low + high))), 1e-9) / (gain**2 * independent)
        # variance of a position due to sampling; all onsets have the same error
        repeated = max(1.0 - gain, 0.0) / (12.0 * gain)
        mean = (min(max(intercept / gain, 0.0), 1.0) / spread + 0.5 * PRIOR) / (
            1.0 / spread + PRIOR
        )
        return mean, float(1.0 / np.sqrt(1.0 / (spread + repeated) + PRIOR))

    def friction(
        self, axis: Mapping[str, float], shape: Vector | None, deviations: float = 0.0
    ) -> Vector:
        """Return the friction |effort - offset| (n,) at the onsets [N m | N].

        The assumed rest position is the mean plus `deviations` standard deviations (`rest`).
        """
        offset = axis["offset"] if self.offset is None else self.offset
        mean, deviation = self.rest(axis, shape)
        start = mean + deviations * deviation
        return (
            efforts(self.onsets, axis, self.resolution, start, shape, self.fall)[0]
            - offset * self.positions.direction
        )

    def shape(self, structure: PolynomialOrders, value: Vector) -> Vector:
        """Return the fitted friction (n,) at the onsets, relative to its mean."""
        curve = self.positions.design(structure) @ value
        if structure.common:
            curve = curve - value[-1] * self.positions.direction
        return np.asarray(curve / np.mean(curve))


def onset_data(records: list[MotionRecord], bench: Bench) -> OnsetData:
    """Return the onsets of each direction that has at least FEWEST_ONSETS."""
    onsets = [onset for record in records for onset in find_onsets(record, bench)]
    used = [
        onset
        for onset in onsets
        if sum(o.direction == onset.direction for o in onsets) >= FEWEST_ONSETS
    ]
    if not used:
        forward = sum(onset.direction > 0.0 for onset in onsets)
        raise UnusableLogs(
            f"found {forward} breakaways forward and {len(onsets) - forward} backward under an "
            "effort that rises linearly from a low level; needed: at least "
            f"{FEWEST_ONSETS} in one direction"
        )
    position = np.array([o.position for o in used])
    direction = np.array([o.direction for o in used])
    positions = BreakawayPositions(
        position, direction, float(position.min()), float(position.max())
    )
    known = bench.mechanics.offset
    one_way = abs(float(np.sum(direction))) == direction.size
    return OnsetData(
        used,
        positions,
        records[0].resolution,
        None if one_way else 0.0 if known is None else known.value,
    )
