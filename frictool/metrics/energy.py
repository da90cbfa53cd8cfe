"""Energy of a step as defined for thesis table 5.3."""

from __future__ import annotations

import numpy as np

from frictool.metrics.median import median
from frictool.typing import Vector


def energy(time: Vector, drive: Vector, energy_window: float) -> float | str:
    """Return the mean square of the drive (n,) [A^2 | V^2] over the first `energy_window` seconds.

    The window begins at the step. Each sample counts for the time until the next sample. If the
    samples end before the window ends, return the reason as text.
    """
    period = median(np.diff(time))
    if float(time[-1] - time[0]) + 1.5 * period < energy_window:
        return f"the reference is held for less than the window of {energy_window:g} s"
    edges = np.minimum(np.append(time, time[-1] + period) - time[0], energy_window)
    largest = float(np.max(np.abs(drive))) or 1.0
    return largest * largest * float(np.sum((drive / largest) ** 2 * np.diff(edges)) / edges[-1])
