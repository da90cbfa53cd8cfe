"""Root mean square of the drive: what heats the motor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.sample_durations import sample_durations


def drive_rms(time: NDArray[np.float64], drive: NDArray[np.float64]) -> float:
    """sqrt(sum i^2 dt / sum dt) of a drive (n,), A or V, with its noise; each sample holds until
    the next, `time` (n,) [s]."""
    weight, largest = sample_durations(time), float(np.max(np.abs(drive)))
    if largest == 0.0:
        return 0.0
    share = drive / largest  # whose square is a number whatever a broken sensor shows
    return largest * float(np.sqrt(np.sum(share**2 * weight) / np.sum(weight)))
