"""Tracking error of a moving reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def tracking_error_peak(reference: NDArray[np.float64], position: NDArray[np.float64]) -> float:
    """Return the largest |reference - position| (n,) [rad or m]."""
    return float(np.max(np.abs(reference - position)))


def tracking_error_rms(reference: NDArray[np.float64], position: NDArray[np.float64]) -> float:
    """Return the root mean square of reference - position (n,) [rad or m]."""
    largest = tracking_error_peak(reference, position)
    if largest == 0.0:
        return 0.0
    return largest * float(np.sqrt(np.mean(((reference - position) / largest) ** 2)))
