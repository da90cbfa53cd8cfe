"""Energy of a step as defined for table 5.3."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.median import median


def energy(time: NDArray[np.float64], drive: NDArray[np.float64], window: float) -> float | None:
    """Return the mean square of the drive (n,) [A^2 | V^2] over the first `window` [s] of a step.

    This is (T_e/t_int) sum i^2 with t_int = `window`. Each sample holds until the next, so that an
    uneven sample rate does not matter. The result is None if the hold is shorter than the window.
    """
    period = median(np.diff(time))
    if float(time[-1] - time[0]) + 1.5 * period < window:
        return None
    edges = np.minimum(np.append(time, time[-1] + period) - time[0], window)
    largest = float(np.max(np.abs(drive))) or 1.0
    return largest * largest * float(np.sum((drive / largest) ** 2 * np.diff(edges)) / edges[-1])
