"""Largest drive."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.white_noise import noise_floor


def drive_peak(measured: NDArray[np.float64]) -> float:
    """Largest |drive| of a measured signal (n,), A or V, less its noise floor; without noise it is
    the largest |drive|."""
    return max(0.0, float(np.max(np.abs(measured))) - noise_floor(measured))


def command_peak(command: NDArray[np.float64]) -> float:
    """Largest |command| (n,), A or V: it carries no noise."""
    return float(np.max(np.abs(command)))
