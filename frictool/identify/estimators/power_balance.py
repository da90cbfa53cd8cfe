"""Power balance (thesis 4.19 to 4.23): least squares weighted by velocity.

    v u = inertia v a + viscous v^2 + coulomb |v| + offset v

u is the effort, v the velocity and a the acceleration. The weight reduces the influence of stick
and the Stribeck effect. If the settings contain a time constant, all samples are used, and the
signals are differences that pass a first-order low-pass filter, as in the thesis. Otherwise, only
samples that certainly slip are used, and the signals are smoothed.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.difference_fit import differenced_fit
from frictool.identify.rows.regression_samples import RegressionSamples
from frictool.identify.rows.slip_fit import weighted_fit
from frictool.typing import Vector

POWER_BALANCE = "power-balance"


def by_speed(samples: RegressionSamples) -> Vector:
    """Return the weights (n,) of the rows in the power balance: the speed |v| of each row."""
    return np.abs(samples.velocity)


def power_balance(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset by the power balance.

    Raises UnusableLogs if the records have too few samples of sliding motion, or if the settings
    contain a time constant and the bench declares loads.
    """
    if settings.time_constant is None:
        return weighted_fit(records, bench, settings, by_speed)
    if bench.load is not None and bench.load.terms != ("offset",):
        terms = ", ".join(bench.load.terms) or "none"
        raise UnusableLogs(
            f"power-balance with --time-constant cannot fit load.terms of the bench ({terms}); "
            "leave --time-constant out"
        )
    return differenced_fit(records, bench, settings, by_speed)
