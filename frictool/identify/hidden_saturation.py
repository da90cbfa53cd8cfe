"""Detection of a saturated effort whose flat tops are hidden by noise.

A saturated effort stays at a level L although the motion needs more. The search fits

    effort = clip(inertia a + viscous v + coulomb s + offset + n, low, high)

to the slipping samples, and the same equation without clip. The additional terms n are x, v |v|,
and on a rotary axis sin x and cos x, so that a load over position or speed is not taken for a
saturation. The parameters are fitted to the samples whose predicted effort is between the limits; a
selection by the measured effort would bias the fit. The limits are near the extremes of the effort,
on one or both sides.

The effort is saturated if three conditions hold: the clip at least halves the squared residual; the
predicted effort exceeds a limit in a significant share of the samples; and in these samples the
effort does not rise with the predicted effort.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping_mask, stroke_samples
from frictool.identify.rows.smoothing import choose_window, smoothed
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import BoolVector, Matrix, Vector

MOST_ROWS = 4000  # rows of the fit; more are thinned out
FEWEST_ROWS = 200  # fewer rows are not judged
EXTREME = 0.005  # share of the samples beyond the extreme of the effort, for its noise
LEVELS = (1.0, 0.95, 0.9)  # limits relative to the extremes of the effort
START = 0.9  # limits of the first selection, relative to those of the clip
ROUNDS = 6  # selections by the predicted effort
FEWEST_INSIDE = 0.3  # least share of the samples between the limits
LEAST_GAIN = 0.5  # largest squared residual relative to that of the fit without clip
LEAST_SHARE = 0.01  # least share of the samples beyond a limit
FLAT = 0.2  # largest slope of the effort over the predicted one beyond the limits
EXCESS = (1.05, 3.0)  # allowed range of the largest predicted effort relative to the limit


@dataclass(frozen=True)
class HiddenSaturation:
    """Level of a saturated effort, largest effort needed [N m | N], and share of the samples."""

    level: float
    needed: float
    share: float


def hidden_saturation(record: MotionRecord, bench: Bench) -> HiddenSaturation | None:
    """Return the saturation of a record's effort, or None."""
    length = stroke_samples(record)
    if record.velocity is not None or length == 0.0:
        return None
    regressors, effort = _rows(record, bench, choose_window(record, length, SMALLEST_SHARE))
    if effort.size < FEWEST_ROWS:
        return None
    unclipped = _squares(effort - regressors @ _fit(regressors, effort))
    low, high = np.quantile(effort, [EXTREME, 1.0 - EXTREME])
    for level in LEVELS:
        for lower, upper in ((low, high), (-np.inf, high), (low, np.inf)):
            limits = level * lower, level * upper
            predicted = _predicted(regressors, effort, limits)
            if predicted is None:
                continue
            gain = _squares(effort - np.clip(predicted, *limits)) / unclipped
            if gain < LEAST_GAIN and (found := _judged(effort, predicted, limits)) is not None:
                return found
    return None


def _rows(record: MotionRecord, bench: Bench, window: int) -> tuple[Matrix, Vector]:
    """Return the regressors (n, k), each with a norm of 1, and the effort (n,)."""
    acceleration, velocity, effort = smoothed(record, window)
    strokes = find_strokes(record)
    slips = np.flatnonzero(slipping_mask(record, strokes, bench, velocity, window, 1))
    rows = slips[:: max(1, slips.size // MOST_ROWS)]
    v, x = velocity[rows], record.position[rows]
    columns = [acceleration[rows], v, strokes.sign[rows], np.ones(rows.size), x, v * np.abs(v)]
    if bench.axis == "rotary":
        columns += [np.sin(x), np.cos(x)]
    matrix = np.column_stack(columns)
    size = np.linalg.norm(matrix, axis=0)
    return matrix / np.where(size > 0.0, size, 1.0), effort[rows]


def _predicted(regressors: Matrix, effort: Vector, limits: tuple[float, float]) -> Vector | None:
    """Return the effort (n,) by a fit between the limits; None if too few samples lie there."""
    low, high = limits
    inside: BoolVector = (effort > START * low) & (effort < START * high)
    for _ in range(ROUNDS):
        if inside.mean() < FEWEST_INSIDE:
            return None
        predicted = regressors @ _fit(regressors[inside], effort[inside])
        selected = (predicted > low) & (predicted < high)
        if np.array_equal(selected, inside):
            break
        inside = selected
    return np.asarray(predicted)


def _judged(
    effort: Vector, predicted: Vector, limits: tuple[float, float]
) -> HiddenSaturation | None:
    """Return the saturation if the effort is flat beyond the limits, or None."""
    side = np.where(predicted > limits[1], 1.0, np.where(predicted < limits[0], -1.0, 0.0))
    beyond = side != 0.0
    share = float(beyond.mean())
    if share < LEAST_SHARE:
        return None
    size = (side * predicted)[beyond]
    slope = np.polyfit(size, (side * effort)[beyond], 1)[0] if np.ptp(size) > 0.0 else np.inf
    top = int(np.argmax(size))
    level = abs(limits[1] if side[beyond][top] > 0.0 else limits[0])
    if abs(slope) > FLAT or not EXCESS[0] < size[top] / level < EXCESS[1]:
        return None
    return HiddenSaturation(level, float(size[top]), share)


def _fit(regressors: Matrix, effort: Vector) -> Vector:
    return np.asarray(np.linalg.lstsq(regressors, effort, rcond=None)[0])


def _squares(values: Vector) -> float:
    return float(values @ values)
