"""Detection of an effort that saturates softly, or whose flat tops are hidden by noise.

A saturated effort is smaller than the effort that the motion needs. The search fits the following
model to the samples at which the axis slips:

    effort = S(inertia a + viscous v + coulomb s + offset + stiffness x + declared loads)
    S(u) = u (1 + |u/L|^p)^(-1/p)

s is the sign of the velocity and x the position. The limit L differs for positive and negative u.
The sharpness p is low for a soft saturation (tanh) and high for a clip. Loads and friction that
vary with position and speed can look like a saturation. The model is therefore compared with a
rival: a linear fit with additional columns over position and speed. The effort is saturated if S
reduces the largest efforts, and if one of two conditions holds:

- The model with S explains the effort better than the rival.
- The model with S explains the effort as well as the rival, and much better than a linear fit
  without the additional columns. This improvement must be significant over the strokes, or very
  large.

Each comparison must have the same result without the stroke that supports the result most.

A command with few levels, such as a pseudo-random binary sequence, has flat tops, too. S then
reduces the residual although nothing saturates: the limits of S clip the noise of the acceleration,
and the late jumps of a delayed effort. All linear fits therefore contain a delay to second order
(derivatives of the effort). The mean square effort of the noise of the acceleration is subtracted
from all squared residuals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.levenberg_marquardt import (
    LeastSquares,
    levenberg_marquardt,
)
from frictool.identify.regression.term_selection import by_stroke
from frictool.identify.rows.effects import SmoothedMotion
from frictool.identify.rows.load_columns import load_columns
from frictool.identify.rows.slip_fit import slipping_mask, stroke_samples
from frictool.identify.rows.smoothing import (
    acceleration_response,
    choose_window,
    measurement_noise,
    smoothed,
)
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import IntVector, Matrix, Vector

NOISE_SHARE = 0.03  # share of noise in the acceleration (`smoothing`)
MOST_ROWS = 3000  # largest number of samples in the fit; longer records are decimated
FEWEST_ROWS = 200  # least number of samples in slip for a decision
SHARPNESS = (2.5, 12.0)  # p of a soft saturation and of a clip
# This quantile of |effort| is the scale of the effort. Samples whose compression exceeds this
# quantile are the top samples. Compression is the relative reduction of the effort by S.
HIGHEST = 0.99
START = 1.1  # initial value of both limits L, relative to the scale of the effort
FARTHEST = 20.0  # largest factor between a limit L and the scale
MOST_EVALUATIONS = 60  # largest number of evaluations of S in one fit
COMPRESSED = 0.05  # compression above which a sample counts as saturated
LEAST_COMPRESSION = 0.08  # least mean compression of the top samples of a saturation
LARGEST_RESIDUAL = 0.15  # largest rms residual relative to the scale that allows a decision
BETTER = 0.85  # largest squared residual relative to the rival's that is better than the rival's
AS_GOOD = 1.1  # largest squared residual relative to the rival's that is as good as the rival's
MUCH_BETTER = 0.8  # like BETTER, relative to the linear fit, if the difference is certain
FAR_BETTER = 0.5  # like MUCH_BETTER, if the difference is not certain
CERTAIN = 6.0  # number of standard errors above which a mean over the strokes is certain
FEWEST_STROKES = 3
SLOW = 0.1  # speed, relative to top speed, at which the rival's Stribeck effect is 1/e


@dataclass(frozen=True)
class HiddenSaturation:
    """Saturation of a logged effort.

    - level: value at which the effort saturates, N m | N
    - needed: effort that the motion needs where the effort saturates, N m | N
    - share: fraction of the samples in slip whose effort the saturation reduces
    """

    level: float
    needed: float
    share: float


@dataclass(frozen=True)
class _Samples:
    """Samples of a record at which the axis slips.

    - model: regressors (n, k) of the model; the first is the acceleration
    - late: first and second derivative of the effort, (n, 2), the regressors of a delay
    - rivals: additional regressors (n, j) of the rival fit (module docstring)
    - effort: effort (n,)
    - stroke: number of the stroke of each sample, (n,)
    - noise: rms noise of the acceleration, divided by the rms acceleration
    """

    model: Matrix
    late: Matrix
    rivals: Matrix
    effort: Vector
    stroke: IntVector
    noise: float


def hidden_saturation(record: MotionRecord, bench: Bench) -> HiddenSaturation | None:
    """Return the saturation of a record's effort, or None if the record shows none.

    Raises UnusableLogs if a declared load needs a position that was not measured.
    """
    samples = _samples(record, bench)
    if samples is None:
        return None
    scale = float(np.quantile(np.abs(samples.effort), HIGHEST))
    effort = samples.effort / scale
    values = _linear(samples.model, effort)
    linear = np.column_stack((samples.model, samples.late))
    plain, rivals = (
        _squares(columns, effort, samples.noise)
        for columns in (linear, np.column_stack((linear, samples.rivals)))
    )
    start = np.append(values, 2 * [np.log(START)])
    soft, clip = (_saturating(samples.model, effort, p, start) for p in SHARPNESS)
    sharper = _saturating(samples.model, effort, SHARPNESS[-1], soft.unknowns)
    best, sharpness = min(
        zip((soft, clip, sharper), (*SHARPNESS, SHARPNESS[-1]), strict=True),
        key=lambda one: float(one[0].residual @ one[0].residual),
    )
    needed = samples.model @ best.unknowns[:-2]
    explained = effort - best.residual
    compression = 1.0 - np.abs(explained) / np.maximum(np.abs(needed), 1e-9)
    slope = np.clip(1.0 - compression, 0.0, 1.0) ** (sharpness + 1.0)
    squares = best.residual**2 - (samples.noise * best.unknowns[0] * slope) ** 2
    top = compression >= np.quantile(compression, HIGHEST)
    if compression[top].mean() < LEAST_COMPRESSION or not _explains(
        squares, plain, rivals, samples.stroke
    ):
        return None
    return HiddenSaturation(
        scale * float(np.abs(explained[top]).mean()),
        scale * float(np.abs(needed[top]).mean()),
        float(np.mean(compression > COMPRESSED)),
    )


def _samples(record: MotionRecord, bench: Bench) -> _Samples | None:
    """Return the samples of a record at which the axis slips; the rms of each regressor is 1.

    Return None if the samples are too few to show a saturation, or if the encoder's noise changes
    the computed effort of the inertia as much as a saturation would.
    """
    length = stroke_samples(record)
    if length == 0.0:
        return None
    window = choose_window(record, length, NOISE_SHARE)
    signals = smoothed(record, window)
    strokes = find_strokes(record)
    mask = slipping_mask(record, strokes, bench, signals[1], window, 1)
    slips = np.flatnonzero(mask)
    if slips.size < FEWEST_ROWS:
        return None
    step = max(1, slips.size // MOST_ROWS)
    rows = slips[::step]
    motion = SmoothedMotion(record, window, *signals, strokes.sign, mask)
    loads = [column[::step] for column in load_columns(motion, bench).values()]
    acceleration, v, effort = (signal[rows] for signal in signals)
    sign = strokes.sign[rows]
    noise = measurement_noise(record) * float(np.linalg.norm(acceleration_response(record, window)))
    noise /= float(np.sqrt(np.mean(acceleration**2)))
    if noise > LEAST_COMPRESSION:
        return None
    position = record.position[rows]
    x = position - position.mean()
    fall = np.exp(-np.abs(v) / (SLOW * np.abs(v).max()))
    rivals = [x**2, sign * x, sign * x**2, v * x, np.abs(v), v**2, v * np.abs(v), sign * fall]
    if bench.axis == "rotary":
        rivals += [np.sin(position), np.cos(position)]
    model = [acceleration, v, sign, np.ones(rows.size), x, *loads]
    stroke = np.unique(strokes.number[rows], return_inverse=True)[1]
    rate = np.gradient(signals[2])
    late = [rate[rows], np.gradient(rate)[rows]]
    columns = _of_size_one(model), _of_size_one(late), _of_size_one(rivals)
    return _Samples(*columns, effort, stroke, noise)


def _of_size_one(columns: list[Vector]) -> Matrix:
    matrix = np.column_stack(columns)
    size = np.sqrt(np.mean(matrix**2, axis=0))
    return np.asarray(matrix / np.where(size > 0.0, size, 1.0))


def _linear(columns: Matrix, effort: Vector) -> Vector:
    return np.asarray(np.linalg.lstsq(columns, effort, rcond=None)[0])


def _squares(columns: Matrix, effort: Vector, noise: float) -> Vector:
    """Return the squared residuals (n,) of a linear fit, minus the mean square effort of the noise.

    `columns` (n, k) begin with the acceleration, which has the relative rms noise `noise`.
    """
    values = _linear(columns, effort)
    return np.asarray((effort - columns @ values) ** 2 - (noise * values[0]) ** 2)


def _saturating(columns: Matrix, effort: Vector, sharpness: float, start: Vector) -> LeastSquares:
    """Fit the effort with a smooth saturation.

    The unknowns are the coefficients of `columns`, and the logarithms of the limits of positive and
    of negative effort.
    """

    def parts(unknowns: Vector) -> tuple[Vector, Vector, Vector, Vector]:
        needed = columns @ unknowns[:-2]
        farthest = np.log(FARTHEST)
        high, low = np.exp(np.clip(unknowns[-2:], -farthest, farthest))
        limit = np.where(needed > 0.0, high, low)
        ratio = np.clip(needed / limit, -FARTHEST, FARTHEST)
        share = (1.0 + np.abs(ratio) ** sharpness) ** (-1.0 / sharpness)
        return needed, limit, ratio * share, share ** (sharpness + 1.0)

    def residual(unknowns: Vector) -> Vector:
        _, limit, value, _ = parts(unknowns)
        return np.asarray(effort - limit * value)

    def jacobian(unknowns: Vector) -> Matrix:
        needed, limit, value, slope = parts(unknowns)
        by_limit = limit * value - needed * slope
        return -np.column_stack(
            (columns * slope[:, None], by_limit * (needed > 0.0), by_limit * (needed <= 0.0))
        )

    return levenberg_marquardt(residual, jacobian, start, 1e-5, MOST_EVALUATIONS)


def _explains(squares: Vector, plain: Vector, rivals: Vector, stroke: IntVector) -> bool:
    """Return whether a saturation explains the effort better than the linear fits.

    The arguments are squared residuals (n,): `squares` of the model with a saturation, `plain` of
    the linear fit, `rivals` of the linear fit with additional columns.
    """
    if squares.sum() > LARGEST_RESIDUAL**2 * squares.size or stroke.max() + 1 < FEWEST_STROKES:
        return False
    return _less(squares, BETTER * rivals, stroke) or (
        _less(squares, AS_GOOD * rivals, stroke)
        and _less(squares, MUCH_BETTER * plain, stroke)
        and (
            _less(squares, FAR_BETTER * plain, stroke)
            or _certain(by_stroke(plain - squares, stroke))
        )
    )


def _certain(gain: Vector) -> bool:
    """Return whether the mean of `gain` (one value per stroke) is far above its standard error."""
    return bool(np.mean(gain) > CERTAIN * np.std(gain, ddof=1) / np.sqrt(gain.size))


def _less(one: Vector, other: Vector, stroke: IntVector) -> bool:
    """Return whether sum(one) < sum(other), even without the stroke that favours this most."""
    gain = np.bincount(stroke, other - one)
    return bool(gain.sum() > max(gain.max(), 0.0))
