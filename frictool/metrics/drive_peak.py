"""Largest drive of a hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.white_noise import noise_floor


def drive_peak(measured: NDArray[np.float64]) -> float:
    """Return the largest |drive| [A | V] of a measured signal (n,) minus its noise floor.

    The result is at least 0; without noise it is the largest |drive|.
    """
    return max(0.0, float(np.max(np.abs(measured))) - noise_floor(measured))


def command_peak(command: NDArray[np.float64]) -> float:
    """Return the largest |command| [A | V] of a signal (n,) without noise."""
    return float(np.max(np.abs(command)))
