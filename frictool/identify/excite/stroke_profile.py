"""Motion of one stroke from rest to rest: half sine, or trapezoid of the speed."""

from __future__ import annotations

import math

import numpy as np

from frictool.typing import Vector


def unit_profile(share: Vector, ramp: float | None) -> tuple[Vector, Vector, Vector]:
    """Return advance, speed and acceleration of a stroke of distance 1 and duration 1.

    Parameters
    ----------
    share
        Times (n,) relative to the duration, 0 to 1.
    ramp
        Share of the duration in which the trapezoid accelerates; it brakes in as much. At most 0.5;
        None is a half sine.

    Returns
    -------
    tuple of Vector
        Advance, speed and acceleration, each (n,).
    """
    if ramp is None:
        angle = math.pi * share
        return (
            0.5 * (1.0 - np.cos(angle)),
            0.5 * math.pi * np.sin(angle),
            0.5 * math.pi**2 * np.cos(angle),
        )
    top = top_speed(ramp)
    slope = top / ramp
    rising = np.minimum(share, ramp)
    falling = np.maximum(share - (1.0 - ramp), 0.0)
    advance = top * (share - rising) + 0.5 * slope * (rising**2 - falling**2)
    speed = slope * (rising - falling)
    side = (share < ramp).astype(np.float64) - (share > 1.0 - ramp)
    return advance, speed, np.asarray(slope * side)


def top_speed(ramp: float | None) -> float:
    """Return the top speed of a stroke of distance 1 and duration 1."""
    return 0.5 * math.pi if ramp is None else 1.0 / (1.0 - ramp)
