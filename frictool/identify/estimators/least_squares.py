"""Least squares (4.11)-(4.15) on zero-phase smoothed signals, every sample that is certain to slip
alike: (4.18) with a derived threshold.

The effort's noise is the same at every speed, so that equal weights are the efficient ones; what
the power balance (4.23) weighs down, sticks and the Stribeck effect, the slip mask leaves out.
Where friction falls over speed beyond the mask, `power_balance` is the method, and `auto` finds
out.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.slip_fit import weighted_fit


def least_squares(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Inertia, viscous, Coulomb and offset from records of sliding motion. Raises NothingUsable
    where nothing moves enough."""
    return weighted_fit(records, bench, settings, lambda rows: np.ones(rows.velocity.size))
