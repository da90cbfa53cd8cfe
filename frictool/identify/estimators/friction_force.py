"""Friction force, computed with a known inertia, and its curve over speed (after K. Mnich).

    filter     same causal low-pass for velocity and effort, so that both delays are equal
    force      effort - inertia (v[k] - v[k-1])/T, with the inertia in bench.yaml
    curve      coulomb + viscous v + (breakaway - coulomb) (v/v_p) e^(1 - v/v_p)
               for each direction of motion, and an offset

v is the filtered velocity, k the number of the sample, and T the sample period. The breakaway is
the largest friction of the curve, at the speed v_p; in thesis (2.34), the friction is largest at
rest. v_p is therefore not a Stribeck velocity; the fit reports v_p in its details. Only v_p is
searched, because the force is linear in the other parameters.

Each log must be a stroke in one direction. At a reversal, friction changes its sign, but its
filtered value changes slowly; the curve would then state a Coulomb friction that is far too small.

The first fit uses all samples of a stroke, even samples at rest. Samples at rest shift its Coulomb
friction towards the effort at rest. A second fit uses only samples in which the axis certainly
slips. The reported values are those of the first fit; each reported interval contains the intervals
of both fits. To leave out samples at rest, select the moving part of the log with `ingest --from
--to`. The intervals allow for the correlation of the residuals that the filter causes
(`newey_west`), and for every inertia in the range in bench.yaml. The intervals do not include
errors of the instruments' clocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs, intervals_around
from frictool.identify.methods import IdentificationSettings, PublishedFilters
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.newey_west import newey_west
from frictool.identify.rows.regression_samples import (
    KNOWN_OFFSET,
    ONE_DIRECTION,
    RegressionSamples,
    joined,
    less_offset,
)
from frictool.identify.rows.slip_fit import known_inertia
from frictool.identify.rows.slip_mask import NOISE_COUNTS, SPEED_SHARE
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Matrix, Vector

FEWEST_ROWS = 10  # least number of samples that certainly slip, twice the number of regressors
GRID_POINTS = 60  # grid points of the search for the speed of the largest friction
SLOWEST, FASTEST = 1e-3, 0.5  # bounds of the searched speed, relative to the top speed


def friction_force(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return viscous friction, Coulomb friction, breakaway and offset for a known inertia.

    The known inertia is the value in bench.yaml. Raises UnusableLogs if the records do not suit the
    method (`check_records`), if the cut-off is too high for the sample rate, if the axis certainly
    slips in too few samples, or if all strokes have one direction and the bench has no
    `mechanics.offset`.
    """
    check_records(records)
    inertia = known_inertia(bench)
    pipeline = settings.pipeline or PublishedFilters()
    parts = [_rows(record, bench, pipeline.cutoff_hz, pipeline.filter_order) for record in records]
    rows = joined([part for part, _ in parts])
    slipping = np.concatenate([mask for _, mask in parts])
    both = bool(np.ptp(rows.sign) > 0.0)
    if not both and rows.known_offset is None:
        raise UnusableLogs(f"{ONE_DIRECTION}; write mechanics.offset into the bench if it is known")
    reach = round(1.0 / (pipeline.cutoff_hz * records[0].period))
    if np.count_nonzero(slipping) < FEWEST_ROWS:
        raise UnusableLogs(
            f"the axis certainly slips in {np.count_nonzero(slipping)} samples; needed: "
            f"{FEWEST_ROWS}; record longer strokes"
        )
    curve = _curve(rows, inertia, both, reach, settings.confidence)
    in_slip = _curve(rows.rows(slipping), inertia, both, reach, settings.confidence)
    estimates = {
        name: _reaching(one, in_slip.estimates[name]) for name, one in curve.estimates.items()
    }
    refused = {"inertia": f"the method takes the inertia from the bench: {inertia.value:.4g} in SI"}
    if not both and rows.known_offset is not None:
        estimates |= {
            name: less_offset(estimates[name], rows.known_offset, float(rows.sign[0]))
            for name in ("coulomb", "breakaway")
        }
        refused |= KNOWN_OFFSET
    details: dict[str, float | int] = {
        "speed_of_breakaway": curve.peak,
        "cutoff_hz": pipeline.cutoff_hz,
        "filter_order": pipeline.filter_order,
    }
    return SlidingFit(
        estimates, refused, curve.residual, None, curve.condition, rows.velocity.size, details
    )


def _reaching(one: Interval, other: Interval) -> Interval:
    """Return the interval `one`, extended so that it contains the interval `other`."""
    apart = abs(other.value - one.value) + other.half_width
    return Interval.around(one.value, max(one.half_width, apart))


@dataclass(frozen=True)
class _FrictionCurve:
    """Fitted curve; its friction is largest at the speed `peak` [rad/s | m/s].

    `residual` is the rms residual divided by the rms effort.
    """

    estimates: dict[str, Interval]
    peak: float
    residual: float
    condition: float


def _curve(
    rows: RegressionSamples, inertia: Interval, both: bool, reach: int, confidence: float
) -> _FrictionCurve:
    """Fit the friction curve; residuals are assumed to be correlated over `reach` rows."""
    force = rows.effort - inertia.value * rows.acceleration
    peak = _peak(rows, force, both, float(np.max(np.abs(rows.velocity))))
    columns = _design(rows, peak, both)
    ratio = np.abs(rows.velocity) / peak
    value = np.linalg.lstsq(columns, force, rcond=None)[0]
    slope = rows.sign * value[2] * ratio * (ratio - 1.0) * np.exp(1.0 - ratio) / peak
    residual = force - columns @ value
    with_slope = np.column_stack((_sums(columns), slope))
    deviation = newey_west(with_slope, residual, reach)
    half = deviation * float(
        scipy.special.stdtrit(
            max(force.size / reach - with_slope.shape[1], 1.0), 0.5 + 0.5 * confidence
        )
    )
    by_inertia = np.linalg.lstsq(with_slope, rows.acceleration, rcond=None)[0]
    half += max(inertia.high - inertia.value, inertia.value - inertia.low) * np.abs(by_inertia)
    names = ("coulomb", "viscous", "breakaway", "offset")[: columns.shape[1]]
    value = np.array([value[0], value[1], value[0] + value[2], *value[3:]])
    return _FrictionCurve(
        intervals_around(names, value, half),
        peak,
        float(np.linalg.norm(residual) / np.linalg.norm(rows.effort)),
        float(np.linalg.cond(columns / np.linalg.norm(columns, axis=0))),
    )


def check_records(records: list[MotionRecord], _bench: Bench | None = None) -> None:
    """Raise UnusableLogs if a record has gaps, reverses, or does not move."""
    for record in records:
        name = Path(record.name).name
        if record.piece[-1] > 0:
            raise UnusableLogs(
                f"{name} has gaps, over which the filter cannot run; use least-squares"
            )
        directions = np.unique(find_strokes(record).sign)
        moving = directions[directions != 0.0]
        if moving.size == 0:
            raise UnusableLogs(
                f"{name}: the axis does not move by more than an encoder count; record a "
                "longer stroke"
            )
        if moving.size > 1:
            raise UnusableLogs(
                f"{name} reverses, but friction-force needs a stroke in one direction; cut one "
                "stroke out (ingest --from --to), or use --method auto"
            )


def _rows(
    record: MotionRecord, bench: Bench, cutoff_hz: float, order: int
) -> tuple[RegressionSamples, NDArray[np.bool_]]:
    """Return n regression rows of a record, and a mask (n,): True if the axis certainly slips."""
    if 2.0 * cutoff_hz * record.period >= 1.0:
        raise UnusableLogs(
            f"a cut-off of {cutoff_hz:g} Hz is not below half of the sampling rate; allowed: below "
            f"{0.5 / record.period:.4g} Hz"
        )
    b, a = scipy.signal.butter(order, 2.0 * cutoff_hz * record.period)

    def passed(values: Vector) -> Vector:
        return np.asarray(
            scipy.signal.lfilter(b, a, values, zi=scipy.signal.lfilter_zi(b, a) * values[0])[0]
        )

    velocity = (
        np.diff(record.position, prepend=record.position[0]) / record.period
        if record.velocity is None
        else record.velocity
    )
    speed = passed(velocity)
    strokes = find_strokes(record)
    offset = bench.mechanics.offset
    acceleration = np.diff(speed, prepend=speed[0]) / record.period
    moving = strokes.sign != 0.0
    rows = RegressionSamples(
        acceleration,
        speed,
        passed(record.effort),
        strokes.number,
        strokes.sign,
        np.abs(speed) * record.period / record.resolution,
        None if offset is None else Interval(offset.value, *offset.interval),
    )
    least = NOISE_COUNTS * record.resolution * cutoff_hz
    along = speed * strokes.sign
    slips = along > max(least, SPEED_SHARE * float(along.max()))
    return rows.rows(moving), slips[moving]


def _design(rows: RegressionSamples, peak: float, both: bool) -> Matrix:
    """Return the regressors (n, 4) of Coulomb friction, viscous friction, fall and offset.

    The fall is the breakaway minus Coulomb friction.

    If `both` is False, the motion has one direction only, and the column of the offset is missing.
    """
    ratio = np.abs(rows.velocity) / peak
    columns = (
        rows.sign,
        rows.velocity,
        rows.sign * ratio * np.exp(1.0 - ratio),
        np.ones(ratio.size),
    )
    return np.column_stack(columns[: 4 if both else 3])


def _sums(columns: Matrix) -> Matrix:
    """Return the regressors (n, 4) of Coulomb friction, viscous friction, breakaway and offset."""
    return np.column_stack((columns[:, 0] - columns[:, 2], columns[:, 1:]))


def _peak(rows: RegressionSamples, force: Vector, both: bool, top: float) -> float:
    """Return the speed [rad/s | m/s] at which the curve that fits best has its largest friction."""

    def left(logarithm: float) -> float:
        columns = _design(rows, float(np.exp(logarithm)), both)
        return float(
            np.sum((force - columns @ np.linalg.lstsq(columns, force, rcond=None)[0]) ** 2)
        )

    logarithms = np.linspace(np.log(SLOWEST * top), np.log(FASTEST * top), GRID_POINTS)
    best = int(np.argmin([left(logarithm) for logarithm in logarithms]))
    around = (logarithms[max(best - 1, 0)], logarithms[min(best + 1, GRID_POINTS - 1)])
    return float(np.exp(bounded_minimum(left, *around, 1e-8)))
