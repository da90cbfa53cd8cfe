"""Simulation of an axis under a measured effort, optionally corrected by measured positions.

    effort[k] --> axis --> position[k+1], velocity[k+1]

If the drive has no lag, the effort is constant within a period. If the drive has a lag, the effort
changes from effort[k] to effort[k+1] within the period.

In most periods the axis slips in one direction under linear friction, without an event. The motion
over such a period is linear in the state; its coefficients are computed once. The
effort of a lagged drive lies between effort[k] and effort[k+1]. A slip that does not stop under the
lower of these two (counted in the direction of motion) therefore does not stop in this period. All
other periods are simulated by engine/axis_motion.py. A load that depends on position
(plant/position_load.py) is evaluated once per period, at its middle; the error is of second order
in the period.

The correction corresponds to an observer with constant gains: before each period, `gains` times
(measured - position) is added to position and velocity. With zero gains, the simulation is open
loop. With the gains of a Kalman filter, measured - position is the innovation.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine.axis_motion import advance
from frictool.engine.exponential_integrals import convolved, convolved_integral, phi1, phi2
from frictool.engine.status_codes import NOT_FINITE, OK
from frictool.plant import axis as ax
from frictool.plant import axis_friction_laws as al
from frictool.plant.axis import AxisParameters
from frictool.plant.position_load import load_effort
from frictool.runtime.kernels import inner_kernel, kernel
from frictool.typing import Vector

FREE = np.zeros(2)  # gains of a simulation without correction


def replay_parameters(axis: AxisParameters) -> Vector:
    """Return the parameters of `axis`, changed such that the command is an effort [N m | N].

    The drive constant is 1, and the drive has no limits.
    """
    return axis._replace(constant=1.0, drive_limit=math.inf, resistance=0.0).as_array()


@kernel
def period_coefficients(p: Vector, period: float, out: Vector) -> None:
    """Fill `out` (2, 6) with the coefficients of a slip over one period.

    Row 0 is for backward, row 1 for forward motion. Column 0 is the Coulomb friction. The speed
    and the distance after the period follow from the other columns (engine/slip_closed_form.py).
    """
    rate = 1.0 / p[ax.LAG] if p[ax.LAG] > 0.0 else 0.0
    for side in range(2):
        extended = p.shape[0] > al.PLAIN_SIZE
        viscous = p[al.VISCOUS_PAIR + side] if extended else p[ax.VISCOUS]
        decay = viscous / p[ax.INERTIA]
        out[side, 0] = p[al.COULOMB_PAIR + side] if extended else p[ax.COULOMB]
        out[side, 1] = math.exp(-decay * period)
        out[side, 2] = period * phi1(-decay * period)
        out[side, 3] = period * period * phi2(-decay * period)
        out[side, 4] = convolved(decay, rate, period) if rate > 0.0 else 0.0
        out[side, 5] = convolved_integral(decay, rate, period) if rate > 0.0 else 0.0


@inner_kernel
def slip_through_period(
    state: Vector, first: float, last: float, command: float, p: Vector, c: Vector
) -> bool:
    """Advance a slipping axis by one period in closed form; return False if an event may occur.

    If the result is False, the state is unchanged.

    - first, last: efforts at the start and the end of the period [N m | N]
    - command: effort that the drive approaches
    - c (2, 6): coefficients of a slip over one period (`period_coefficients`)
    """
    velocity = state[ax.VELOCITY]
    if velocity == 0.0:
        return False
    direction = math.copysign(1.0, velocity)
    side = 1 if direction > 0.0 else 0
    if direction * state[ax.GAP] < 0.5 * p[ax.BACKLASH]:
        return False
    w = abs(velocity)
    least = 0.0
    most = math.inf
    if p.shape[0] > al.PLAIN_SIZE:
        if p[al.MAPPED] > 0.0 or p[al.DYNAMIC_SIZE] > 0.0:
            return False
        least, most = p[al.LAYER], p[al.REGIMES]
    low, high = (first, last) if direction * (last - first) > 0.0 else (last, first)
    slowest = (
        w * c[side, 1]
        + (direction * (low - p[ax.OFFSET]) - c[side, 0]) / p[ax.INERTIA] * c[side, 2]
    )
    fastest = (
        w * c[side, 1]
        + (direction * (high - p[ax.OFFSET]) - c[side, 0]) / p[ax.INERTIA] * c[side, 2]
    )
    if not (w > least and slowest > least and w < most and fastest < most):
        return False
    settled = (direction * (command - p[ax.OFFSET]) - c[side, 0]) / p[ax.INERTIA]
    transient = direction * (first - command) / p[ax.INERTIA]
    moved = w * c[side, 2] + settled * c[side, 3] + transient * c[side, 5]
    after = w * c[side, 1] + settled * c[side, 2] + transient * c[side, 4]
    ahead = state[ax.POSITION] + direction * moved
    if p.shape[0] > al.PLAIN_SIZE and direction * (p[al.STOP_PAIR + side] - ahead) <= 0.0:
        return False
    state[ax.POSITION] = ahead
    state[ax.LOAD_POSITION] += direction * moved
    state[ax.VELOCITY] = direction * after
    state[ax.MODE] = direction * ax.SLIPPING
    return True


@kernel
def replay(
    p: Vector,
    load: Vector,
    state: Vector,
    effort: Vector,
    measured: Vector,
    gains: Vector,
    period: float,
    positions: Vector,
    velocities: Vector,
) -> int:
    """Simulate the axis under `effort` (n,) [N m | N] from `state` (7,), in place.

    - p: parameters of an axis whose command is an effort (`replay_parameters`)
    - load: array of the load (plant/position_load.py)
    - measured (n,): measured positions [rad | m]
    - gains (2,): gains of the correction of position [-] and velocity [1/s]; if both gains are
      zero, `measured` is ignored

    Fills positions and velocities (n,) at the samples. If p has no lag, the effort is constant
    within a period. With a lag, the effort changes within a period from effort[k] to effort[k+1].
    Returns a status of engine/status_codes.py.
    """
    coefficients = np.empty((2, 6))
    period_coefficients(p, period, coefficients)
    lag = p[ax.LAG]
    n = effort.shape[0]
    share = -math.expm1(-period / lag) if lag > 0.0 else 1.0
    corrected = gains[0] != 0.0 or gains[1] != 0.0
    for k in range(n):
        positions[k], velocities[k] = state[ax.POSITION], state[ax.VELOCITY]
        if corrected:
            innovation = measured[k] - state[ax.POSITION]
            state[ax.POSITION] += gains[0] * innovation
            state[ax.LOAD_POSITION] += gains[0] * innovation
            state[ax.VELOCITY] += gains[1] * innovation
        opposing = load_effort(load, state[ax.POSITION] + 0.5 * period * state[ax.VELOCITY])
        first = effort[k] - opposing
        last = first if lag == 0.0 or k == n - 1 else effort[k + 1] - opposing
        command = first + (last - first) / share
        if not math.isfinite(command):
            return NOT_FINITE
        if not slip_through_period(state, first, last, command, p, coefficients):
            state[ax.DRIVE] = first
            status = advance(state, command, p, period)
            if status != OK:
                return status
    return OK
