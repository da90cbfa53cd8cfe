"""Motion at the end of a long hold.

Thesis 5.4.1 allows neither motion nor current at rest; a limit cycle may begin late in the hold.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector


def late_samples(time: Vector, after: float) -> slice | None:
    """Return the samples of a hold later than `after` [s]; None if they are fewer than ten."""
    if time[-1] < time[0] + after:
        return None
    first = int(np.searchsorted(time, time[0] + after))
    return slice(first, time.size) if time.size - first >= 10 else None


def peak_to_peak(rest_position: Vector) -> float:
    """Return the peak-to-peak value of the position (n,) [rad or m].

    Even at rest, the value may be one sensor step.
    """
    return float(np.ptp(rest_position))
