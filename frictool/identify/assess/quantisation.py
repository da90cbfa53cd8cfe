"""Worst-case errors of inertia and viscous friction from differences of a quantised position.

The formulas are thesis (4.3) and (4.4) without a filter, and (4.8) and (4.9) with a filter.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def acceleration_error(step: float, response: NDArray[np.float64]) -> float:
    """Return the largest error of an acceleration due to the encoder's rounding to `step`.

    Each sample is assumed to have an error of half a step with the worst sign. `response` (n,) is
    the impulse response from the position to the acceleration, such as (1, -2, 1)/T^2 for the
    second difference with the sample period T.
    """
    return 0.5 * step * float(np.sum(np.abs(response)))


def inertia_error(
    inertia: float, step: float, period: float, effort: float, ratio: float = 1.0
) -> float:
    """Return the relative error of the inertia by thesis (4.3), or by (4.8) with a filter.

    - inertia: kg m^2 | kg
    - step: encoder step, rad | m
    - period: sample period, s
    - effort: largest effort, N m | N
    - ratio: fraction of the noise power that passes the filter, 0 to 1; 1 without a filter
    """
    return (
        inertia
        * math.sqrt(ratio)
        * acceleration_error(step, np.array([1.0, -2.0, 1.0]) / period**2)
        / effort
    )


def viscous_error(step: float, period: float, speed: float, ratio: float = 1.0) -> float:
    """Return the relative error of viscous friction by thesis (4.4), or by (4.9) with a filter.

    `step` is the encoder step [rad | m], `period` the sample period [s], `speed` the top speed
    [rad/s | m/s], and `ratio` the fraction of the noise power that passes the filter.
    """
    return math.sqrt(ratio) * step / (period * speed)
