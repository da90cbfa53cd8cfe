"""Time at the drive's limit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.sample_durations import sample_durations

# relative: a command that is limited is the limit itself but for the rounding of a target's or a
# log's numbers
AT_LIMIT = 1e-3
NEAR_LIMIT = 0.01  # relative: what a drive's own lag and gain leave of it


def commanded_saturation(
    time: NDArray[np.float64], command: NDArray[np.float64], limit: float
) -> float:
    """Time [s] for which |command| (n,), A or V, is at its `limit`; each sample stands until the
    next, `time` (n,) [s]."""
    return _total(time, command, limit * (1.0 - AT_LIMIT))


def measured_saturation(
    time: NDArray[np.float64], drive: NDArray[np.float64], limit: float, deviation: float
) -> float:
    """The same of a measured drive (n,) with white noise of standard `deviation`: within 1 % of the
    limit, or two deviations."""
    return _total(time, drive, limit - max(NEAR_LIMIT * limit, 2.0 * deviation))


def _total(time: NDArray[np.float64], drive: NDArray[np.float64], level: float) -> float:
    return float(np.sum(sample_durations(time)[np.abs(drive) >= level]))
