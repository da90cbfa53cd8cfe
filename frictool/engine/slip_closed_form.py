"""One phase of slip in closed form: the motion, its stop, and the time to cover a distance.

Speed w >= 0 and distance y >= 0 are measured in the direction of motion. The sign of the friction
is fixed and the command is constant. The drive approaches the command with `rate` = 1/lag; friction
damps the speed with `decay` = viscous/inertia:

    w' = -decay w + settled + transient e^{-rate t}

settled     acceleration at w = 0 under the final drive
transient   additional acceleration at t = 0, since the drive differs from its final value; 0
            without a lag

A phase is the tuple (w0, settled, transient, decay, rate) in SI units; w0 is the initial speed. The
acceleration has at most one zero. The speed is therefore monotone before and after this zero.
"""

from __future__ import annotations

import math

from frictool.engine.exponential_integrals import convolved, convolved_integral, phi1, phi2
from frictool.engine.safeguarded_newton import MAX_ITERATIONS, bracket_step
from frictool.runtime.kernels import kernel

Phase = tuple[float, float, float, float, float]

NEVER = -1.0
SPEED, DISTANCE = 0, 1


@kernel
def speed(phase: Phase, t: float) -> float:
    """Return the speed w(t) [rad/s | m/s] at time t [s] after the start of the phase."""
    w0, settled, transient, decay, rate = phase
    moving = w0 * math.exp(-decay * t) + settled * t * phi1(-decay * t)
    return moving if transient == 0.0 else moving + transient * convolved(decay, rate, t)


@kernel
def distance(phase: Phase, t: float) -> float:
    """Return the distance [rad | m] covered up to time t [s] after the start of the phase."""
    w0, settled, transient, decay, rate = phase
    moving = w0 * t * phi1(-decay * t) + settled * t * t * phi2(-decay * t)
    return moving if transient == 0.0 else moving + transient * convolved_integral(decay, rate, t)


@kernel
def acceleration(phase: Phase, t: float) -> float:
    """Return the acceleration w'(t) [rad/s^2 | m/s^2] at t [s] after the start of the phase."""
    w0, settled, transient, decay, rate = phase
    start = (settled + transient - decay * w0) * math.exp(-decay * t)
    return start if transient == 0.0 else start - transient * rate * convolved(decay, rate, t)


@kernel
def _turning_time(start: float, transient: float, decay: float, rate: float) -> float:
    if transient == 0.0:
        return math.inf
    r = start / (transient * rate)
    x = (decay - rate) * r
    if r <= 0.0 or r == math.inf or x <= -1.0:
        return math.inf
    return r if x == 0.0 else r * math.log1p(x) / x


@kernel
def _root(phase: Phase, quantity: int, level: float, low: float, high: float) -> float:
    t = 0.5 * (low + high)
    for _ in range(MAX_ITERATIONS):
        if quantity == SPEED:
            ahead = speed(phase, t) - level
            slope = acceleration(phase, t)
        else:
            ahead = level - distance(phase, t)
            slope = -speed(phase, t)
        low, high, t, is_root = bracket_step(t, ahead, slope, low, high)
        if is_root:
            return t
    return t


@kernel
def fall_time(phase: Phase, level: float, duration: float) -> float:
    """Return the first t in [0, duration] at which the speed falls to `level`.

    The result is NEVER (-1) if the speed does not fall to `level` within `duration`.

    level: a speed of at most w0, the initial speed; 0 for the stop. If `level` equals w0, the
    result is 0 unless the speed rises at t = 0.
    """
    w0, settled, transient, decay, rate = phase
    if w0 - level > (abs(settled) + abs(transient) + decay * max(abs(w0), abs(level))) * duration:
        return NEVER  # not even the largest deceleration suffices
    start = settled + transient - decay * w0
    turning = _turning_time(start, transient, decay, rate)
    if start > 0.0 or (start == 0.0 and transient < 0.0):  # rises, then falls
        low, high = turning, duration
        if low >= high:
            return NEVER
    elif w0 == level:
        return 0.0
    else:  # falls, then rises
        low = 0.0
        high = min(turning, duration)
    if speed(phase, high) > level:
        return NEVER
    return _root(phase, SPEED, level, low, high)


@kernel
def rise_time(phase: Phase, level: float, duration: float) -> float:
    """Return the first t in [0, duration] at which the speed rises to `level`.

    The result is NEVER (-1) if the speed does not rise to `level` within `duration`.

    level: a speed of at least w0, the initial speed.
    """
    w0, settled, transient, decay, rate = phase
    return fall_time((-w0, -settled, -transient, decay, rate), -level, duration)


@kernel
def travel_time(phase: Phase, length: float, duration: float) -> float:
    """Return the time [s] in (0, duration] at which the distance `length` is covered.

    The result is NEVER (-1) if the distance covered within `duration` is shorter. The speed must
    not fall below zero within `duration`.
    """
    if distance(phase, duration) < length:
        return NEVER
    return _root(phase, DISTANCE, length, 0.0, duration)
