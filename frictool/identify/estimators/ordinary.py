"""Plain least squares on position differences, as for thesis tables 4.2 and 4.3.

Noise of the differentiated position makes the fitted inertia too small. Samples at rest within a
stroke have full weight.
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
    """Return inertia, viscous friction, Coulomb friction and offset from all samples of strokes.

    Raises UnusableLogs if the axis never moves by more than one encoder count.
    """
    return differenced_fit(records, bench, settings, lambda rows: np.ones(rows.velocity.size))
