"""Step responses in closed form."""

from __future__ import annotations

import math

import numpy as np

from frictool.typing import Vector


def second_order(time: Vector, damping: float, frequency: float) -> Vector:
    """Return the unit step response of 1/(1 + 2 damping s/frequency + s^2/frequency^2).

    damping < 1; the response is 0 before time 0.
    """
    damped = frequency * math.sqrt(1.0 - damping**2)
    t = np.maximum(time, 0.0)
    decay = np.exp(-damping * frequency * t)
    return 1.0 - decay * (np.cos(damped * t) + damping * frequency / damped * np.sin(damped * t))


def first_order(time: Vector, constant: float) -> Vector:
    """Return the unit step response of 1/(1 + constant s)."""
    return 1.0 - np.exp(-np.maximum(time, 0.0) / constant)


def overshoot_of(damping: float) -> float:
    """Return the overshoot of the second-order response in %."""
    return 100.0 * math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))
