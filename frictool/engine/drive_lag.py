"""The drive of an axis under a held command: a first-order lag, and when it outgrows a breakaway
that grows with the time at rest."""

from __future__ import annotations

import math

from frictool.engine.safeguarded_newton import MAX_ITERATIONS, bracket_step
from frictool.friction.rising_breakaway import dwell_factor
from frictool.runtime.kernels import inner_kernel, kernel

NEVER = -1.0


@inner_kernel
def lagged_drive(drive: float, command: float, lag: float, t: float) -> float:
    """The drive after t [s] under a held command."""
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
    """Up to when, within `remaining`, `_steepness` is above the level, or NEVER: it has one
    maximum, at 2 lag - age."""
    if _steepness(age, lag, remaining) >= level:
        return remaining
    low, high = max(0.0, 2.0 * lag - age), remaining
    if low >= high or _steepness(age, lag, low) <= level:
        return NEVER
    t = 0.5 * (low + high)
    for _ in range(MAX_ITERATIONS):
        ahead = _steepness(age, lag, t) - level
        slope = (2.0 - (age + t) / lag) * (age + t) * math.exp(-t / lag)
        low, high, t, found = bracket_step(t, ahead, slope, low, high)
        if found:
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
    """First t in [0, remaining] at which settled - losing e^{-t/lag} reaches full
    dwell_factor(rested + t), or NEVER; it is below at 0.

    losing > 0, lag > 0. What is missing, full - lost/(age + t) - settled + losing e^{-t/lag}, falls
    while (age + t)^2 e^{-t/lag} > lost lag/losing: it rises, falls and rises again at most, and is
    zero first where it falls.
    """
    lost, age = (1.0 - fresh) * full * rise, rise + rested
    low, high = 0.0, _last_fall(age, lag, lost * lag / losing, remaining)
    if high == NEVER or full * dwell_factor(
        rested + high, fresh, rise
    ) > settled - losing * math.exp(-high / lag):
        return NEVER
    t = 0.5 * high
    for _ in range(MAX_ITERATIONS):
        left = losing * math.exp(-t / lag)
        ahead = full * dwell_factor(rested + t, fresh, rise) - settled + left
        slope = lost / ((age + t) * (age + t)) - left / lag
        low, high, t, found = bracket_step(t, ahead, slope, low, high)
        if found:
            break
    return t
