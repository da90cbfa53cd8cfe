"""Table 5.1's loops (5.2.4, 5.2.5): one mass, its controllers sampled at 1 kHz, a step of 1 m.

The plant is the one of the text: no Stribeck effect, no viscous friction, F_s above F_c. It rests
and slips exactly (engine/axis.py). The controllers see position and velocity as they are at the
sample; their command, within +-5 N, is held until the next one.

(5.39) and the PI are zero-order-hold equivalents: the integral takes e[k] after the command of
sample k, the derivative filter is (T_d/tau) (e - f), f the low-pass of e with tau = T_d/a. The
integral is held while the command is limited and its input drives it further there. T_i = 1: the
0.1 that is printed is linearly unstable.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import OK
from frictool.plant.axis import POSITION, STATE_SIZE, VELOCITY, AxisParameters
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

DRY = AxisParameters(inertia=1.0, viscous=0.0, coulomb=1.0, breakaway=1.5)
SMOOTH = AxisParameters(inertia=1.0, viscous=0.0, coulomb=0.1, breakaway=0.15)  # 5.2.5
PERIOD, LIMIT, BAND = 1e-3, 5.0, 0.02  # s, N, m
GAIN, INTEGRAL_TIME, DERIVATIVE_TIME, FILTER_RATIO = 2.1, 1.0, 3.4, 307.0
LAG = DERIVATIVE_TIME / FILTER_RATIO
SPEED_GAIN, SPEED_INTEGRAL_TIME, POSITION_GAIN = 8.0, 0.2, 10.0
NO_LIMITER, LIMITER = 0.0, 1.0


@kernel
def pid_output(memory: Vector, error: float) -> float:
    """(5.39) before its limit [N]; memory = (integral of e [m s], low-pass of e [m]); moves the
    low-pass to the next sample."""
    steepness = DERIVATIVE_TIME / LAG * (error - memory[1])
    memory[1] = error + math.exp(-PERIOD / LAG) * (memory[1] - error)
    return float(GAIN * (error + memory[0] / INTEGRAL_TIME + steepness))


@kernel
def pi_output(memory: Vector, error: float) -> float:
    """The speed controller before its limit [N]; memory[0] = integral of the speed error [m]."""
    return float(SPEED_GAIN * (error + memory[0] / SPEED_INTEGRAL_TIME))


@kernel
def integrate(memory: Vector, error: float, command: float) -> None:
    """The integral takes this sample's error, unless `command` [N] is beyond the limit and the
    error drives it further."""
    if not (abs(command) > LIMIT and command * error > 0.0):
        memory[0] += PERIOD * error


@kernel
def limited(command: float) -> float:
    return min(max(command, -LIMIT), LIMIT)


@kernel
def on_the_way(error: float, velocity: float, braking: float) -> bool:
    """(5.7): friction of `braking` = F_c' [N] alone ends at the target, give or take the band; m =
    1 kg."""
    path = velocity * velocity / (2.0 * braking)
    return path - BAND < abs(error) < path + BAND


@kernel
def run_pid(
    axis: Vector, limiter: float, coulomb: float, virtual: float, slope: float, positions: Vector
) -> int:
    """PID; with the limiter, -F_cv tanh(v/v_r) inside (5.7) for F_c' = `coulomb` + `virtual`
    (5.40), the integral frozen there.

    Fills positions (n,) [m], one a sample, and returns engine/status_codes.py. (5.41) prints its
    branches the other way round.
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


@kernel
def run_printed(
    axis: Vector, virtual: float, slope: float, coulomb: float, positions: Vector
) -> int:
    """(5.41) with its branches as they are printed: the PID inside (5.7), -F_cv tanh(v/v_r) outside
    of it, from rest."""
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


@kernel
def run_cascade(axis: Vector, root_gain: float, positions: Vector) -> int:
    """PI of the speed under the position's gain (`root_gain` 0) or under k sqrt(|e|) sign(e)
    (5.19), (5.42).

    Inside the band of the square-root law u = 0 and the integral is frozen. Fills positions (n,)
    [m]; returns engine/status_codes.py.
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
    """Positions (n,) [m] of a hold of `seconds`."""
    positions = np.empty(round(seconds / PERIOD))
    assert run_pid(axis.as_array(), limiter, axis.coulomb, virtual, slope, positions) == OK
    return positions


def printed_step(seconds: float) -> Vector:
    """Positions (n,) [m] of a hold of `seconds` under (5.41) as printed, with the friction of 5.2.5
    and F_cv = 1 N."""
    positions = np.empty(round(seconds / PERIOD))
    assert run_printed(SMOOTH.as_array(), 1.0, 0.01, SMOOTH.coulomb, positions) == OK
    return positions


def cascade_step(seconds: float, axis: AxisParameters = DRY, root_gain: float = 0.0) -> Vector:
    """Positions (n,) [m] of a hold of `seconds`."""
    positions = np.empty(round(seconds / PERIOD))
    assert run_cascade(axis.as_array(), root_gain, positions) == OK
    return positions
