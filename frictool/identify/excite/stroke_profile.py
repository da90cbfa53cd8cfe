"""Motion of one stroke from rest to rest, with a half sine as speed over time.

Trapezoidal speed profiles have no advantage with fine encoders, and need far longer tests with
coarse encoders.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.typing import Vector

TOP_SPEED = 0.5 * math.pi  # top speed of a stroke of distance 1 and duration 1


def unit_profile(share: Vector) -> tuple[Vector, Vector, Vector]:
    """Return position, speed and acceleration (n,) of a stroke of distance 1 and duration 1.

    `share` (n,) contains the times, 0 to 1.
    """
    angle = math.pi * share
    return (
        0.5 * (1.0 - np.cos(angle)),
        TOP_SPEED * np.sin(angle),
        0.5 * math.pi**2 * np.cos(angle),
    )
