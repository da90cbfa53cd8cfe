"""Plain least squares on position differences, as for thesis tables 4.2 and 4.3.

Errors in the regressors make the fitted inertia too small, and samples at rest within a stroke have
full weight.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.difference_fit import differenced_fit


def ordinary(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous, Coulomb and offset from all samples of all strokes.

    Raises UnusableLogs if nothing moves.
    """
    return differenced_fit(records, bench, settings, lambda rows: np.ones(rows.velocity.size))
