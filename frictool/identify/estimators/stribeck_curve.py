"""Stribeck curve (thesis 2.34) from the mean effort of runs at constant speed.

    effort = (coulomb + (breakaway - coulomb) e^(-|v/v_s|^delta)) s + viscous v + offset

s is the direction of motion, +1 or -1. A run is a part of a stroke in which the position stays
within two counts of a straight line in time. If there are too few runs, nearly straight strokes are
used instead: strokes whose position deviates from a line by at most 2.7 % of the stroke's distance,
and whose speed changes by at most 5 %.

Speed, acceleration and effort of a run are means with the weights (1 - w^2)^2. w is the time,
scaled to -1 at the start and +1 at the end of the run. These means satisfy the equation of motion
without a derivative of the position. In short runs the speed still settles. The effort that
accelerates the inertia is therefore subtracted. The inertia in bench.yaml is used; the intervals
include the effect of every inertia in the range in bench.yaml. If all runs have the same direction,
the offset in bench.yaml is used, and the range of this offset widens the interval of Coulomb
friction.

For fixed (v_s, delta) the other parameters are linear. v_s is searched; delta is 2 or, if the data
support it, 1 or 1/2. Schwarz's criterion (BIC) decides between the curve and a straight line. For
the interval of v_s, the derivative of the effort with respect to v_s is an additional regressor.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.identify.breakaway.stribeck_velocity import EXPONENTS
from frictool.identify.estimators.piecewise_friction import EVIDENCE
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs, intervals_around
from frictool.identify.interval_checks import below_coulomb, too_vague
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.regression import solve
from frictool.identify.rows.slip_fit import known_inertia
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Matrix, Vector

BLOCK = 50  # samples per block; runs grow block by block
STRAIGHT_COUNTS = 2.0  # counts, largest distance of a run's position from its line
# largest deviation of a whole stroke from a line, relative to the stroke's distance: half of the
# deviation of a sine
WHOLE_SHARE = 0.027
# share of the moving samples in runs above which a test has constant speeds. Trapezoids of the
# speed with ramps of a quarter of the stroke have 0.5, tests of `excite --kind speeds` at least
# 0.75.
SPEEDS_SHARE = 0.7
# least share of the moving samples in runs. In a sine, the speed is within 5 % of its maximum
# during a fifth of the motion. Such runs are all near one position: a load looks like an offset.
LEAST_SHARE = 1 / 3
ENDS_SHARE = 0.1  # share of a stroke at each end in which the speed settles
MOST_DRIFT = 0.05  # largest change of speed along a run, relative to its speed
FEWEST_COUNTS = 10.0  # least distance of a run, in counts; its speed is then known to a tenth
FEWEST_SPEEDS = 6  # least number of runs in each direction
NAMES = ("coulomb", "fall", "viscous", "offset")
FALL = ("breakaway", "stribeck_velocity")

# speed, sign, mean effort, number of samples and mean acceleration of a run
RunRow = tuple[float, float, float, float, float]


@dataclass(frozen=True)
class ConstantSpeedRuns:
    """Mean effort of m runs; a run is a part of a stroke with constant speed.

    - speed: |v|, (m,), rad/s | m/s
    - sign: direction, +-1, (m,)
    - effort: mean effort, (m,), N m | N
    - samples: number of samples, (m,)
    - acceleration: mean acceleration, (m,), rad/s^2 | m/s^2
    """

    speed: Vector
    sign: Vector
    effort: Vector
    samples: Vector
    acceleration: Vector

    @property
    def one_way(self) -> bool:
        """Return True if all runs have the same direction, so that the offset is not fitted."""
        return bool(np.all(self.sign == self.sign[0]))

    def design(self, velocity: float, exponent: float) -> Matrix:
        """Return the regressors (m, 4): Coulomb, Stribeck effect, viscous, offset.

        `velocity` is the Stribeck velocity v_s [rad/s | m/s] and `exponent` the exponent delta. The
        column of the Stribeck effect is missing if `velocity` is 0. The column of the offset is
        missing if all runs have the same direction.
        """
        offset = () if self.one_way else (np.ones(self.sign.size),)
        plain = (self.sign, self.sign * self.speed, *offset)
        if velocity == 0.0:
            return np.column_stack(plain)
        return np.column_stack(
            (plain[0], self.sign * np.exp(-((self.speed / velocity) ** exponent)), *plain[1:])
        )

    def squares(self, velocity: float, exponent: float) -> float:
        """Return the weighted sum of squared residuals for a Stribeck velocity and an exponent."""
        weight = np.sqrt(self.samples)
        rows = self.design(velocity, exponent) * weight[:, None]
        right = self.effort * weight
        return float(np.sum((right - rows @ np.linalg.lstsq(rows, right, rcond=None)[0]) ** 2))


def stribeck_curve(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return the fit of a Stribeck curve, or of a straight line, to runs at constant speed.

    Curve and line have Coulomb friction, viscous friction and offset; the curve also has breakaway
    and Stribeck velocity. The line is fitted if friction does not fall with speed, or if the runs
    do not determine breakaway and Stribeck velocity. In the second case, each interval of the line
    is extended to contain the value of the curve.

    Raises
    ------
    UnusableLogs
        If there are no runs at constant speed, if a direction has only one to five runs, if the
        runs cover less than a third of the motion, if the speeds of the runs differ by less than a
        factor of 2, or if all runs have the same direction and the bench has no `mechanics.offset`.
    """
    inertia = known_inertia(bench)
    runs = find_runs(records)
    runs = replace(runs, effort=runs.effort - inertia.value * runs.acceleration)
    reach = max(inertia.high - inertia.value, inertia.value - inertia.low)
    offset = None
    if runs.one_way:
        offset = _known_offset(bench)
        runs = replace(runs, effort=runs.effort - offset.value)
    velocity, exponent = _choice(runs)
    fit = _with_offset(_fitted(runs, velocity, exponent, reach, settings.confidence), offset)
    if velocity == 0.0:
        return fit
    reason = next(
        (why for name in FALL if (why := too_vague(name, fit.parameters[name])) is not None), None
    )
    if reason is None:
        reason = below_coulomb(fit.parameters["breakaway"], fit.parameters["coulomb"])
    if reason is None:
        return fit
    straight = _with_offset(_fitted(runs, 0.0, exponent, reach, settings.confidence), offset)
    reaching = {
        name: replace(
            one,
            low=min(one.low, fit.parameters[name].value),
            high=max(one.high, fit.parameters[name].value),
        )
        for name, one in straight.parameters.items()
    }
    return replace(
        straight,
        parameters=reaching,
        refused={
            **straight.refused,
            **dict.fromkeys(FALL, f"{reason}; slower runs would determine it"),
        },
    )


def check_records(records: list[MotionRecord], bench: Bench | None = None) -> None:
    """Raise UnusableLogs if the records have too few runs at constant speed.

    If all runs have one direction, the bench must state an offset. This is not checked if `bench`
    is None.
    """
    if find_runs(records).one_way and bench is not None:
        _known_offset(bench)


def _known_offset(bench: Bench) -> Interval:
    offset = bench.mechanics.offset
    if offset is None:
        raise UnusableLogs(
            "all runs at constant speed have one direction, so that Coulomb friction and offset "
            "cannot be separated; add runs in the other direction, or state mechanics.offset"
        )
    return Interval(offset.value, *offset.interval)


def _with_offset(fit: SlidingFit, offset: Interval | None) -> SlidingFit:
    """Return `fit` with Coulomb and breakaway intervals widened by the range of a known offset.

    If `offset` is None, the offset was fitted, and `fit` is returned unchanged.
    """
    if offset is None:
        return fit
    widened = {
        name: Interval.around(one.value, one.half_width + offset.half_width)
        for name, one in fit.parameters.items()
        if name in ("coulomb", "breakaway")
    }
    reason = "the runs have one direction; the bench's offset is used"
    return replace(
        fit,
        parameters={**fit.parameters, **widened},
        refused={**fit.refused, "offset": reason},
    )


def _fitted(
    runs: ConstantSpeedRuns, velocity: float, exponent: float, reach: float, confidence: float
) -> SlidingFit:
    """Return the fit of a Stribeck curve or, if `velocity` is 0, of a straight line.

    The intervals include the effect of an error of up to `reach` [kg m^2 | kg] in the inertia in
    bench.yaml.
    """
    design = runs.design(velocity, exponent)
    names = [name for name in NAMES if velocity > 0.0 or name != "fall"][: design.shape[1]]
    weight = np.sqrt(runs.samples)
    cluster = np.arange(runs.speed.size)
    value = np.linalg.lstsq(design * weight[:, None], runs.effort * weight, rcond=None)[0]
    columns = design
    if velocity > 0.0:
        ratio = (runs.speed / velocity) ** exponent
        columns = np.column_stack((design, value[1] * design[:, 1] * ratio * exponent / velocity))
    solution = solve(columns, runs.effort, weight, cluster)
    by_inertia = np.linalg.lstsq(columns * weight[:, None], runs.acceleration * weight, rcond=None)
    half = solution.half_width(confidence) + reach * np.abs(by_inertia[0])
    estimates = intervals_around(names, value, half)
    if velocity > 0.0:
        estimates |= {
            "breakaway": _sum(estimates["coulomb"], estimates.pop("fall")),
            "stribeck_velocity": Interval.around(velocity, float(half[-1])),
        }
    residual = runs.effort - design @ value
    return SlidingFit(
        estimates,
        {"inertia": "the inertia has no effect at a constant speed"},
        float(np.linalg.norm(residual) / np.linalg.norm(runs.effort)),
        None,
        solution.condition,
        int(runs.samples.sum()),
        {
            "runs": runs.speed.size,
            "slowest": float(runs.speed.min()),
            "fastest": float(runs.speed.max()),
            "exponent": exponent,
        },
        Laws(stribeck_exponent=exponent) if velocity > 0.0 else None,
    )


def _sum(one: Interval, other: Interval) -> Interval:
    """Return the sum of two estimates, whose errors are treated as uncorrelated."""
    return Interval.around(
        one.value + other.value, float(np.hypot(one.half_width, other.half_width))
    )


def find_runs(records: list[MotionRecord]) -> ConstantSpeedRuns:
    """Return all runs at constant speed.

    Raises UnusableLogs if there are too few runs, if the runs cover less than a third of the
    motion, or if the speeds of the runs differ by less than a factor of 2.
    """
    rows = _rows(records)
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    counts = _directions(rows)
    if not _enough(*counts):
        raise UnusableLogs(
            f"found {counts[0]} runs at a constant speed forward and {counts[1]} backward; needed: "
            f"at least {FEWEST_SPEEDS} in each direction, or runs in one direction only"
        )
    share = _share(rows, records)
    if share < LEAST_SHARE:
        raise UnusableLogs(
            f"runs at a constant speed are {100 * share:.2g} % of the motion (needed: at least "
            f"{100 * LEAST_SHARE:.2g} %); record runs at constant speeds, or use --method auto"
        )
    if table[:, 0].max() < 2.0 * table[:, 0].min():
        raise UnusableLogs(
            "the speeds of the runs differ by less than a factor of 2; "
            "record a wider range of speeds"
        )
    return ConstantSpeedRuns(*table.T)


def runs_prevail(records: list[MotionRecord]) -> bool:
    """Return True if more than SPEEDS_SHARE of the moving samples are in runs at constant speed."""
    return _share(_rows(records), records) > SPEEDS_SHARE


def _share(rows: list[RunRow], records: list[MotionRecord]) -> float:
    moving = sum(np.count_nonzero(find_strokes(record).sign) for record in records)
    return sum(row[3] + 2.0 * BLOCK for row in rows) / max(moving, 1)


def _rows(records: list[MotionRecord]) -> list[RunRow]:
    """Return a row for each run or, if there are too few runs, for each whole stroke."""
    rows = [row for record in records for row in _runs(record)]
    if _enough(*_directions(rows)):
        return rows
    whole = [row for record in records for row in _whole_strokes(record)]
    return whole if _enough(*_directions(whole)) else rows


def _directions(rows: list[RunRow]) -> tuple[int, int]:
    return sum(row[1] > 0.0 for row in rows), sum(row[1] < 0.0 for row in rows)


def _enough(forward: int, backward: int) -> bool:
    most = max(forward, backward)
    return most >= FEWEST_SPEEDS and not 0 < min(forward, backward) < FEWEST_SPEEDS


def _whole_strokes(record: MotionRecord) -> list[RunRow]:
    number = find_strokes(record).number
    edges = [int(edge) for edge in np.flatnonzero(np.diff(number, prepend=-1, append=-1) != 0)]
    return [
        row for start, end in itertools.pairwise(edges) for row in _whole_stroke(record, start, end)
    ]


def _runs(record: MotionRecord) -> list[RunRow]:
    number = find_strokes(record).number
    rows = []
    edges = [int(edge) for edge in np.flatnonzero(np.diff(number, prepend=-1, append=-1) != 0)]
    for start, end in itertools.pairwise(edges):
        first = start
        for last in range(start + BLOCK, end + 1, BLOCK):
            if _straight(record, first, last):
                continue
            rows += _row(record, first, last - BLOCK)
            first = last - BLOCK
        rows += _row(record, first, end - (end - first) % BLOCK)
    return rows


def _whole_stroke(record: MotionRecord, start: int, end: int) -> list[RunRow]:
    """Return a list with one row for the middle of a stroke.

    The list is empty if the stroke is too short, if the position deviates from a straight line over
    time by more than WHOLE_SHARE of the stroke's distance, or if the relative change of the speed
    exceeds MOST_DRIFT.
    """
    ends = max(BLOCK, int(ENDS_SHARE * (end - start)))
    position = record.position[start + ends : end - ends]
    if position.size < 3 * BLOCK:
        return []
    samples = np.arange(position.size)
    slope, first = np.polyfit(samples, position, 1)
    apart = float(np.max(np.abs(position - first - slope * samples)))
    drift = 2.0 * abs(float(np.polyfit(samples, position, 2)[0])) * position.size
    if apart > WHOLE_SHARE * abs(slope) * position.size or drift > MOST_DRIFT * abs(slope):
        return []
    return _row(record, start + ends - BLOCK, end - ends + BLOCK)


def _straight(record: MotionRecord, first: int, last: int) -> bool:
    position = record.position[first:last] - record.position[first]
    samples = np.arange(position.size) - 0.5 * (position.size - 1)
    slope = float(samples @ position) / float(samples @ samples)
    apart = position - np.mean(position) - slope * samples
    return bool(np.max(np.abs(apart)) < STRAIGHT_COUNTS * record.resolution)


def _row(record: MotionRecord, first: int, last: int) -> list[RunRow]:
    """Return a list with one row for the run, without its first and last block of samples.

    The speed settles in these blocks. The list is empty if too few samples or counts are left.
    """
    inner: NDArray[np.int64] = np.arange(first + BLOCK, last - BLOCK)
    if inner.size < BLOCK:
        return []
    time = record.time[inner]
    weight = (1.0 - np.linspace(-1.0, 1.0, inner.size) ** 2) ** 2
    velocity = np.gradient(record.position[inner], time)
    signals = (velocity, np.gradient(velocity, time), record.effort[inner])
    mean, acceleration, effort = (float(np.average(one, weights=weight)) for one in signals)
    if abs(mean) * inner.size * record.period < FEWEST_COUNTS * record.resolution:
        return []
    return [(abs(mean), float(np.sign(mean)), effort, float(inner.size), acceleration)]


def _choice(runs: ConstantSpeedRuns) -> tuple[float, float]:
    """Return velocity and exponent of the best Stribeck curve, or (0, 2) if a line fits as well."""
    count = runs.speed.size
    low = np.log(0.3 * runs.speed.min())
    high = np.log(runs.speed.max())
    best = (0.0, EXPONENTS[0], count * np.log(runs.squares(0.0, 2.0) / count) - EVIDENCE)
    for exponent in EXPONENTS:
        logarithms = np.linspace(low, high, 40)
        near = logarithms[
            int(
                np.argmin(
                    [runs.squares(float(np.exp(logarithm)), exponent) for logarithm in logarithms]
                )
            )
        ]
        reach = logarithms[1] - logarithms[0]

        def left(logarithm: float, exponent: float = exponent) -> float:
            return runs.squares(float(np.exp(logarithm)), exponent)

        logarithm = bounded_minimum(left, near - reach, near + reach)
        score = count * np.log(left(logarithm) / count) + 2.0 * np.log(count)
        if score < best[2] - (EVIDENCE if best[0] > 0.0 else 0.0):
            best = (float(np.exp(logarithm)), exponent, score)
    return best[0], best[1]
