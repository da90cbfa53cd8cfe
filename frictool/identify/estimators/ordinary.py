"""Plain least squares (4.11)-(4.15) on differences of the position, every sample alike: what tables
4.2 and 4.3 start from.

Errors in the regressors attenuate the inertia, and the sticks count in full: it is here to compare
with.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.differences import differenced_fit


def ordinary(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Inertia, viscous, Coulomb and offset from all samples of all strokes. Raises NothingUsable
    where nothing moves."""
    return differenced_fit(records, bench, settings, lambda rows: np.ones(rows.velocity.size))
