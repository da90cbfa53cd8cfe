"""Friction at the onsets of ramps: the effort at which each motion begins.

The effort at an onset depends on the rest position within an encoder count. In many logs, the times
at which the count changes do not determine this position. However, a test that ends each ramp after
a fixed number of counts brings the axis to rest at nearly the same position within a count. The
mean rest position of all onsets is therefore used (`OnsetData.rest`).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.identify.breakaway.onset import onset_times, search_span
from frictool.identify.breakaway.onset_detection import (
    CHANGES_USED,
    FEWEST_ONSETS,
    BreakawayOnset,
    find_onsets,
    share_at_rest,
)
from frictool.identify.breakaway.position_law import (
    FOLLOWING,
    BreakawayPositions,
    PolynomialOrders,
    highest_order,
)
from frictool.identify.breakaway.stribeck_velocity import (
    IMMEDIATE,
    NO_FALL,
    StribeckFall,
    StribeckVelocityRange,
    allowed_fall,
)
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.logs.quality.ramps import REST, REST_SHARE
from frictool.typing import IntVector, Matrix, Vector

PRIOR = 12.0  # 1/variance of a rest position that is uniform within its count, 1/count^2
# largest number of onsets, evenly spaced, in the comparison of Stribeck velocities
ONSETS_COMPARED = 100
SURELY = 1.0 + 1e-9  # factor on a limit, since a sum in another order is rounded differently
APART = 2.0  # least ratio of the efforts of two groups of onsets
BY_CHANCE = 1e-4  # probability of a rise of the effort after a reversal that is not by chance
FIRST_PART = 4  # number of onsets compared before the first decision; each decision doubles it


@dataclass(frozen=True)
class _Sliding:
    """Inertia and sliding friction in SI units; `shape` (n,) scales `coulomb` at each onset."""

    inertia: float
    viscous: float
    coulomb: float
    offset: float
    shape: Vector | None = None

    @property
    def key(self) -> tuple[float, float, float, float, bytes]:
        shape = b"" if self.shape is None else self.shape.tobytes()
        return self.inertia, self.viscous, self.coulomb, self.offset, shape


class OnsetTable:
    """Onsets of ramps as arrays, with a cache of their fitted times and rest positions.

    - level, rate, direction, timing: values of each onset, (n,) (`BreakawayOnset`)
    - resolution: encoder step, rad | m
    """

    def __init__(self, onsets: Sequence[BreakawayOnset], resolution: float) -> None:
        self.resolution = resolution
        self.level = np.array([onset.level for onset in onsets])
        self.rate = np.array([onset.rate for onset in onsets])
        self.direction = np.array([onset.direction for onset in onsets])
        self.timing = np.array([onset.timing for onset in onsets])
        self._counts = np.array([onset.time.size for onset in onsets])
        self._times, self._seen = np.zeros((2, len(onsets), int(self._counts.max())))
        for k, onset in enumerate(onsets):
            self._times[k, : onset.time.size] = onset.time
            self._seen[k, : onset.seen.size] = onset.seen
        self._results: dict[Any, Matrix] = {}

    def efforts(
        self,
        axis: Mapping[str, float],
        shape: Vector | None,
        start: float,
        fall: StribeckFall = IMMEDIATE,
        which: IntVector | None = None,
    ) -> tuple[Vector, Vector, Vector]:
        """Return |effort| (m,), rest position (m,) and misfit (m,) of the onsets `which` (m,).

        The rest position is a fraction of an encoder count, 0 to 1. The misfit is the sum of the
        squared differences between computed and logged travel, divided by their variance due to
        sampling. If `which` is None, all onsets are computed.

        - axis: `inertia`, `viscous`, `coulomb` and `offset` in SI units
        - shape: factor of `coulomb` at each onset, (n,); None if friction is constant
        - start: expected rest position, 0 to 1
        - fall: Stribeck curve after the onset
        """
        sliding = _Sliding(axis["inertia"], axis["viscous"], axis["coulomb"], axis["offset"], shape)
        which = np.arange(self.level.size) if which is None else which
        t0, place, left = self._begins(sliding, start, fall, which).T
        variance = self.timing[which] * self.resolution**2
        return (
            self.level[which] + self.rate[which] * t0,
            place / self.resolution,
            12.0 * left / variance,
        )

    def _begins(
        self, sliding: _Sliding, start: float, fall: StribeckFall, which: IntVector
    ) -> Matrix:
        """Return onset time [s], rest position [rad | m] and misfit of the onsets `which`, (m, 3).

        Earlier results come from the cache. A result that the log does not determine is NaN.
        """
        known = self._results.setdefault(
            (sliding.key, start, fall), np.full((self.level.size, 3), np.nan)
        )
        new = which[np.isnan(known[which, 0])]
        if new.size:
            immediate = (
                np.full(new.size, np.nan)
                if fall == IMMEDIATE
                else np.ascontiguousarray(self._begins(sliding, start, IMMEDIATE, new)[:, 0])
            )
            known[new] = self._computed(new, sliding, start, fall, immediate)
        return known[which]

    def _computed(
        self,
        which: IntVector,
        sliding: _Sliding,
        start: float,
        fall: StribeckFall,
        immediate: Vector,
    ) -> Matrix:
        rate = self.rate[which]
        axes = np.empty((which.size, 3))
        axes[:, 0] = sliding.inertia
        axes[:, 1] = sliding.viscous
        axes[:, 2] = sliding.coulomb
        if sliding.shape is not None:
            axes[:, 2] *= sliding.shape[which]
        # only the effort without the offset acts against friction
        level = self.level[which] - self.direction[which] * sliding.offset
        found = onset_times(
            self._times[which],
            self._seen[which],
            self._counts[which],
            np.column_stack((level, rate)),
            axes,
            self.resolution,
            start * self.resolution,
            self.timing[which],
            search_span(self.resolution, rate, sliding.inertia, CHANGES_USED),
            fall.velocity,
            fall.exponent,
            immediate,
        )
        return found[:, :3]


@dataclass(frozen=True)
class OnsetData:
    """Selected onsets of breakaway ramps.

    - table: the onsets as arrays, with the encoder step
    - positions: positions and directions of the onsets
    - offset: offset of the bench, N m | N. `offset` is None if all onsets have the same direction,
      or if the load over position is known. The argument `axis` of the methods then contains the
      offset.
    - fall: assumed Stribeck curve after each onset
    - rejected: number of detected motions that were left out because they are no breakaway
    - after_reversals: number of onsets that were left out because they directly follow a reversal
      and need less effort than later onsets in the same direction
    """

    onsets: list[BreakawayOnset]
    table: OnsetTable
    positions: BreakawayPositions
    offset: float | None
    fall: StribeckFall = IMMEDIATE
    rejected: int = 0
    after_reversals: int = 0

    @property
    def yields(self) -> bool:
        """Return True if the drive train yields by a count or more before at least one onset."""
        return any(onset.yields for onset in self.onsets)

    def later(self, fall: StribeckFall) -> OnsetData:
        """Return the onsets without their first encoder change.

        A drive train that yields just before the onset may cause this change.

        fall: assumed Stribeck curve after each onset
        """
        table = OnsetTable([onset.later for onset in self.onsets], self.table.resolution)
        return replace(self, table=table, fall=fall)

    def misfit(
        self,
        axis: Mapping[str, float],
        shape: Vector | None,
        order: IntVector,
        fall: StribeckFall,
        most: float = math.inf,
    ) -> float:
        """Return the misfit (`OnsetTable.efforts`) for a Stribeck curve, averaged over the onsets.

        The onsets are evaluated in the order `order`. The result is inf as soon as the average is
        certain to exceed `most`.
        """
        squares: Vector = np.empty(order.size)
        partial_sum = 0.0
        compared = self._compared()
        first = 0
        while first < order.size:
            part = order[first : first + max(first, FIRST_PART)]
            first += part.size
            squares[part] = self.table.efforts(axis, shape, 0.5, fall, compared[part])[2]
            for square in squares[part].tolist():
                partial_sum += square
                if partial_sum > most * order.size * SURELY:
                    return math.inf
        total = sum(squares.tolist())
        return math.inf if total > most * order.size else total / order.size

    def _compared(self) -> IntVector:
        return np.arange(0, len(self.onsets), math.ceil(len(self.onsets) / ONSETS_COMPARED))

    def fall_range(
        self, axis: Mapping[str, Interval], shape: Vector | None, confidence: float
    ) -> StribeckVelocityRange:
        """Return the Stribeck curves that agree with the onsets.

        A curve is included if the curve agrees with the onsets for the values in `axis`, or for one
        parameter at an end of its interval.
        """
        nominal = {name: known.value for name, known in axis.items()}
        ends = [
            {**nominal, name: end}
            for name, known in axis.items()
            for end in (known.low, known.high)
            if end != known.value
        ]
        ends = [end for end in ends if end["inertia"] > 0.0]
        rate = float(np.mean([onset.rate for onset in self.onsets]))
        scale = float(np.cbrt(self.table.resolution**2 * rate / nominal["inertia"]))
        # first the onsets that most contradict a slow decrease of friction
        slow = self.table.efforts(nominal, shape, 0.5, NO_FALL, self._compared())[2]
        misfits = [
            partial(self.misfit, parameters, shape, np.argsort(-slow))
            for parameters in (nominal, *ends)
        ]
        return allowed_fall(misfits[0], misfits[1:], scale, confidence)

    def rest(self, axis: Mapping[str, float], shape: Vector | None) -> tuple[float, float]:
        """Return the mean rest position within a count, 0 to 1, and its standard deviation.

        The fit to an onset prefers an assumed position. The fitted position is a linear function of
        the assumed position: fitted = a + b*assumed. The position a/(1 - b), at which the two are
        equal, depends only on the times at which the count changes. The result is the average of
        a/(1 - b) and the middle of the count, weighted by 1/variance. The variance of the middle is
        that of a uniform distribution over the count.
        """
        low, high = (
            self.table.efforts(axis, shape, expected, self.fall)[1] for expected in (0.0, 1.0)
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

        The rest position is assumed to be its mean plus `deviations` standard deviations (`rest`).
        """
        offset = axis["offset"] if self.offset is None else self.offset
        mean, deviation = self.rest(axis, shape)
        start = mean + deviations * deviation
        return (
            self.table.efforts(axis, shape, start, self.fall)[0] - offset * self.positions.direction
        )

    def shape(self, structure: PolynomialOrders, value: Vector) -> Vector:
        """Return the fitted friction (n,) at the onsets, divided by the mean fitted friction."""
        kept = structure.orders[0] + 1 if structure.common else value.size
        curve = self.positions.design(structure)[:, :kept] @ value[:kept]
        return np.asarray(curve / np.mean(curve))


def onset_data(
    records: list[MotionRecord], bench: Bench, axis: Mapping[str, Interval]
) -> OnsetData:
    """Return the onsets of the records, from each direction with at least FEWEST_ONSETS onsets.

    Two kinds of onsets are left out: onsets far below Coulomb friction (`_below_coulomb`), and
    onsets inside a backlash after a reversal (`_inside_backlash`).

    axis: intervals of `inertia`, `viscous`, `coulomb` and `offset`

    Raises UnusableLogs if no direction has enough onsets.
    """
    detected = [onset for record in records for onset in find_onsets(record, bench, axis)]
    low = _below_coulomb(detected, axis, records[0].resolution)
    clear = [onset for onset in detected if onset not in low]
    inside = _inside_backlash(clear)
    onsets = [onset for onset in clear if onset not in inside]
    used = [
        onset
        for onset in onsets
        if sum(o.direction == onset.direction for o in onsets) >= FEWEST_ONSETS
    ]
    if not used:
        forward = sum(onset.direction > 0.0 for onset in onsets)
        share = min(map(share_at_rest, records))
        if share < REST_SHARE:
            raise UnusableLogs(
                f"found {len(onsets)} breakaways: the axis rests for {REST} samples or more in "
                f"{100 * share:.2g} % of the log, needed: {100 * REST_SHARE:g} %; rest before "
                "each ramp, or filter the position"
            )
        raise UnusableLogs(
            f"found {forward} forward and {len(onsets) - forward} backward breakaways in linear "
            f"ramps of the effort from a low level; needed: at least {FEWEST_ONSETS} in one "
            "direction"
        )
    position = np.array([o.position for o in used])
    direction = np.array([o.direction for o in used])
    counts = float(np.ptp(position)) / records[0].resolution
    positions = BreakawayPositions(
        position,
        direction,
        float(position.min()),
        float(position.max()),
        highest=highest_order(counts),
    )
    known = bench.mechanics.offset
    one_way = abs(float(np.sum(direction))) == direction.size
    return OnsetData(
        used,
        OnsetTable(used, records[0].resolution),
        positions,
        None if one_way else 0.0 if known is None else known.value,
        rejected=len(low),
        after_reversals=len(inside),
    )


def _below_coulomb(
    onsets: Sequence[BreakawayOnset], axis: Mapping[str, Interval], resolution: float
) -> list[BreakawayOnset]:
    """Return the onsets that cannot be breakaways, because their effort is below Coulomb friction.

    These onsets form the lower of two groups in one direction (`lower_group`), and their efforts
    are below the interval of Coulomb friction. The mean effort of both directions is regarded as
    the offset.
    """
    level = np.array([one.level for one in onsets])
    direction = np.array([one.direction for one in onsets])
    position = np.array([one.position for one in onsets])
    ways = [direction == side for side in (1.0, -1.0)]
    offset = axis["offset"].value
    if all(np.any(way) for way in ways):
        offset = 0.5 * float(np.median(level[ways[0]]) - np.median(level[ways[1]]))
    friction = level - direction * offset
    low = np.zeros(level.size, dtype=np.bool_)
    for way in ways:
        low[way] = lower_group(friction[way], position[way], resolution)
    below = np.flatnonzero(low & (friction < axis["coulomb"].low))
    return [onsets[k] for k in below.tolist()]


def _inside_backlash(onsets: Sequence[BreakawayOnset]) -> list[BreakawayOnset]:
    """Return the onsets directly after a reversal that need far less effort than the next onset.

    Inside a backlash, and in presliding, the motor moves without the load. The next onset in the
    same direction is near in position and time. The rise of the effort between the two is compared
    with the changes of the effort between successive later onsets in one direction. The rise must
    be larger than all of these changes. The probability of such a rise by chance must be at most
    BY_CHANCE.
    """
    pairs = [
        (one, after)
        for side in (1.0, -1.0)
        for one, after in itertools.pairwise(o for o in onsets if o.direction == side)
        if not after.after_reversal
    ]
    later = [after.level - one.level for one, after in pairs if not one.after_reversal]
    if len(later) < FEWEST_ONSETS:
        return []
    quantile = -float(scipy.special.stdtrit(len(later), BY_CHANCE))
    least = max(quantile * float(np.sqrt(np.mean(np.square(later)))), float(np.max(np.abs(later))))
    return [one for one, after in pairs if one.after_reversal and after.level - one.level > least]


def lower_group(friction: Vector, position: Vector, resolution: float) -> NDArray[np.bool_]:
    """Return a mask (n,): True for each onset in the lower of two groups of efforts.

    If there are not two groups, all are False.

    The largest gap between the sorted efforts `friction` (n,) separates the groups. All efforts of
    the upper group must be more than APART times those of the lower group. The median position of
    the lower group must be within an encoder count of the range of the upper group's positions,
    because friction may vary with position.
    """
    order = np.sort(friction)
    gap = int(np.argmax(np.diff(order))) if order.size > 1 else 0
    if order.size < 2 or order[gap + 1] <= APART * max(order[gap], 0.0):
        return np.zeros(order.size, dtype=np.bool_)
    low = np.asarray(friction <= order[gap])
    first, last = np.min(position[~low]), np.max(position[~low])
    overlap = first - resolution <= np.median(position[low]) <= last + resolution
    return np.asarray(low & overlap)
