"""Rest at the end of a long hold: thesis 5.4.1 asks for neither motion nor current, and a limit
cycle shows late."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def late_samples(time: NDArray[np.float64], after: float) -> slice | None:
    """The samples of a hold `time` (n,) [s] that lie at least `after` [s] behind its start; None
    where there are fewer than ten."""
    first = int(np.searchsorted(time, time[0] + after))
    return slice(first, time.size) if time.size - first >= 10 else None


def peak_to_peak(position: NDArray[np.float64]) -> float:
    """Peak to peak of the position (n,), rad or m. Still is: at most one sensor step, between two
    of which a resting axis may flicker."""
    return float(np.ptp(position))
