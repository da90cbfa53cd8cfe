"""Power balance (thesis 4.19 to 4.23): least squares weighted by velocity.

    v u = inertia v a + viscous v^2 + coulomb |v| + offset v

The weight reduces the influence of stick and the Stribeck effect. If a time constant is set, the
method uses differences of all samples through a first-order filter, as in the thesis. Otherwise the
method uses smoothed signals of the samples that certainly slip.
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
    """Return the weights of the rows (n,): the speed of each row."""
    return np.abs(samples.velocity)


def power_balance(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous, Coulomb and offset of sliding records.

    Raises UnusableLogs if the motion is too small.
    """
    if settings.time_constant is None:
        return weighted_fit(records, bench, settings, by_speed)
    if bench.load is not None and bench.load.terms != ("offset",):
        terms = ", ".join(bench.load.terms) or "none"
        raise UnusableLogs(
            f"power-balance on differences cannot fit load.terms of the bench, {terms}; leave "
            "--time-constant out"
        )
    return differenced_fit(records, bench, settings, by_speed)
