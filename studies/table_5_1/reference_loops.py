"""Independent simulation of the loops of table 5.1 (5.2.4, 5.2.5): a mass, controllers at 1 kHz.

The plant is that of the text: no Stribeck effect, no viscous friction, F_s above F_c. Stick and
slip are simulated exactly (engine/axis.py). The controllers measure position and velocity exactly;
their command, within +-5 N, is held until the next sample. The reference is a step of 1 m.

(5.39) and the PI are zero-order-hold equivalents: the integral adds e[k] after the command of
sample k. The derivative filter is (T_d/tau) (e - f), with f the low-pass of e and tau = T_d/a. The
integral is held while the command is limited and the error would increase it further. T_i is 1,
because the printed value 0.1 is linearly unstable.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import OK
from frictool.plant.axis import POSITION, STATE_SIZE, VELOCITY, AxisParameters
from frictool.typing import Vector

DRY = AxisParameters(inertia=1.0, viscous=0.0, coulomb=1.0, breakaway=1.5)
SMOOTH = AxisParameters(inertia=1.0, viscous=0.0, coulomb=0.1, breakaway=0.15)  # 5.2.5
PERIOD, LIMIT, BAND = 1e-3, 5.0, 0.02  # s, N, m
GAIN, INTEGRAL_TIME, DERIVATIVE_TIME, FILTER_RATIO = 2.1, 1.0, 3.4, 307.0
LAG = DERIVATIVE_TIME / FILTER_RATIO
SPEED_GAIN, SPEED_INTEGRAL_TIME, POSITION_GAIN = 8.0, 0.2, 10.0
NO_LIMITER, LIMITER = 0.0, 1.0


def pid_output(memory: Vector, error: float) -> float:
    """Return the command of (5.39) before its limit [N], and advance the low-pass by one sample.

    memory: integral of e [m s], low-pass of e [m].
    """
    steepness = DERIVATIVE_TIME / LAG * (error - memory[1])
    memory[1] = error + math.exp(-PERIOD / LAG) * (memory[1] - error)
    return float(GAIN * (error + memory[0] / INTEGRAL_TIME + steepness))


def pi_output(memory: Vector, error: float) -> float:
    """Return the command of the speed controller before its limit [N].

    memory[0]: integral of the speed error [m].
    """
    return float(SPEED_GAIN * (error + memory[0] / SPEED_INTEGRAL_TIME))


def integrate(memory: Vector, error: float, command: float) -> None:
    """Add the error to the integral, unless it would increase a limited command [N]."""
    if not (abs(command) > LIMIT and command * error > 0.0):
        memory[0] += PERIOD * error


def limited(command: float) -> float:
    return min(max(command, -LIMIT), LIMIT)


def on_the_way(error: float, velocity: float, braking: float) -> bool:
    """Return True if a friction of `braking` [N] stops the mass of 1 kg within the band (5.7)."""
    path = velocity * velocity / (2.0 * braking)
    return path - BAND < abs(error) < path + BAND


def run_pid(
    axis: Vector, limiter: float, coulomb: float, virtual: float, slope: float, positions: Vector
) -> int:
    """Simulate the PID, with or without limiter.

    While (5.7) holds with F_c' = `coulomb` + `virtual` (5.40), the limiter freezes the integral,
    and the command is -F_cv tanh(v/v_r). The printed (5.41) has these branches exchanged. Fills
    positions (n,) [m]; returns a status of engine/status_codes.py.
    """
    state, memory = np.zeros(STATE_SIZE), np.zeros(2)
    for k in range(positions.shape[0]):
        positions[k] = state[POSITION]
        error, velocity = 1.0 - state[POSITION], state[VELOCITY]
        command = pid_output(memory, error)
        if limiter != NO_LIMITER and on_the_way(error, velocity, coulomb + virtual):
            command = -virtual * math.tanh(velocity / slope)
        else:
            integrate(memory, error, command)
        status = advance(state, limited(command), axis, PERIOD)
        if status != OK:
            return status
    return OK


def run_printed(
    axis: Vector, virtual: float, slope: float, coulomb: float, positions: Vector
) -> int:
    """Simulate (5.41) as printed, from rest: the PID while (5.7) holds, else -F_cv tanh(v/v_r)."""
    state, memory = np.zeros(STATE_SIZE), np.zeros(2)
    for k in range(positions.shape[0]):
        positions[k] = state[POSITION]
        error, velocity = 1.0 - state[POSITION], state[VELOCITY]
        command = pid_output(memory, error)
        if on_the_way(error, velocity, coulomb + virtual):
            integrate(memory, error, command)
        else:
            command = -virtual * math.tanh(velocity / slope)
        status = advance(state, limited(command), axis, PERIOD)
        if status != OK:
            return status
    return OK


def run_cascade(axis: Vector, root_gain: float, positions: Vector) -> int:
    """Simulate a PI of the speed below a position law.

    The position law is a gain (`root_gain` 0) or k sqrt(|e|) sign(e) (5.19), (5.42). Within the
    band of the square-root law u = 0 and the integral is frozen. Fills positions (n,) [m]; returns
    a status of engine/status_codes.py.
    """
    state, memory = np.zeros(STATE_SIZE), np.zeros(1)
    for k in range(positions.shape[0]):
        positions[k] = state[POSITION]
        error = 1.0 - state[POSITION]
        wanted = (
            POSITION_GAIN * error
            if root_gain == 0.0
            else math.copysign(root_gain * math.sqrt(abs(error)), error)
        )
        speed_error = wanted - state[VELOCITY]
        command = pi_output(memory, speed_error)
        if root_gain != 0.0 and abs(error) <= BAND:
            command = 0.0
        else:
            integrate(memory, speed_error, command)
        status = advance(state, limited(command), axis, PERIOD)
        if status != OK:
            return status
    return OK


def pid_step(
    seconds: float,
    axis: AxisParameters = DRY,
    limiter: float = NO_LIMITER,
    virtual: float = 0.0,
    slope: float = 0.01,
) -> Vector:
    """Return the positions (n,) [m] under the PID in a hold of `seconds`."""
    positions = np.empty(round(seconds / PERIOD))
    assert run_pid(axis.as_array(), limiter, axis.coulomb, virtual, slope, positions) == OK
    return positions


def printed_step(seconds: float) -> Vector:
    """Return the positions (n,) [m] under (5.41) as printed, in a hold of `seconds`.

    The friction is that of 5.2.5, and F_cv = 1 N.
    """
    positions = np.empty(round(seconds / PERIOD))
    assert run_printed(SMOOTH.as_array(), 1.0, 0.01, SMOOTH.coulomb, positions) == OK
    return positions


def cascade_step(seconds: float, axis: AxisParameters = DRY, root_gain: float = 0.0) -> Vector:
    """Return the positions (n,) [m] under the cascade in a hold of `seconds`."""
    positions = np.empty(round(seconds / PERIOD))
    assert run_cascade(axis.as_array(), root_gain, positions) == OK
    return positions
