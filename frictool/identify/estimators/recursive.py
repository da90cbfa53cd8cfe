"""Recursive least squares in square-root form, by Givens rotations of the QR triangle.

The thesis (4.16) updates a gain matrix instead; on long logs, rounding errors make this matrix
indefinite. The end of the log has the largest weight: the weight of a squared residual decreases by
the factor `forgetting` in the duration of a median stroke.

The result is the estimate at the end of the log. The interval comes from least squares with the
same weights. `path` returns the estimates along the log; they show whether a parameter drifts.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.givens import givens_path
from frictool.identify.rows.regression_samples import RegressionSamples, fit
from frictool.identify.rows.slip_fit import slipping_fit
from frictool.typing import Matrix

STROKE_FORGETTING = 0.99  # default of `forgetting`: a memory of about a hundred strokes


def recursive(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset at the end of the last record.

    Raises UnusableLogs if the records have too few samples of sliding motion.
    """
    forgetting = STROKE_FORGETTING if settings.forgetting is None else settings.forgetting
    return slipping_fit(
        records,
        bench,
        settings,
        lambda rows, used: _fit(rows, used, forgetting, settings.confidence),
    )


def row_forgetting(samples: RegressionSamples, of_stroke: float) -> float:
    """Return the forgetting factor of one row; the product over a median stroke is `of_stroke`."""
    lengths = np.bincount(samples.stroke)
    return float(of_stroke ** (1.0 / np.median(lengths[lengths > 0])))


def _fit(
    samples: RegressionSamples, window: int, of_stroke: float, confidence: float
) -> SlidingFit:
    root = math.sqrt(row_forgetting(samples, of_stroke))
    weight = root ** np.arange(samples.velocity.size - 1, -1, -1.0)
    return fit(samples, weight, window, confidence, {"window": window, "forgetting": of_stroke})


def path(samples: RegressionSamples, of_stroke: float) -> Matrix:
    """Return the estimates of inertia, viscous, Coulomb and offset after each row, (n, 4).

    Estimates are NaN as long as the rows do not determine all parameters.
    """
    rows = np.column_stack((*samples.columns, samples.effort))
    scale = np.linalg.norm(rows[:, :-1], axis=0)
    rows[:, :-1] /= scale
    out: Matrix = np.empty((rows.shape[0], 4))
    givens_path(rows, math.sqrt(row_forgetting(samples, of_stroke)), out)
    return np.asarray(out / scale)
