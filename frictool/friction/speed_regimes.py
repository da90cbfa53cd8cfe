"""Additional viscous friction above certain speeds (knees), as in figure 4.10 of the thesis.

    F = slope (|v| - knee) sign(v)    if |v| > knee, else 0

F is added to the force of the friction law for each pair (knee, slope) of the array
regimes = [knee_1, slope_1, knee_2, slope_2, ...] with rising knees. F is continuous; the derivative
of F jumps at the knee.
"""

from __future__ import annotations

import numpy as np

from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def knee_force(v: float, regimes: Vector) -> float:
    """Return the friction [N | N m] that all knees add at the velocity v [m/s | rad/s]."""
    total: float = regime_force(abs(v), regimes, count_passed_knees(abs(v), regimes))
    return total if v >= 0.0 else -total


@kernel
def regime_force(speed: float, regimes: Vector, passed: int) -> float:
    """Return the friction [N | N m] that the first `passed` knees add at a speed >= 0.

    With a constant `passed`, the force is a smooth function of the speed. An integrator requires a
    smooth force between two knee speeds.
    """
    total = 0.0
    for i in range(0, 2 * passed, 2):
        total += regimes[i + 1] * (speed - regimes[i])
    return total


@kernel
def count_passed_knees(speed: float, regimes: Vector) -> int:
    """Return the number of knee speeds below `speed` [m/s | rad/s]."""
    count = 0
    while 2 * count < regimes.shape[0] and regimes[2 * count] < speed:
        count += 1
    return count


@kernel
def knee_slope(v: float, regimes: Vector) -> float:
    """Return the derivative of `knee_force` with respect to v; at a knee, the limit from below."""
    total = 0.0
    speed = abs(v)
    for i in range(0, regimes.shape[0] - 1, 2):
        if speed > regimes[i]:
            total += regimes[i + 1]
    return total


def regimes_from(points: list[tuple[float, float]]) -> Vector:
    """Return the array [knee_1, slope_1, ...] for the kernels from pairs (knee, slope) in SI.

    Raises ValueError if the knees do not rise or the friction would fall with speed.
    """
    last, total = 0.0, 0.0
    for knee, slope in points:
        total += slope
        if not np.isfinite([knee, slope]).all() or knee <= last or total < 0.0:
            raise ValueError(
                f"speed regime at {knee:g} with slope {slope:g}; allowed: rising knees > 0; "
                "the sum of the slopes up to any knee must be >= 0"
            )
        last = knee
    return np.array(points, dtype=np.float64).ravel()
