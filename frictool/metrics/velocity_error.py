"""Error of an estimated velocity."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def velocity_error_rms(estimated: NDArray[np.float64], velocity: NDArray[np.float64]) -> float:
    """Return the root mean square of estimated - velocity (n,) [rad/s or m/s]."""
    error = estimated - velocity
    largest = float(np.max(np.abs(error)))
    return 0.0 if largest == 0.0 else largest * float(np.sqrt(np.mean((error / largest) ** 2)))


def velocity_error_peak(estimated: NDArray[np.float64], velocity: NDArray[np.float64]) -> float:
    """Return the largest |estimated - velocity| (n,) [rad/s or m/s]."""
    return float(np.max(np.abs(estimated - velocity)))
