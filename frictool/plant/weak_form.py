"""Weak form of the equation of motion: test function, and weights of the effort.

The test function is phi = (1 - s^2)^3, with s from -1 to 1 over a window. Its value, slope and
curvature are 0 at both ends.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.typing import Vector


def sampled_test_function(window: int) -> Vector:
    """Return the test function, shape (window - 2,), with sum 1.

    The second difference of the test function, shape (window,), gives the weights of the measured
    positions.
    """
    inner = np.linspace(-1.0, 1.0, window)[1:-1]
    phi = (1.0 - inner**2) ** 3
    return np.asarray(phi / phi.sum())


def effort_weights(period: float, lag: float) -> tuple[float, float, float]:
    """Return the weights of the drives u[k-1], u[k], u[k+1] in a mean of the effort.

    lag [s]: time constant of the drive. The mean has a triangular window from sample k-1 to k+1;
    the sum of the weights is 1. Between a sample with the drive u0 and the next sample with u1, the
    effort is u0 + (u1 - u0) f(s). s rises from 0 to 1, f = (1 - e^(-r s))/(1 - e^-r), and
    r = period/lag.
    """
    if lag == 0.0:
        return 0.5, 0.5, 0.0
    r = period / lag
    if r < 1e-3:
        return 1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0  # f = s up to r/2
    whole = -math.expm1(-r)
    mean = (1.0 - whole / r) / whole
    rising = (0.5 - (whole - r * math.exp(-r)) / r**2) / whole
    return 0.5 - rising, rising + 0.5 - (mean - rising), mean - rising
