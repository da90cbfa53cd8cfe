"""Least squares on position differences of samples faster than a threshold (thesis 4.18).

The default threshold is a tenth of the top speed. The method `least_squares` derives its threshold
from encoder and motion instead.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.difference_fit import differenced_fit
from frictool.identify.rows.regression_samples import RegressionSamples
from frictool.typing import Vector

SHARE_OF_TOP_SPEED = 0.1


def threshold(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset from fast samples.

    Raises UnusableLogs if too few samples are faster than the threshold.
    """
    return differenced_fit(records, bench, settings, lambda rows: faster(rows, settings.threshold))


def faster(samples: RegressionSamples, slowest: float | None) -> Vector:
    """Return the weight of each row (n,): 1 if its speed exceeds `slowest` [rad/s | m/s], else 0.

    If `slowest` is None, the limit is a tenth of the top speed.
    """
    speed = np.abs(samples.velocity)
    least = SHARE_OF_TOP_SPEED * float(speed.max()) if slowest is None else slowest
    return np.where(speed > least, 1.0, 0.0)
