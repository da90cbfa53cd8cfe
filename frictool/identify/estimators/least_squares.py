"""Least squares (thesis 4.11 to 4.15) on smoothed signals of samples that certainly slip.

The samples are selected by thesis (4.18) with a speed threshold that follows from the encoder and
the motion. The selection excludes stick and the Stribeck effect. All samples have equal weights,
because the noise of the effort does not depend on speed. If friction still falls with speed in the
selected samples, `power_balance` is better; `auto` detects this.
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
    """Return inertia, viscous friction, Coulomb friction and offset by least squares.

    Raises UnusableLogs if the records have too few samples of sliding motion.
    """
    return weighted_fit(records, bench, settings, lambda rows: np.ones(rows.velocity.size))
