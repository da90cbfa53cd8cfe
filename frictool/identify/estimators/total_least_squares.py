"""Total least squares: for an encoder whose noise on the acceleration and velocity is not small
beside the noise of the effort.

Ordinary least squares attenuates what noisy regressors carry. The noise of the rows is known: of
acceleration and velocity that of the position (`position_noise`) through their filters, of sign and
constant none, and the effort's is told by the residuals. With M the mean of the rows' products
[regressors, effort] and S their noise's, the estimate solves (Golub and Van Loan 1980, generalised)

    (M - lambda S) [theta; -1] = 0        lambda the least generalised eigenvalue, 1 where S is
                                          right

The noise of acceleration and velocity at one instant is uncorrelated: one filter is even, the other
odd.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SLIDING, SlidingFit
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
from frictool.identify.rows.smoothing import acceleration_filter, bump, position_noise

Matrix = NDArray[np.float64]
# of the effort's mean square: the least noise, so that no noise at all is no division by zero
NEGLIGIBLE = 1e-12


def total_least_squares(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Inertia, viscous, Coulomb and offset from records of sliding motion. Raises NothingUsable
    where nothing moves enough."""
    return slipping_fit(
        records,
        bench,
        settings,
        lambda rows, used: _fit(rows, used, records[0], settings.confidence),
    )


def _fit(
    samples: RegressionSamples, window: int, record: MotionRecord, confidence: float
) -> SlidingFit:
    plain = fit(samples, np.ones(samples.velocity.size), window, confidence, {"window": window})
    names, columns = free_columns(samples)
    places = [*(SLIDING.index(name) for name in names), -1]
    noise = _noise(samples, window, record)[np.ix_(places, places)]
    products, rows, cluster = cluster_products(samples, (*columns, samples.effort), window)
    found = intervals(
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
            {name: one for name, one in found.items() if name in plain.parameters},
            samples,
        ),
    )


def _noise(samples: RegressionSamples, window: int, record: MotionRecord) -> Matrix:
    """S (5, 5): variances of the noise of acceleration, velocity, sign, constant and effort in one
    row."""
    position = position_noise(record) ** 2
    g = bump(window, record.period)
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
    """theta (p,) from the mean products (p + 1, p + 1) of [regressors, effort] and those of their
    noise, the effort's above 0."""
    scale = np.sqrt(np.diag(mean))
    m, s = mean / np.outer(scale, scale), noise / np.outer(scale, scale)
    # 1/lambda is the largest eigenvalue of S against M, and M is definite where S is not
    smallest = 1.0 / float(eigh(s, m, eigvals_only=True)[-1])
    left = m - smallest * s
    return np.asarray(np.linalg.solve(left[:-1, :-1], left[:-1, -1]) * scale[-1] / scale[:-1])
