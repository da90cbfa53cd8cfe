"""What an encoder's count can do at worst to a parameter that is identified by differentiation: (4.3), (4.4), filtered (4.8), (4.9)."""

from __future__ import annotations

import math


def inertia_error(inertia: float, step: float, period: float, effort: float, ratio: float = 1.0) -> float:
    """(4.3), (4.8): relative to the inertia. effort: the largest, N m | N; ratio: noise power that a filter leaves, 0..1."""
    return inertia * math.sqrt(ratio) * 2.0 * step / (period**2 * effort)


def viscous_error(step: float, period: float, speed: float, ratio: float = 1.0) -> float:
    """(4.4), (4.9): relative to the viscous friction. speed: the largest, rad/s | m/s."""
    return math.sqrt(ratio) * step / (period * speed)
