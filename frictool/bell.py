"""The test function of the weak form, phi = (1 - s^2)^3 over a window, and zero with its slope and curvature at either end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def bell(window: int) -> Vector:
    """phi (window - 2,), sum 1, whose second difference has `window` values."""
    inner = np.linspace(-1.0, 1.0, window)[1:-1]
    phi = (1.0 - inner**2) ** 3
    return np.asarray(phi / phi.sum())
