"""Method of sines (thesis 4.34 to 4.39): friction from mean effort and mean speed of strokes.

The velocity is used only to select samples. The equation of motion is averaged over the middle of a
stroke, where the speed is above half of the stroke's largest speed (|sin| > 1/2):

    <u> = inertia <a> + viscous <v> + coulomb s + offset
    <a> = (v at the end - v at the beginning)/duration, nearly 0

<..> is the mean over this middle part, and s the direction of the stroke. The thesis averages over
whole periods, which include stick at the reversals. <v> is a distance divided by a duration, so
that even a coarse encoder is sufficient if a stroke has many counts.

The inertia is not estimated. The effort that accelerates the inertia is subtracted, computed with
the inertia in bench.yaml; the range of this inertia widens the intervals slightly. Knees, which are
speeds at which the viscous friction changes, are estimated (`piecewise_friction`). The strokes must
have different speeds, but need not be sines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws, Regime
from frictool.documents.quantity import Quantity, si_unit
from frictool.identify.estimators.piecewise_friction import (
    PiecewiseFriction,
    StrokeMeans,
    design,
    fit_pieces,
)
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs, intervals_around
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.clusters import clusters
from frictool.identify.regression.regression import solve
from frictool.identify.rows.regression_samples import RegressionSamples, joined
from frictool.identify.rows.slip_mask import slip_mask
from frictool.identify.rows.smoothing import choose_window, smoothed
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Matrix, Vector

COLUMNS = ("viscous", "coulomb", "offset")
NO_INERTIA = (
    "the method of sines cannot identify the inertia: the mean acceleration in the middle of a "
    "stroke is nearly zero"
)
GATE = 0.5  # speed above which samples are used, relative to the largest speed of the stroke
# allowed share of noise in the acceleration (`smoothing`), from which the window follows; the
# velocity only selects the samples
NOISE_SHARE = 0.02
FEWEST_STROKES = 8
# least ratio of the fastest to the slowest stroke's mean speed; below this ratio, viscous and
# Coulomb friction cannot be separated (4.37)
SPREAD = 1.2


@dataclass(frozen=True)
class StrokeRows:
    """Means over the middle of each stroke, one row (m,) per stroke.

    - acceleration: mean acceleration, (m,), rad/s^2 | m/s^2
    - position: position of each sample in the middle part of its stroke, (n,), rad | m
    - means: rows for `piecewise_friction`
    """

    acceleration: Vector
    position: Vector
    means: StrokeMeans


def sines(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return viscous friction, Coulomb friction, offset and knees, but no inertia.

    A knee is a speed at which the viscous friction changes. Raises UnusableLogs if a direction has
    too few strokes, or if all strokes have nearly the same speed.
    """
    rows = checked_stroke_rows(records, bench)
    effort = rows.means.effort
    fixed = {name: interval for name, interval in settings.fixed.items() if name in COLUMNS}
    rows = without(rows, fixed)
    if "viscous" in fixed:
        return _coulomb_and_offset(rows, effort, bench, settings.confidence, fixed)
    pieces, half = fit_rows(rows, bench, settings.confidence)
    value = pieces.solution.value
    count = len(pieces.knees)
    half[: value.size - count] = _of_fixed(
        rows, design(rows.means, pieces.knees), half[: value.size - count], fixed
    )
    free = [name for name in COLUMNS[1:] if name not in fixed]
    columns = {"viscous": 0, **{name: count + 1 + index for index, name in enumerate(free)}}
    estimates = {name: Interval.around(value[k], half[k]) for name, k in columns.items()}
    estimates["viscous"] = not_negative(estimates["viscous"])
    speeds = rows.means.mean(rows.means.speed)
    return SlidingFit(
        estimates,
        {"inertia": NO_INERTIA},
        float(np.linalg.norm(pieces.residual) / np.linalg.norm(effort)),
        None,
        pieces.solution.condition,
        rows.means.speed.size,
        {
            "strokes": effort.size,
            "knees": count,
            "slowest": float(speeds.min()),
            "fastest": float(speeds.max()),
        },
        None if count == 0 else Laws(regimes=regimes_of(pieces, half, bench)),
    )


def _column(name: str, means: StrokeMeans) -> Vector:
    if name == "viscous":
        return means.piece(0.0, np.inf)
    return means.sign if name == "coulomb" else np.ones(means.sign.size)


def without(rows: StrokeRows, fixed: Mapping[str, Interval]) -> StrokeRows:
    """Return the rows without the effort and without the columns of the parameters `fixed`."""
    if not fixed:
        return rows
    means = rows.means
    known = np.sum(
        [interval.value * _column(name, means) for name, interval in fixed.items()], axis=0
    )
    free = [_column(name, means) for name in COLUMNS[1:] if name not in fixed]
    columns = np.column_stack(free) if free else np.empty((means.sign.size, 0))
    return replace(rows, means=replace(means, effort=means.effort - known, columns=columns))


def _of_fixed(
    rows: StrokeRows, columns: Matrix, half: Vector, fixed: Mapping[str, Interval]
) -> Vector:
    weight = rows.means.weight
    squares = half**2
    for name, interval in fixed.items():
        reach = max(interval.high - interval.value, interval.value - interval.low)
        moved = np.linalg.lstsq(
            columns * weight[:, None], reach * _column(name, rows.means) * weight, rcond=None
        )[0]
        squares = squares + moved**2
    return np.asarray(np.sqrt(squares))


def _coulomb_and_offset(
    rows: StrokeRows, effort: Vector, bench: Bench, confidence: float, fixed: Mapping[str, Interval]
) -> SlidingFit:
    means = rows.means
    free = [name for name in COLUMNS[1:] if name not in fixed]
    if not free:
        raise UnusableLogs("all friction parameters are fixed, so that nothing is left to fit")
    target = means.effort - bench.mechanics.inertia.value * rows.acceleration
    solution = solve(means.columns, target, means.weight, means.cluster)
    half = _of_fixed(rows, means.columns, solution.half_width(confidence), fixed)
    estimates = intervals_around(free, solution.value, half)
    left = (target - means.columns @ solution.value) * means.weight
    residual = float(np.linalg.norm(left) / np.linalg.norm(effort * means.weight))
    return SlidingFit(
        estimates,
        {"inertia": NO_INERTIA},
        residual,
        None,
        solution.condition,
        means.speed.size,
        {"strokes": effort.size},
    )


def checked_stroke_rows(records: list[MotionRecord], bench: Bench) -> StrokeRows:
    """Return the means over the middle of each stroke (`stroke_rows`), and check them.

    Raises UnusableLogs if a direction has too few strokes, or if all have nearly the same speed.
    """
    rows = stroke_rows(records, bench)
    _check(rows.means)
    return rows


def stroke_rows(records: list[MotionRecord], bench: Bench) -> StrokeRows:
    """Return means over the middle of each stroke, with regressors of Coulomb and offset.

    Raises UnusableLogs if no stroke is long enough.
    """
    width = bench.mechanics.backlash
    backlash = 0.0 if width is None else max(width.interval)
    if not records:
        raise UnusableLogs("no log of sliding motion was provided")
    parts = [_gated(record, backlash) for record in records]
    samples = joined([part for part, _ in parts])
    position = np.concatenate([index for _, index in parts])
    if samples.velocity.size == 0:
        raise UnusableLogs(
            "the axis does not slip in the middle of any stroke; record longer strokes"
        )
    starts = np.flatnonzero(np.diff(samples.stroke, prepend=-1))
    lengths = np.diff(np.append(starts, samples.stroke.size))
    sign = samples.sign[starts]
    effort, acceleration = (
        np.add.reduceat(values, starts) / lengths
        for values in (samples.effort, samples.acceleration)
    )
    cluster = clusters(samples.stroke, samples.sign, samples.counts, samples.stroke.size)[starts]
    columns = np.column_stack((sign, np.ones(sign.size)))
    means = StrokeMeans(
        columns, effort, sign, np.sqrt(lengths), cluster, np.abs(samples.velocity), starts
    )
    return StrokeRows(acceleration, position, means)


def _gated(record: MotionRecord, backlash: float) -> tuple[RegressionSamples, Vector]:
    strokes = find_strokes(record)
    moving = strokes.number[strokes.sign != 0.0]
    lengths = np.bincount(moving) if moving.size else np.zeros(1)
    window = choose_window(
        record, float(np.median(lengths[lengths > 0])) if moving.size else 0.0, NOISE_SHARE
    )
    acceleration, velocity, effort = smoothed(record, window)
    mask = slip_mask(record, strokes, velocity, window, backlash)
    along = np.where(np.isfinite(velocity), velocity * strokes.sign, 0.0)
    largest = np.zeros(int(strokes.number[-1]) + 1)
    np.maximum.at(largest, strokes.number, along)
    mask &= along > GATE * largest[strokes.number]
    counts = np.abs(velocity[mask]) * record.period / record.resolution
    kept = RegressionSamples(
        acceleration[mask],
        velocity[mask],
        effort[mask],
        strokes.number[mask],
        strokes.sign[mask],
        counts,
    )
    return kept, record.position[mask] + 0.5 * record.resolution


def _check(means: StrokeMeans) -> None:
    sign = means.sign
    if min(np.sum(sign > 0.0), np.sum(sign < 0.0)) < FEWEST_STROKES // 2:
        raise UnusableLogs(
            f"{np.sum(sign > 0.0)} strokes forward and {np.sum(sign < 0.0)} backward certainly "
            f"slip; needed: at least {FEWEST_STROKES // 2} in each direction"
        )
    speed = means.mean(means.speed)
    if speed.max() < SPREAD * speed.min():
        raise UnusableLogs(
            f"all strokes have nearly the same speed ({speed.min():.3g} to {speed.max():.3g} rad/s "
            "or m/s), so that viscous and Coulomb friction cannot be separated; record sines of "
            "several speeds"
        )


def fit_rows(rows: StrokeRows, bench: Bench, confidence: float) -> tuple[PiecewiseFriction, Vector]:
    """Fit piecewise linear friction; return the fit and the half widths (p,) of its coefficients.

    The half widths include the effect of the range of the inertia in bench.yaml.
    """
    means = rows.means
    inertia = bench.mechanics.inertia
    pieces = fit_pieces(
        replace(
            means,
            effort=means.effort - inertia.value * rows.acceleration,
            nuisance=rows.acceleration[:, None],
        ),
        confidence=confidence,
    )
    half = pieces.solution.half_width(confidence)
    return pieces, np.hypot(half, _of_inertia(rows, pieces, inertia.interval, confidence))


def _of_inertia(
    rows: StrokeRows, pieces: PiecewiseFriction, ends: tuple[float, float], confidence: float
) -> Vector:
    """Return the half widths (p,) of the coefficients due to the uncertainty of the inertia.

    The inertia is assumed to be uniformly distributed between `ends`, the ends of the interval in
    bench.yaml. The speeds of the knees do not change.
    """
    means = rows.means
    rows_of = design(means, pieces.knees) * means.weight[:, None]
    moved = np.linalg.lstsq(
        rows_of, (ends[1] - ends[0]) * rows.acceleration * means.weight, rcond=None
    )[0]
    out = np.zeros(pieces.solution.value.size)
    out[: moved.size] = scipy.special.ndtri(0.5 + 0.5 * confidence) * np.abs(moved) / np.sqrt(12.0)
    return out


def not_negative(interval: Interval) -> Interval:
    """Replace a negative value and a negative lower end by 0, unless the upper end is negative."""
    return Interval(0.0, 0.0, interval.high) if interval.value < 0.0 < interval.high else interval


def regimes_of(pieces: PiecewiseFriction, half: Vector, bench: Bench) -> tuple[Regime, ...]:
    """Return the entries of a model document for the viscous friction above each knee.

    `half` (p,) are the half widths of the coefficients of `pieces`.
    """
    first = pieces.solution.value.size - len(pieces.knees)
    out = []
    for index, knee in enumerate(pieces.knees, start=1):
        viscous = Interval.around(pieces.solution.value[index], half[index], 0.0)
        out.append(regime(knee, float(half[first + index - 1]), viscous, bench))
    return tuple(out)


def regime(knee: float, reach: float, viscous: Interval, bench: Bench) -> Regime:
    """Return the entry of a model document for the viscous friction above one knee.

    - knee, reach: speed of the knee and half width of its interval, rad/s | m/s
    - viscous: viscous friction above the knee
    """
    above = Quantity(knee, max(knee - reach, 0.0), knee + reach, si_unit("velocity", bench.axis))
    return Regime(above, not_negative(viscous).estimate("viscous", bench.axis))
