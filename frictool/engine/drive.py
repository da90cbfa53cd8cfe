"""Effort on a body as a function of time and motion: one formula for all kinds of drive.

    u(t) = offset + slope t + amplitude sin(frequency t + phase)
           - proportional (x - r) - derivative v - integral q
    r(t) = target + target_speed t              q' = x - r

constant, ramp  offset and slope
sine            amplitude, frequency, phase
spring          proportional = stiffness, r = free end of the spring (thesis 3.7.2)
PID             all three gains (thesis 3.40)

If the drive has a lag, u has the additional term `decaying` e^(-decay_rate t); only the simulation
of dynamic friction laws supports this term.

u is the effort, x the position, v the velocity, r the position reference, q the integral of x - r.
Apart from the sine, u is linear in time and state. With a fixed sign of the friction, the motion
therefore has a power series with recursive coefficients. Time t is measured from the start of the
run, also if a run has several drives in succession.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.runtime.kernels import kernel
from frictool.typing import Vector

(
    OFFSET,
    SLOPE,
    AMPLITUDE,
    FREQUENCY,
    PHASE,
    PROPORTIONAL,
    DERIVATIVE,
    INTEGRAL,
    TARGET,
    TARGET_SPEED,
    DECAYING,
    DECAY_RATE,
) = range(12)


class EffortFunction(NamedTuple):
    """Coefficients of the effort u(t) of this module, in SI units."""

    offset: float = 0.0  # N
    slope: float = 0.0  # N/s
    amplitude: float = 0.0  # N
    frequency: float = 0.0  # rad/s
    phase: float = 0.0  # rad
    proportional: float = 0.0  # N/m
    derivative: float = 0.0  # N s/m
    integral: float = 0.0  # N/(m s)
    target: float = 0.0  # m
    target_speed: float = 0.0  # m/s

    def as_array(self) -> Vector:
        """Return the coefficients (10,) for the kernels.

        Raises ValueError if a coefficient is not finite or the frequency is negative.
        """
        array = np.array(self, dtype=np.float64)
        if not np.all(np.isfinite(array)):
            raise ValueError(f"drive: found {self}; allowed: finite coefficients")
        if self.frequency < 0.0:
            raise ValueError(f"drive: found frequency {self.frequency} rad/s; allowed: at least 0")
        return array


def held(effort: float) -> EffortFunction:
    """Return the coefficients of a constant effort [N | N m]."""
    return EffortFunction(offset=effort)


def ramped(effort: float, rate: float, start: float = 0.0) -> EffortFunction:
    """Return the coefficients of a ramp with the slope `rate` [N/s | N m/s].

    effort [N | N m]: value at the time `start` [s].
    """
    return EffortFunction(offset=effort - rate * start, slope=rate)


def spring(stiffness: float, speed: float, position: float = 0.0) -> EffortFunction:
    """Return the effort of a spring whose free end moves at `speed` [m/s | rad/s].

    - stiffness [N/m | N m/rad]: stiffness of the spring
    - position [m | rad]: position of the free end at t = 0
    """
    return EffortFunction(proportional=stiffness, target=position, target_speed=speed)


def pid(proportional: float, derivative: float, integral: float, target: float) -> EffortFunction:
    """Return the effort of a PID position controller (thesis 3.40).

    - proportional, derivative, integral: gains Kp [N/m | N m/rad], Kv [N s/m | N m s/rad] and Ki
      [N/(m s) | N m/(rad s)]
    - target [m | rad]: reference
    """
    return EffortFunction(
        proportional=proportional, derivative=derivative, integral=integral, target=target
    )


@kernel
def effort(t: float, x: float, v: float, q: float, drive: Vector) -> float:
    """Return the effort u [N | N m] at the time t [s], position x, velocity v and integral q."""
    u: float = drive[OFFSET] + drive[SLOPE] * t
    if drive[AMPLITUDE] != 0.0:
        u += drive[AMPLITUDE] * math.sin(drive[FREQUENCY] * t + drive[PHASE])
    if drive.shape[0] > DECAYING:
        u += drive[DECAYING] * math.exp(-drive[DECAY_RATE] * t)
    u -= (
        drive[PROPORTIONAL] * (x - reference(t, drive))
        + drive[DERIVATIVE] * v
        + drive[INTEGRAL] * q
    )
    return u


@kernel
def effort_rate(t: float, drive: Vector) -> float:
    """Return the partial derivative of the effort u with respect to time [N/s | N m/s]."""
    rate: float = drive[SLOPE] + drive[PROPORTIONAL] * drive[TARGET_SPEED]
    if drive[AMPLITUDE] != 0.0:
        turn = math.cos(drive[FREQUENCY] * t + drive[PHASE])
        rate += drive[AMPLITUDE] * drive[FREQUENCY] * turn
    if drive.shape[0] > DECAYING:
        rate -= drive[DECAY_RATE] * drive[DECAYING] * math.exp(-drive[DECAY_RATE] * t)
    return rate


@kernel
def reference(t: float, drive: Vector) -> float:
    """Return the position reference r [m | rad] at time t [s] of the run."""
    r: float = drive[TARGET] + drive[TARGET_SPEED] * t
    return r
