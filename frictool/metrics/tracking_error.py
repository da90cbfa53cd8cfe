"""Tracking error: difference between the tracked signal (reference or profile) and the position."""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector


def tracking_error_peak(tracked: Vector, position: Vector) -> float:
    """Return the largest |tracked - position| [rad or m] of two signals (n,)."""
    return float(np.max(np.abs(tracked - position)))


def tracking_error_rms(tracked: Vector, position: Vector) -> float:
    """Return the root mean square of tracked - position [rad or m], two signals (n,)."""
    return root_mean_square(tracked - position)


def root_mean_square(error: Vector) -> float:
    """Return the root mean square of an error (n,), scaled so that no square overflows."""
    largest = float(np.max(np.abs(error)))
    return 0.0 if largest == 0.0 else largest * float(np.sqrt(np.mean((error / largest) ** 2)))
