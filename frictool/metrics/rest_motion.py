"""Motion at the end of a long hold (phase of constant reference).

Thesis 5.4.1 allows neither motion nor current at rest; a limit cycle may begin late in the hold.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector

# largest excess of a motion over one sensor step, relative to this step, that rounding explains
MOTION_TOLERANCE = 1e-6


def late_samples(time: Vector, after: float) -> slice | None:
    """Return the slice of the samples that are at least `after` [s] later than the first sample.

    `time`: times of the samples (n,) [s]. The result is None if the slice has fewer than ten
    samples.
    """
    if time[-1] < time[0] + after:
        return None
    first = int(np.searchsorted(time, time[0] + after))
    return slice(first, time.size) if time.size - first >= 10 else None


def peak_to_peak(rest_position: Vector) -> float:
    """Return the peak-to-peak value [rad or m] of the position (n,).

    Even at rest, the value may be one sensor step.
    """
    return float(np.ptp(rest_position))
