"""Time-optimal motion of an axis with friction, from rest to rest with one switch of the drive.

The unit of time is the duration of the motion. The unit of acceleration is that of the full drive
without friction. The drive follows its command with a lag:

    v' = u - friction - damping v,    u' = (command - u)/lag,    command = 1, then -1

The axis starts to move when u exceeds the breakaway. The motion ends when the speed is zero again.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from frictool.typing import Matrix, Vector

STEPS = 1000  # time steps of the motion


def bang_bang_distance(
    friction: float, breakaway: float, lag: float, damping: float, delay: float
) -> float:
    """Return the distance covered in the duration 1, which includes the `delay` of the drive.

    friction, breakaway: divided by the effort of the full drive. lag, delay: divided by the
    duration. damping: multiplied by the duration.
    """
    forward, backward = (_transition(friction, lag, damping, sign) for sign in (1.0, -1.0))
    moving = -lag * np.log(1.0 - breakaway) if lag > 0.0 else 0.0
    left = 1.0 - delay - moving
    if left <= 0.0:
        return 0.0
    first = max(1, round(left * STEPS))
    state = np.array([0.0, 0.0, breakaway if lag > 0.0 else 1.0, 1.0])
    accelerated = [state]
    for _ in range(first):
        accelerated.append(forward @ accelerated[-1])
    low, high = 0, first  # the switch is at the last step from which the axis still stops in time
    reached = 0.0
    while high - low > 1:
        switch = (low + high) // 2
        distance = _braked(accelerated[switch], backward, first - switch, lag)
        if distance is None:
            high = switch
        else:
            low, reached = switch, distance
    return reached


def _transition(friction: float, lag: float, damping: float, command: float) -> Matrix:
    """Return the transition matrix of (distance, speed, drive, 1) over one step."""
    rates = np.zeros((4, 4))
    rates[0, 1] = 1.0
    rates[1] = 0.0, -damping, 1.0, -friction
    if lag > 0.0:
        rates[2, 2:] = -1.0 / lag, command / lag
    return np.asarray(expm(rates / STEPS))


def _braked(state: Vector, backward: Matrix, steps: int, lag: float) -> float | None:
    """Return the distance at which the axis stops under full braking.

    Return None if the axis still moves after `steps` steps.
    """
    state = state.copy()
    if lag == 0.0:
        state[2] = -1.0
    for _ in range(steps):
        before, state = state, backward @ state
        if state[1] <= 0.0:
            part = before[1] / (before[1] - state[1]) if before[1] > state[1] else 0.0
            return float(before[0] + part * (state[0] - before[0]))
    return None
