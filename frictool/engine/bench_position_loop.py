"""Axis under the position controller of the bench, without the encoder's quantisation.

    error = reference - position        integral' = I error
    effort = P error + integral + D d/dt (r reference - position)

P, I and D are gains. The controller runs once per period; derivatives are backward differences.
With r = 1 the derivative acts on the error, with r = 0 on the position alone. A cascade of a
position gain k_p and a speed gain k_v has P = k_v k_p, D = k_v, r = 0. The commanded effort has no
delay and is held for a period. The drive follows the command, optionally with a lag. Without
quantisation, the simulated motion is a smooth function of the axis's parameters.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.engine.axis_motion import advance
from frictool.engine.drive_lag import lagged_drive
from frictool.engine.effort_replay import period_coefficients, slip_through_period
from frictool.engine.status_codes import NOT_FINITE, OK
from frictool.plant.axis import DRIVE, LAG, POSITION, VELOCITY
from frictool.plant.position_load import load_effort
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

PROPORTIONAL, INTEGRAL, DERIVATIVE, REFERENCE_RATE = 0, 1, 2, 3


class PositionServo(NamedTuple):
    """Gains P, I and D of the bench's position loop.

    Units are N/m, N/(m s) and N s/m for a linear axis, N m/rad, N m/(rad s) and N m s/rad for a
    rotary axis.

    - reference_rate: weight r of the reference in the derivative term
    - limit [N | N m]: largest effort
    """

    proportional: float
    integral: float = 0.0
    derivative: float = 0.0
    reference_rate: float = 0.0
    limit: float = math.inf


@kernel
def follow_reference(
    p: Vector,
    load: Vector,
    state: Vector,
    servo: Vector,
    reference: Vector,
    start: float,
    period: float,
    positions: Vector,
    velocities: Vector,
    efforts: Vector,
) -> int:
    """Simulate the axis under its position loop with the `reference` (n,); return a status.

    - p: parameters (engine/effort_replay.py `replay_parameters`)
    - load: array of the load (plant/position_load.py)
    - servo (5,): array of a `PositionServo`
    - start [N m | N]: first effort; if the loop has an integral gain, the initial integral is
      computed from `start`

    `state` (7,) is changed in place; positions, velocities and efforts (n,) are filled.
    engine/status_codes.py lists the statuses.
    """
    coefficients = np.empty((2, 6))
    period_coefficients(p, period, coefficients)
    held = 0.0
    before = state[POSITION] - period * state[VELOCITY]
    wanted_before = 2.0 * reference[0] - reference[1] if reference.shape[0] > 1 else reference[0]
    for k in range(reference.shape[0]):
        x = state[POSITION]
        rate = (servo[REFERENCE_RATE] * (reference[k] - wanted_before) - (x - before)) / period
        error = reference[k] - x
        direct = servo[PROPORTIONAL] * error + servo[DERIVATIVE] * rate
        held = (
            held + servo[INTEGRAL] * error * period
            if k > 0
            else (start - direct if servo[INTEGRAL] > 0.0 else 0.0)
        )
        before = x
        wanted_before = reference[k]
        effort = min(max(direct + held, -servo[4]), servo[4])
        if not math.isfinite(effort):
            return NOT_FINITE
        positions[k] = x
        velocities[k] = state[VELOCITY]
        efforts[k] = effort
        opposing = load_effort(load, x + 0.5 * period * state[VELOCITY])
        command = effort - opposing
        first = command if p[LAG] == 0.0 else (start - opposing if k == 0 else state[DRIVE])
        last = lagged_drive(first, command, p[LAG], period)
        if slip_through_period(state, first, last, command, p, coefficients):
            state[DRIVE] = last
        else:
            state[DRIVE] = first
            status = advance(state, command, p, period)
            if status != OK:
                return status
    return OK
