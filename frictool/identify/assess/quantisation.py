"""What an encoder's count can do at worst to a parameter that is identified by differentiation:
(4.3), (4.4), filtered (4.8), (4.9)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def acceleration_error(step: float, response: NDArray[np.float64]) -> float:
    """rad/s^2 | m/s^2 that counts of `step` can make of an acceleration: half a count each, all
    with the worst sign.

    response (n,): of the filter from what is counted to the acceleration; (1, -2, 1)/T^2 for
    (4.3)'s double difference.
    """
    return 0.5 * step * float(np.sum(np.abs(response)))


def inertia_error(
    inertia: float, step: float, period: float, effort: float, ratio: float = 1.0
) -> float:
    """(4.3), (4.8): relative to the inertia. effort: the largest, N m | N; ratio: noise power that
    a filter leaves, 0..1."""
    return (
        inertia
        * math.sqrt(ratio)
        * acceleration_error(step, np.array([1.0, -2.0, 1.0]) / period**2)
        / effort
    )


def viscous_error(step: float, period: float, speed: float, ratio: float = 1.0) -> float:
    """(4.4), (4.9): relative to the viscous friction. speed: the largest, rad/s | m/s."""
    return math.sqrt(ratio) * step / (period * speed)
