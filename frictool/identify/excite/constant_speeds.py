"""Runs at constant speeds in both directions, for friction over speed (`stribeck-curve`).

A run is a motion in one direction from rest to rest. Its speed rises and falls as a raised cosine
and is constant in between. The spare effort (`half_sines.spare_effort`) is 90 % of the largest
effort minus dry friction and load. Half of the spare effort accelerates the axis, and at most half
overcomes viscous friction. Acceleration and deceleration of a run together take at most half of the
travel.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.half_sines import TOP_SHARE, Motion, joined, spare_effort

SPEEDS = 10  # default number of speeds
DURATION = 60.0  # s, default total duration of all runs at their constant speeds
FEWEST_SAMPLES = 400  # least number of samples of a run; `stribeck-curve` drops a run's ends
FEWEST_COUNTS = 50.0  # least distance of the slowest run, in encoder counts
RANGE = 1000.0  # largest ratio of two speeds
SHORTEST_RAMP = 20  # least number of samples from rest to the speed of a run


def chosen_speeds(
    limits: BenchLimits, period: float, step: float, duration: float, count: int
) -> list[float]:
    """Return `count` speeds in geometric progression, rad/s | m/s.

    Parameters
    ----------
    limits
        Limits of the bench.
    period, step
        Sample period [s] and encoder step [rad | m].
    duration
        Total duration of all runs at their constant speeds [s].
    count
        Number of speeds, each of which is run in both directions.

    Raises
    ------
    NoSolutionError
        If friction and load need all of the effort, or if the slowest speed is not below half of
        the fastest.
    """
    spare = 0.5 * spare_effort(limits)
    top = TOP_SHARE * limits.speed
    if limits.viscous > 0.0:
        top = min(top, spare / limits.viscous)
    if math.isfinite(limits.travel):
        top = min(top, math.sqrt(limits.travel * spare / limits.inertia / math.pi))
        top = min(top, 0.5 * limits.travel / (FEWEST_SAMPLES * period))
    slowest = max(top / RANGE, FEWEST_COUNTS * step * 2.0 * count / duration)
    if slowest >= 0.5 * top:
        raise NoSolutionError(
            f"speeds: the slowest run needs {slowest:.3g} {limits.unit}/s to pass "
            f"{FEWEST_COUNTS:g} encoder counts; allowed: below {0.5 * top:.3g}, half of the "
            "fastest; raise --duration or lower --speeds"
        )
    return [float(speed) for speed in np.geomspace(slowest, top, count)]


def constant_speeds(
    limits: BenchLimits, period: float, speeds: list[float], duration: float
) -> Motion:
    """Return position, velocity and acceleration (n,) of runs in both directions at each speed.

    - period: sample period, s
    - speeds: constant speeds of the runs, rad/s | m/s
    - duration: total duration of all runs at their constant speeds, s
    """
    start = limits.low if math.isfinite(limits.low) else 0.0
    parts: list[Motion] = []
    for speed in speeds:
        forward = _run(limits, period, speed, 0.5 * duration / len(speeds))
        end = start + forward[0][-1]
        position, velocity, acceleration = (signal[:-1] for signal in forward)
        parts += [
            (start + position, velocity, acceleration),
            (end - position, -velocity, -acceleration),
        ]
    return joined(parts, start)


def _run(limits: BenchLimits, period: float, speed: float, duration: float) -> Motion:
    """Return position, velocity and acceleration (n,) of one run from rest at position 0 to rest.

    The speed is constant for `duration` [s], or for a shorter time if the travel is too short.
    """
    acceleration = 0.5 * spare_effort(limits) / limits.inertia
    ramp = max(SHORTEST_RAMP, math.ceil(0.5 * math.pi * speed / acceleration / period))
    steady = max(FEWEST_SAMPLES, round(duration / period))
    if math.isfinite(limits.travel):
        possible = math.floor((1.0 - 1e-9) * limits.travel / (speed * period)) - ramp
        steady = max(1, min(steady, possible))
    angle = math.pi * np.arange(ramp) / ramp
    rising = 0.5 * speed * period * (np.arange(ramp) - ramp / math.pi * np.sin(angle))
    rate = math.pi * speed / (2.0 * ramp * period) * np.sin(angle)
    still = np.zeros(steady)
    middle = 0.5 * speed * period * ramp + speed * period * np.arange(steady, dtype=np.float64)
    whole = speed * period * (ramp + steady)
    index = np.arange(ramp)
    falling = 0.5 * speed * (1.0 + np.cos(angle))
    left = 0.5 * speed * period * (ramp - index - ramp / math.pi * np.sin(angle))
    return joined(
        [
            (rising, 0.5 * speed * (1.0 - np.cos(angle)), rate),
            (middle, speed + still, still),
            (whole - left, falling, -rate),
        ],
        whole,
    )
