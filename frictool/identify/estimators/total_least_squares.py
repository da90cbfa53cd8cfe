"""Total least squares, for an encoder with much noise in acceleration and velocity.

Ordinary least squares make the parameter of a noisy regressor too small. Here the noise of each
column is known: acceleration and velocity have the filtered noise of the position
(`position_noise`), sign and constant have none. The noise variance of the effort is the mean square
residual minus the part that the noise of acceleration and velocity causes. M is the mean of row^T
row over the rows [regressors, effort], and S is the part of M that the noise causes. The estimate
theta solves (Golub and Van Loan 1980, generalised)

    (M - lambda S) [theta; -1] = 0

lambda is the smallest generalised eigenvalue, which is 1 if S is correct. S is diagonal: the filter
of the acceleration is even and the filter of the velocity odd, so that their noises at one time are
uncorrelated.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SLIDING, SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.regression_samples import (
    RegressionSamples,
    cluster_products,
    fit,
    free_columns,
    intervals,
    residuals,
    spread_as,
)
from frictool.identify.rows.slip_fit import slipping_fit
from frictool.identify.rows.smoothing import acceleration_filter, position_noise, smoothing_kernel
from frictool.typing import Matrix

# least noise relative to the effort's mean square; it prevents a division by zero
NEGLIGIBLE = 1e-12


def total_least_squares(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset by total least squares.

    Raises UnusableLogs if the records have too few samples of sliding motion, or if a part of the
    samples does not separate the parameters.
    """
    found = slipping_fit(
        records,
        bench,
        settings,
        lambda rows, used: _fit(rows, used, records[0], settings.confidence),
    )
    return replace(found, attenuation=0.0)


def _fit(
    samples: RegressionSamples, window: int, record: MotionRecord, confidence: float
) -> SlidingFit:
    plain = fit(samples, np.ones(samples.velocity.size), window, confidence, {"window": window})
    names, columns = free_columns(samples)
    places = [*(SLIDING.index(name) for name in names), -1]
    noise = _noise(samples, window, record)[np.ix_(places, places)]
    products, rows, cluster = cluster_products(samples, (*columns, samples.effort), window)
    noise = _of_effort(np.sum(products, axis=0) / float(np.sum(rows)), noise)
    estimates = intervals(
        products,
        rows,
        cluster,
        lambda total, count: errors_in_variables(total / count, noise),
        names,
        confidence,
    )
    return replace(
        plain,
        parameters=spread_as(
            plain.parameters,
            {name: one for name, one in estimates.items() if name in plain.parameters},
            samples,
        ),
    )


def _of_effort(mean: Matrix, noise: Matrix) -> Matrix:
    """Return the noise covariance `noise`, with the noise variance of the effort filled in.

    This variance is the mean square residual minus the part that the noise of the motion causes.
    """
    theta = np.append(errors_in_variables(mean, noise), -1.0)
    others = theta[:-1] @ noise[:-1, :-1] @ theta[:-1]
    out = noise.copy()
    out[-1, -1] = max(theta @ mean @ theta - others, NEGLIGIBLE * mean[-1, -1])
    return out


def _noise(samples: RegressionSamples, window: int, record: MotionRecord) -> Matrix:
    position = position_noise(record) ** 2
    g = smoothing_kernel(window, record.period)
    velocity = np.convolve(g, [1.0, 0.0, -1.0]) / (2.0 * record.period)
    left = float(np.mean(residuals(samples, np.ones(samples.velocity.size)) ** 2))
    floor = NEGLIGIBLE * float(np.mean(samples.effort**2))
    acceleration = acceleration_filter(window, record.period)
    return np.diag(
        [
            position * float(acceleration @ acceleration),
            position * float(velocity @ velocity),
            0.0,
            0.0,
            max(left, floor),
        ]
    )


def errors_in_variables(mean: Matrix, noise: Matrix) -> Matrix:
    """Return the parameters (p,) by total least squares.

    - mean: matrix M of the module docstring, mean of row^T row over the rows [regressors, effort],
      (p + 1, p + 1)
    - noise: matrix S, noise variances of the columns of a row, (p + 1, p + 1); the last variance,
      which belongs to the effort, must be positive

    Raises UnusableLogs if M is singular.
    """
    scale = np.sqrt(np.diag(mean))
    m, s = mean / np.outer(scale, scale), noise / np.outer(scale, scale)
    # 1/lambda is the largest eigenvalue of S relative to M; M is definite, S is not
    try:
        smallest = 1.0 / float(scipy.linalg.eigh(s, m, eigvals_only=True)[-1])
    except np.linalg.LinAlgError:
        raise UnusableLogs(
            "total least squares need every part of the logs to separate the parameters, but one "
            "does not; record more strokes in both directions, or use least-squares"
        ) from None
    left = m - smallest * s
    return np.asarray(np.linalg.solve(left[:-1, :-1], left[:-1, -1]) * scale[-1] / scale[:-1])
