"""Expected precision of least squares over smoothing windows (weak form).

g is the test function (plant/weak_form.py), c its second difference, and d the central difference.
Convolved (*) with g, the equation of motion contains no derivative of a measurement:

    inertia (c*x) + viscous (g*d*x) + coulomb (g*sign v) + offset = g*u + n
    n = g*e_u - (inertia c + viscous g*d) * e_x

x is the position, u the effort, v the velocity, and n the noise of a row; e_u and e_x are the
errors of effort and position. The estimate by least squares with the regressors G has the
covariance N^-1 C N^-1, where N = G'G and C is the covariance of G'n. The encoder's noise in the
regressor c*x decreases the fitted inertia by the relative amount (power of the noise)/(power of
c*x). This error is large if the window is too short.

The computed errors exceed the Cramér-Rao bound, because all rows have equal weight. They are
standard deviations if the encoder errors are independent, as in motions of about one count per
sample or more. The formulas (4.3) and (4.8) of the thesis are worst-case bounds.
"""

from __future__ import annotations

import itertools

import numpy as np

from frictool.identify.excite.cramer_rao import (
    PlannedStroke,
    PriorAxis,
    SensorPrecision,
    of_sliding,
    regressors,
)
from frictool.identify.rows.smoothing import SHORTEST
from frictool.plant.weak_form import sampled_test_function
from frictool.typing import Vector

STROKE_SHARE = 0.25  # longest window relative to the median stroke


def weak_deviation(
    strokes: list[PlannedStroke],
    axis: PriorAxis,
    sensing: SensorPrecision,
    window: int | None = None,
    share: float = 1.0,
) -> tuple[Vector, int]:
    """Return the rms errors (4,) of inertia, viscous, Coulomb, offset (SI), and the window length.

    - window: length of the window in samples; None selects the best window for the inertia
    - share: fraction of the acceleration's mean square that the other regressors do not explain

    The errors are inf if no stroke is longer than the window.
    """
    best = np.full(4, np.inf)
    chosen = window or SHORTEST
    longest = max(
        SHORTEST, int(np.median([one.duration for one in strokes]) / sensing.period * STROKE_SHARE)
    )
    choice = (
        sorted({2 * int(length / 2.0) + 1 for length in np.geomspace(SHORTEST, longest, 20)})
        if window is None
        else [window]
    )
    rows = [
        (stroke.times, regressors(stroke, axis, sensing, side))
        for stroke, side in itertools.product(strokes, (1.0, -1.0))
    ]
    for width in choice:
        deviation = _deviation(rows, axis, sensing, width, share)
        if deviation[0] < best[0]:
            best, chosen = deviation, width
    return best, chosen


def _deviation(
    strokes: list[tuple[float, Vector]],
    axis: PriorAxis,
    sensing: SensorPrecision,
    window: int,
    share: float,
) -> Vector:
    g = sampled_test_function(window)
    c = np.convolve(g, [1.0, -2.0, 1.0]) / sensing.period**2
    slope = np.convolve(g, np.array([1.0, 0.0, -1.0]) / (2.0 * sensing.period))
    by_position = axis.inertia * c + axis.viscous * slope[::-1]
    columns = strokes[0][1].shape[1]
    normal, covariance = np.zeros((columns, columns)), np.zeros((columns, columns))
    samples = 0.0
    for times, regressor in strokes:
        rows = regressor[window // 2 : regressor.shape[0] - window // 2]
        if rows.shape[0] < 2:
            continue
        samples += times * rows.shape[0]
        normal += times * (rows.T @ rows)
        covariance += times * (
            sensing.noise**2 * _gram(rows, g) + sensing.step**2 / 12.0 * _gram(rows, by_position)
        )
    scale = np.sqrt(np.diag(normal))
    if not np.all(scale > 0.0) or np.linalg.cond(normal / np.outer(scale, scale)) > 1e12:
        return np.full(4, np.inf)
    inverse = np.linalg.inv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    deviation = np.sqrt(np.diag(inverse @ covariance @ inverse))
    # decrease of the inertia by the noise in the acceleration
    pulled = axis.inertia * sensing.step**2 / 12.0 * float(c @ c) * samples * inverse[0, 0]
    deviation[0] = np.hypot(deviation[0] / np.sqrt(share), pulled / share)
    return of_sliding(deviation, axis)


def _gram(rows: Vector, kernel: Vector) -> Vector:
    """Return the covariance (p, p) of rows^T n, for white noise n of rms 1 filtered by `kernel`."""
    # numpy's transform, because the import of scipy.signal or scipy.fft takes longer
    count = rows.shape[0] + kernel.size - 1
    length = 1 << (count - 1).bit_length()
    transforms = np.fft.rfft(rows, length, axis=0) * np.fft.rfft(kernel, length)[:, None]
    columns = np.fft.irfft(transforms, length, axis=0)[:count]
    return np.asarray(columns.T @ columns)
