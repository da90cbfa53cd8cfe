"""Least squares weighted by the inverse variance of the measurement errors (footnote of 4.2.5.1),
the variance found over speed.

What the encoder leaves on a row, and what the model does not know of friction, is not alike at all
speeds. Residuals of a fit with equal weights, in classes of speed of equally many rows, tell the
variance of each class; a row then weighs its inverse.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.rows.regression_samples import RegressionSamples, residuals
from frictool.identify.rows.slip_fit import weighted_fit

CLASSES = 12
LARGEST_RATIO = 10.0  # between weights: a class that happens to fit does not take over


def weighted(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Inertia, viscous, Coulomb and offset from records of sliding motion. Raises NothingUsable
    where nothing moves enough."""
    return weighted_fit(records, bench, settings, inverse_deviation)


def inverse_deviation(samples: RegressionSamples) -> Vector:
    """The weight of each row (n,): the inverse standard deviation of the residuals of its class of
    speed. Raises NothingUsable."""
    residual, speed = residuals(samples, np.ones(samples.velocity.size)), np.abs(samples.velocity)
    edges = np.quantile(speed, np.linspace(0.0, 1.0, CLASSES + 1)[1:-1])
    place = np.searchsorted(edges, speed)
    rows = np.bincount(place, minlength=CLASSES)
    deviation = np.sqrt(np.bincount(place, residual**2, CLASSES) / np.maximum(rows, 1))
    floor = float(deviation.max()) / LARGEST_RATIO
    return (
        np.asarray((1.0 / np.maximum(deviation, floor))[place])
        if floor > 0.0
        else np.ones(speed.size)
    )
