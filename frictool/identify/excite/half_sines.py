"""Half sines of the position from one turning place to the next: what tests of sliding are made of,
at rest where they join."""

from __future__ import annotations

import math

import numpy as np

from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.cramer_rao import Vector

Motion = tuple[Vector, Vector, Vector]  # position, velocity and acceleration, each (n,)
TOP_SHARE = (
    0.9  # of the speed and of the effort that the worst axis has: the position loop needs some
)


def half_sine(start: float, end: float, speed: float, period: float) -> Motion:
    """From `start` up to the sample before `end`; the top speed is at most `speed`."""
    samples = max(2, math.ceil(0.5 * math.pi * abs(end - start) / (speed * period)))
    rate, half = math.pi / (samples * period), 0.5 * (end - start)
    angle = rate * period * np.arange(samples)
    return (
        start + half * (1.0 - np.cos(angle)),
        half * rate * np.sin(angle),
        half * rate**2 * np.cos(angle),
    )


def joined(parts: list[Motion], end: float) -> Motion:
    """One motion of all parts in their order, and a last sample at rest where the last one ends."""
    position, velocity, acceleration = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    return np.append(position, end), np.append(velocity, 0.0), np.append(acceleration, 0.0)


def spare_effort(limits: BenchLimits) -> float:
    """What TOP_SHARE of the effort leaves beside dry friction, N m | N. Raises NoSolutionError
    where it leaves nothing."""
    left = TOP_SHARE * limits.effort - limits.steady
    if left <= 0.0:
        taking = "friction and load take" if limits.load else "friction takes"
        raise NoSolutionError(
            f"effort: {100 * TOP_SHARE:g} % of what the drive's limit gives is {TOP_SHARE * limits.effort:.3g}, {taking} up to "
            f"{limits.steady:.3g} of it: no test of sliding fits; raise actuator.limit or narrow mechanics.coulomb"
        )
    return left


def reachable_speed(limits: BenchLimits, distance: float) -> float:
    """The top speed of a half sine over `distance` that TOP_SHARE of speed and effort allow, rad/s
    | m/s.

    Of a sine of the speed, inertia a and viscous v are in quadrature; their sum is largest between
    the turn and the top speed: sqrt((inertia V w)^2 + (viscous V)^2) + coulomb + |offset| + load <=
    effort, w = 2 V/distance.

    Raises NoSolutionError where friction and load take all.
    """
    left = spare_effort(limits)
    fourth, second = (2.0 * limits.inertia / distance) ** 2, limits.viscous**2
    squared = 2.0 * left**2 / (second + math.sqrt(second**2 + 4.0 * fourth * left**2))
    return min(TOP_SHARE * limits.speed, math.sqrt(squared))
