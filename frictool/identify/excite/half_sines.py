"""Half sines of the position from reversal to reversal, with zero speed at each reversal."""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import BenchLimits
from frictool.typing import Vector

Motion = tuple[Vector, Vector, Vector]  # position, velocity and acceleration, each (n,)
# used share of the worst axis's speed and effort; the position loop needs the remainder
TOP_SHARE = 0.9


def half_sine(start: float, end: float, speed: float, period: float) -> Motion:
    """Return position, velocity and acceleration (n,) of a half sine from `start` to `end`.

    The last sample is one sample period before the arrival at `end`. The top speed is at most
    `speed`.
    """
    samples = max(2, math.ceil(0.5 * math.pi * abs(end - start) / (speed * period)))
    rate = math.pi / (samples * period)
    half = 0.5 * (end - start)
    angle = rate * period * np.arange(samples)
    return (
        start + half * (1.0 - np.cos(angle)),
        half * rate * np.sin(angle),
        half * rate**2 * np.cos(angle),
    )


def joined(parts: list[Motion], end: float) -> Motion:
    """Return position, velocity and acceleration (n,) of all parts, then one sample at `end`."""
    position, velocity, acceleration = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    return np.append(position, end), np.append(velocity, 0.0), np.append(acceleration, 0.0)


def spare_effort(limits: BenchLimits) -> float:
    """Return 90 % of the effort at the drive's limit, minus dry friction and load, N m | N.

    Raises NoSolutionError if the result is not positive.
    """
    left = TOP_SHARE * limits.effort - limits.steady
    if left <= 0.0:
        needing = "friction and load need" if limits.load else "friction needs"
        unit = si_unit("effort", limits.axis)
        raise NoSolutionError(
            f"effort: {needing} up to {limits.steady:.3g} {unit}; allowed: below "
            f"{TOP_SHARE * limits.effort:.3g}, {100 * TOP_SHARE:g} % of the drive's largest "
            "effort; raise actuator.limit, or narrow mechanics.coulomb"
        )
    return left


def reachable_speed(limits: BenchLimits, distance: float) -> float:
    """Return the largest top speed of a half sine over `distance`, rad/s | m/s.

    Along a half sine, the acceleration and the speed are 90 degrees out of phase. The largest
    effort is therefore sqrt((inertia V w)^2 + (viscous V)^2) + coulomb + |offset| + load, with the
    top speed V and w = 2 V/distance. This effort must not exceed TOP_SHARE of the effort at the
    drive's limit. Raises NoSolutionError if friction and load need all of the allowed effort.
    """
    left = spare_effort(limits)
    fourth = (2.0 * limits.inertia / distance) ** 2
    second = limits.viscous**2
    squared = 2.0 * left**2 / (second + math.sqrt(second**2 + 4.0 * fourth * left**2))
    return min(TOP_SHARE * limits.speed, math.sqrt(squared))
