"""Least squares weighted by the inverse variance of the errors over speed (thesis 4.2.5.1).

Errors of the encoder, and friction that the model does not include, vary with speed. The rows are
divided into classes of speed with equally many rows. The residuals of a fit with equal weights give
the variance in each class. A row is weighted by the inverse variance of its class.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.regression_samples import RegressionSamples, residuals
from frictool.identify.rows.slip_fit import weighted_fit
from frictool.typing import Vector

CLASSES = 12
# largest ratio of two weights, so that a class whose residuals are small by chance does not
# dominate
LARGEST_RATIO = 10.0


def weighted(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset by weighted least squares.

    Raises UnusableLogs if the records have too few samples of sliding motion.
    """
    return weighted_fit(records, bench, settings, inverse_deviation)


def inverse_deviation(samples: RegressionSamples) -> Vector:
    """Return the factor of each row (n,): 1/(standard deviation of the residuals at its speed).

    All rows of a speed class have the same standard deviation. Raises UnusableLogs if the
    regressors are dependent.
    """
    residual = residuals(samples, np.ones(samples.velocity.size))
    speed = np.abs(samples.velocity)
    edges = np.quantile(speed, np.linspace(0.0, 1.0, CLASSES + 1)[1:-1])
    interval = np.searchsorted(edges, speed)
    rows = np.bincount(interval, minlength=CLASSES)
    deviation = np.sqrt(np.bincount(interval, residual**2, CLASSES) / np.maximum(rows, 1))
    floor = float(deviation.max()) / LARGEST_RATIO
    return (
        np.asarray((1.0 / np.maximum(deviation, floor))[interval])
        if floor > 0.0
        else np.ones(speed.size)
    )
