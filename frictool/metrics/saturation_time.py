"""Time at the drive's limit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.sample_durations import sample_durations

# relative tolerance of a limited command, for rounding on the target or in the log
AT_LIMIT = 1e-3
NEAR_LIMIT = 0.01  # relative tolerance of a measured drive, for its lag and gain error


def commanded_saturation(
    time: NDArray[np.float64], command: NDArray[np.float64], limit: float
) -> float:
    """Return the time [s] for which |command| (n,) [A | V] is at its `limit`.

    Each sample holds until the next, `time` (n,) [s].
    """
    return _total(time, command, limit * (1.0 - AT_LIMIT))


def measured_saturation(
    time: NDArray[np.float64], drive: NDArray[np.float64], limit: float, deviation: float
) -> float:
    """Return the time [s] for which a measured |drive| (n,) [A | V] is at its `limit`.

    The tolerance is 1 % of the limit or two standard deviations of the drive's white noise,
    whichever is larger; `deviation` is one standard deviation.
    """
    return _total(time, drive, limit - max(NEAR_LIMIT * limit, 2.0 * deviation))


def _total(time: NDArray[np.float64], drive: NDArray[np.float64], level: float) -> float:
    return float(np.sum(sample_durations(time)[np.abs(drive) >= level]))
