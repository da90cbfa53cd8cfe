"""Root mean square of the drive, a measure of the motor's heating."""

from __future__ import annotations

import numpy as np

from frictool.metrics.sample_durations import sample_durations
from frictool.typing import Vector


def drive_rms(time: Vector, drive: Vector) -> float:
    """Return the rms [A | V] of a drive (n,) over `time` (n,) [s]; noise is not removed.

    The drive counts as constant between two samples.
    """
    weight = sample_durations(time)
    largest = float(np.max(np.abs(drive)))
    if largest == 0.0:
        return 0.0
    share = drive / largest  # scaled, so that the square cannot overflow
    return largest * float(np.sqrt(np.sum(share**2 * weight) / np.sum(weight)))
