"""Recursive least squares (4.16) in square-root form: the triangle of QR is carried from row to row
by Givens rotations.

(4.16) carries the gain F, which rounding makes indefinite on long logs, and starts it at 1000 I, an
error that never quite leaves (a relative 278 % on the F_c of table 4.4). The triangle starts at
nothing. Forgetting: a square counts `forgetting` less with each median stroke that passes, so that
the end of the log tells most.

The last value is that of least squares with these weights, which also gives its interval (`fit`);
the way to it, `path`, shows drift.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.givens import givens_path
from frictool.identify.rows.regression_samples import RegressionSamples, fit
from frictool.identify.rows.slip_fit import slipping_fit

Matrix = NDArray[np.float64]
STROKE_FORGETTING = 0.99  # a hundred strokes of memory


def recursive(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Inertia, viscous, Coulomb and offset at the end of the last record. Raises NothingUsable
    where nothing moves enough."""
    forgetting = STROKE_FORGETTING if settings.forgetting is None else settings.forgetting
    return slipping_fit(
        records,
        bench,
        settings,
        lambda rows, used: _fit(rows, used, forgetting, settings.confidence),
    )


def row_forgetting(samples: RegressionSamples, of_stroke: float) -> float:
    """The forgetting of one row, from that of a median stroke."""
    lengths = np.bincount(samples.stroke)
    return float(of_stroke ** (1.0 / np.median(lengths[lengths > 0])))


def _fit(
    samples: RegressionSamples, window: int, of_stroke: float, confidence: float
) -> SlidingFit:
    root = math.sqrt(row_forgetting(samples, of_stroke))
    weight = root ** np.arange(samples.velocity.size - 1, -1, -1.0)
    return fit(samples, weight, window, confidence, {"window": window, "forgetting": of_stroke})


def path(samples: RegressionSamples, of_stroke: float) -> Matrix:
    """(n, 4), in the order of SLIDING: the parameters as they were known after each row, nan before
    they were determined.

    Columns are scaled to unit length, so that SI units do not decide what is determined.
    """
    rows = np.column_stack((*samples.columns, samples.effort))
    scale = np.linalg.norm(rows[:, :-1], axis=0)
    rows[:, :-1] /= scale
    out: Matrix = np.empty((rows.shape[0], 4))
    givens_path(rows, math.sqrt(row_forgetting(samples, of_stroke)), out)
    return np.asarray(out / scale)
