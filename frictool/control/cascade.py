"""The controller of one axis at one sample, composed of this room's blocks.

    reference ─▶ prefilter ─▶(-)─ e ─▶ position law, band ─ omega_c ─▶ integral ─▶(-)─ eta ─▶ difference equation ─▶ limit ─▶ drive
                              ▲ y                                                  ▲ y               └────── anti-windup ◀──┘

Parameters and state are flat arrays of float64 in SI, so that the engine keeps one of each per plant. Their places are the
constants below; the parameters end with the difference equation's coefficients, the state with its x and as much scratch.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.control.band import BRAKE, REST, RUN, next_mode
from frictool.control.difference_equation import equation_advance, equation_output
from frictool.control.limiter import limit
from frictool.control.position_law import speed_reference
from frictool.control.prefilter import prefilter_step
from frictool.control.speed_filter import speed_filter_step
from frictool.control.speed_integral import next_eta
from frictool.kernels import kernel

Vector = NDArray[np.float64]

__all__ = ["BRAKE", "REST", "RUN", "control_step", "initial_state"]

# places in the parameters
ORDER, PERIOD, DRIVE_LIMIT, GAIN, SLOPE, BAND, BRAKES, SETTLED_SPEED, REST_SPEED = range(9)
PREFILTERS, PREFILTER = 9, 10  # whether there is one; h, p, q
SPEED_FILTER = 13  # a, b0, b1
RATE = 16  # 1/period
SYSTEM = 17  # a, b, c, d, l
# places in the state
MODE, FILTERED, FILTERED_SPEED, REFERENCE = range(4)
POSITION, DIFFERENCE, SPEED, ETA, LIMITED = range(4, 9)
X = 9


@kernel
def initial_state(parameters: Vector, position: float) -> Vector:
    """The state at rest at `position` [rad | m], with the prefilter settled there."""
    state = np.zeros(X + 2 * int(parameters[ORDER]))
    state[MODE] = REST
    state[FILTERED] = position
    state[REFERENCE] = position
    state[POSITION] = position
    return state


@kernel
def control_step(parameters: Vector, state: Vector, reference: float, position: float) -> float:
    """The drive [A | V] for a reference and a measured position [rad | m], both finite; `state` moves to the next sample in place."""
    p = parameters
    filtered, filtered_speed = reference, 0.0
    if p[PREFILTERS] != 0.0:
        filtered, filtered_speed = prefilter_step(
            p[PREFILTER], p[PREFILTER + 1], p[PREFILTER + 2], state[FILTERED], state[FILTERED_SPEED], state[REFERENCE], reference
        )
    state[FILTERED], state[FILTERED_SPEED], state[REFERENCE] = filtered, filtered_speed, reference
    error = filtered - position
    motion = position - state[POSITION]
    speed = _measured_speed(p, state, motion)
    mode = next_mode(state[MODE], p[BRAKES] != 0.0, p[BAND], p[SETTLED_SPEED], p[REST_SPEED], error, filtered_speed, speed)
    state[POSITION], state[MODE] = position, mode
    if mode == REST:
        return _rest(p, state)
    increment = p[PERIOD] * speed_reference(p[GAIN], p[SLOPE], p[BAND], error) if mode == RUN else 0.0
    return _speed_loop(p, state, increment, motion)


@kernel
def _measured_speed(p: Vector, state: Vector, motion: float) -> float:
    difference = motion * p[RATE]
    a, b0, b1 = p[SPEED_FILTER], p[SPEED_FILTER + 1], p[SPEED_FILTER + 2]
    speed = speed_filter_step(a, b0, b1, state[SPEED], difference, state[DIFFERENCE])
    state[SPEED], state[DIFFERENCE] = speed, difference
    return speed


@kernel
def _rest(p: Vector, state: Vector) -> float:
    """No drive; the loop is left so that it resumes without a jump."""
    state[ETA] = 0.0
    state[LIMITED] = 0.0
    for i in range(X, X + int(p[ORDER])):
        state[i] = 0.0
    return 0.0


@kernel
def _speed_loop(p: Vector, state: Vector, increment: float, motion: float) -> float:
    n = int(p[ORDER])
    eta = next_eta(state[ETA], increment, motion, state[LIMITED])
    drive = equation_output(p, SYSTEM, state, X, n, eta)
    limited, met = limit(drive, p[DRIVE_LIMIT])
    equation_advance(p, SYSTEM, state, X, n, eta, limited - drive)
    state[ETA], state[LIMITED] = eta, met
    return limited
