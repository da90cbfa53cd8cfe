"""The power balance (4.19)-(4.23): least squares weighted by velocity.

    v u = inertia v a + viscous v^2 + coulomb |v| + offset v

The weight keeps sticks and the Stribeck effect out (4.2.5.2) where no mask does. With a time
constant it is the thesis's own: differences through the first-order filter of 4.2.2, every sample;
without one, smoothed signals and the slip mask.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.rows.differences import differenced_fit
from frictool.identify.rows.regression_samples import RegressionSamples
from frictool.identify.rows.slip_fit import weighted_fit


def by_speed(samples: RegressionSamples) -> Vector:
    """The weight of each row (n,): its speed."""
    return np.abs(samples.velocity)


def power_balance(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Inertia, viscous, Coulomb and offset from records of sliding motion. Raises UnusableLogs
    where nothing moves enough."""
    if settings.time_constant is None:
        return weighted_fit(records, bench, settings, by_speed)
    if bench.load is not None and bench.load.terms != ("offset",):
        terms = ", ".join(bench.load.terms) or "none"
        raise UnusableLogs(
            f"power-balance on differences does not know load.terms of the bench, {terms}; leave --time-constant out"
        )
    return differenced_fit(records, bench, settings, by_speed)
