"""Stribeck curve (2.34) from the mean effort of runs at constant speed.

    effort = (coulomb + (breakaway - coulomb) e^(-|v/v_s|^delta)) s + viscous v + offset

A run is a part of a stroke in which the position follows a straight line to within two counts; at
constant speed inertia has no effect. For fixed (v_s, delta) the other parameters are linear. v_s is
searched; delta is 2 or, if the data support it, 1 or 1/2 ((2.34) allows any). Schwarz's criterion
(BIC) decides between the curve and a straight line. The interval of v_s comes from its derivative
as one more regressor.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.identify.breakaway.stribeck_velocity import EXPONENTS
from frictool.identify.estimators.piecewise_friction import EVIDENCE
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs, intervals_around
from frictool.identify.interval_checks import below_coulomb, too_vague
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.regression import solve
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Matrix, Vector

BLOCK = 50  # samples per block; runs grow block by block
STRAIGHT_COUNTS = 2.0  # counts, largest distance of a run's position from its line
FEWEST_COUNTS = 10.0  # least counts of a run; its speed is then known to a tenth
FEWEST_SPEEDS = 6  # least number of runs in each direction
NAMES = ("coulomb", "fall", "viscous", "offset")
FALL = ("breakaway", "stribeck_velocity")


@dataclass(frozen=True)
class ConstantSpeedRuns:
    """Means of runs at constant speed, one row (m,) per run.

    - speed: speed, > 0, (m,), rad/s | m/s
    - sign: direction, (m,)
    - effort: mean effort, (m,), N m | N
    - samples: number of samples, (m,)
    """

    speed: Vector
    sign: Vector
    effort: Vector
    samples: Vector

    def design(self, velocity: float, exponent: float) -> Matrix:
        """Return the regressors (m, 4) in the order of NAMES.

        If `velocity` is 0, the fall is left out: (m, 3).
        """
        plain = (self.sign, self.sign * self.speed, np.ones(self.sign.size))
        if velocity == 0.0:
            return np.column_stack(plain)
        return np.column_stack(
            (plain[0], self.sign * np.exp(-((self.speed / velocity) ** exponent)), *plain[1:])
        )

    def squares(self, velocity: float, exponent: float) -> float:
        """Return the weighted residual squares of the best curve with this v_s and exponent."""
        weight = np.sqrt(self.samples)
        rows = self.design(velocity, exponent) * weight[:, None]
        right = self.effort * weight
        return float(np.sum((right - rows @ np.linalg.lstsq(rows, right, rcond=None)[0]) ** 2))


def stribeck_curve(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return the fit of a Stribeck curve, or of a straight line, to runs at constant speed.

    Both have Coulomb friction, viscous friction and offset; the curve also has breakaway friction
    and Stribeck velocity. The line is fitted if friction does not fall with speed, or if the runs
    do not determine breakaway and Stribeck velocity; both are then refused. Raises UnusableLogs if
    a direction has fewer than six runs at constant speed, or if all runs have one speed.
    """
    runs = find_runs(records)
    velocity, exponent = _choice(runs)
    fit = _fitted(runs, velocity, exponent, settings.confidence)
    if velocity == 0.0:
        return fit
    reason = next(
        (why for name in FALL if (why := too_vague(name, fit.parameters[name])) is not None), None
    )
    if reason is None:
        reason = below_coulomb(fit.parameters["breakaway"], fit.parameters["coulomb"])
    if reason is None:
        return fit
    straight = _fitted(runs, 0.0, exponent, settings.confidence)
    return replace(
        straight,
        refused={
            **straight.refused,
            **dict.fromkeys(FALL, f"{reason}; slower runs would determine it"),
        },
    )


def _fitted(
    runs: ConstantSpeedRuns, velocity: float, exponent: float, confidence: float
) -> SlidingFit:
    """Return the fit of a curve with this Stribeck velocity and exponent; a line at velocity 0."""
    design = runs.design(velocity, exponent)
    names = [name for name in NAMES if velocity > 0.0 or name != "fall"]
    weight = np.sqrt(runs.samples)
    cluster = np.arange(runs.speed.size)
    value = np.linalg.lstsq(design * weight[:, None], runs.effort * weight, rcond=None)[0]
    columns = design
    if velocity > 0.0:
        ratio = (runs.speed / velocity) ** exponent
        columns = np.column_stack((design, value[1] * design[:, 1] * ratio * exponent / velocity))
    solution = solve(columns, runs.effort, weight, cluster)
    half = solution.half_width(confidence)
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
    """Return the sum with errors added as squares: too wide, since they are anticorrelated."""
    return Interval.around(
        one.value + other.value, float(np.hypot(one.half_width, other.half_width))
    )


def find_runs(records: list[MotionRecord]) -> ConstantSpeedRuns:
    """Return every run at constant speed; raise UnusableLogs if there are too few."""
    rows = [row for record in records for row in _runs(record)]
    table = np.array(rows, dtype=np.float64).reshape(-1, 4)
    counts = [int(np.sum(table[:, 1] == side)) for side in (1.0, -1.0)]
    if min(counts) < FEWEST_SPEEDS:
        raise UnusableLogs(
            f"found {counts[0]} runs at a constant speed forward and {counts[1]} backward; needed: "
            f"at least {FEWEST_SPEEDS} in each direction"
        )
    if table[:, 0].max() < 2.0 * table[:, 0].min():
        raise UnusableLogs("all runs have one speed; a curve needs several")
    return ConstantSpeedRuns(*table.T)


def _runs(record: MotionRecord) -> list[tuple[float, float, float, float]]:
    """Return (speed, sign, mean effort, samples) of each run of a record.

    Blocks of one stroke are joined as long as they form a line.
    """
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


def _straight(record: MotionRecord, first: int, last: int) -> bool:
    position = record.position[first:last]
    line = np.polyval(np.polyfit(np.arange(position.size), position, 1), np.arange(position.size))
    return bool(np.max(np.abs(position - line)) < STRAIGHT_COUNTS * record.resolution)


def _row(record: MotionRecord, first: int, last: int) -> list[tuple[float, float, float, float]]:
    """Return a list of the run without its first and last block, in which the speed settles.

    The list is empty if too few samples or counts are left.
    """
    inner: NDArray[np.int64] = np.arange(first + BLOCK, last - BLOCK)
    if inner.size < BLOCK:
        return []
    slope = float(
        np.polyfit(record.time[inner] - record.time[inner[0]], record.position[inner], 1)[0]
    )
    if abs(slope) * inner.size * record.period < FEWEST_COUNTS * record.resolution:
        return []
    return [
        (abs(slope), float(np.sign(slope)), float(np.mean(record.effort[inner])), float(inner.size))
    ]


def _choice(runs: ConstantSpeedRuns) -> tuple[float, float]:
    """Return (v_s, delta) of the best curve, or (0, 2) if a straight line is as good."""
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

        minimum = minimize_scalar(left, bounds=(near - reach, near + reach), method="bounded")
        score = count * np.log(float(minimum.fun) / count) + 2.0 * np.log(count)
        if score < best[2] - (EVIDENCE if best[0] > 0.0 else 0.0):
            best = (float(np.exp(minimum.x)), exponent, score)
    return best[0], best[1]
