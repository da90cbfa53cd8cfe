"""Drive with a first-order lag, and the time at which the drive's effort reaches the breakaway.

The command is constant, and the breakaway rises with the axis's time at rest.
"""

from __future__ import annotations

import math

from frictool.engine.safeguarded_newton import MAX_ITERATIONS, bracket_step
from frictool.friction.rising_breakaway import dwell_factor
from frictool.runtime.kernels import inner_kernel, kernel

NEVER = -1.0


@inner_kernel
def lagged_drive(drive: float, command: float, lag: float, t: float) -> float:
    """Return the drive at time t [s] under a constant command; `drive` is its value at t = 0."""
    return (
        command
        if drive == command or lag == 0.0
        else command + (drive - command) * math.exp(-t / lag)
    )


@kernel
def _steepness(age: float, lag: float, t: float) -> float:
    return (age + t) * (age + t) * math.exp(-t / lag)


@kernel
def _last_fall(age: float, lag: float, level: float, remaining: float) -> float:
    if _steepness(age, lag, remaining) >= level:
        return remaining
    low = max(0.0, 2.0 * lag - age)
    high = remaining
    if low >= high or _steepness(age, lag, low) <= level:
        return NEVER
    t = 0.5 * (low + high)
    for _ in range(MAX_ITERATIONS):
        ahead = _steepness(age, lag, t) - level
        slope = (2.0 - (age + t) / lag) * (age + t) * math.exp(-t / lag)
        low, high, t, is_root = bracket_step(t, ahead, slope, low, high)
        if is_root:
            break
    return t


@kernel
def outgrowing_time(
    full: float,
    fresh: float,
    rise: float,
    rested: float,
    settled: float,
    losing: float,
    lag: float,
    remaining: float,
) -> float:
    """Return the first t in [0, remaining] at which the effort reaches the breakaway.

    The result is NEVER (-1) if the effort does not reach the breakaway in this interval.

    effort(t)    = settled - losing e^{-t/lag}              losing > 0, lag > 0
    breakaway(t) = full dwell_factor(rested + t, fresh, rise)
                 = full - lost/(age + t)     age = rise + rested, lost = (1 - fresh) full rise

    - settled: final effort [N m | N]
    - losing: final effort minus effort at t = 0 [N m | N]
    - lag [s]: time constant of the drive
    - full: breakaway after a long rest [N m | N]
    - fresh: breakaway just after a stop, divided by `full`
    - rise [s]: time at rest after which half of the growth is reached
    - rested [s]: time at rest before t = 0

    At t = 0 the effort must be below the breakaway.
    """
    lost = (1.0 - fresh) * full * rise
    age = rise + rested
    low = 0.0
    high = _last_fall(age, lag, lost * lag / losing, remaining)
    if high == NEVER or full * dwell_factor(
        rested + high, fresh, rise
    ) > settled - losing * math.exp(-high / lag):
        return NEVER
    t = 0.5 * high
    for _ in range(MAX_ITERATIONS):
        left = losing * math.exp(-t / lag)
        ahead = full * dwell_factor(rested + t, fresh, rise) - settled + left
        slope = lost / ((age + t) * (age + t)) - left / lag
        low, high, t, is_root = bracket_step(t, ahead, slope, low, high)
        if is_root:
            break
    return t
