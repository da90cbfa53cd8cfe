"""Error of an estimated velocity."""

from __future__ import annotations

import numpy as np

from frictool.metrics.tracking_error import root_mean_square
from frictool.typing import Vector


def velocity_error_rms(estimated: Vector, velocity: Vector) -> float:
    """Return the root mean square of estimated - velocity [rad/s or m/s], two signals (n,)."""
    return root_mean_square(estimated - velocity)


def velocity_error_peak(estimated: Vector, velocity: Vector) -> float:
    """Return the largest |estimated - velocity| [rad/s or m/s] of two signals (n,)."""
    return float(np.max(np.abs(estimated - velocity)))
