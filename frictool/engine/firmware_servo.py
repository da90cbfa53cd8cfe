"""Axis under the firmware of a smart servo, which follows a logged goal.

plant/servo_firmware.py defines the parameters of the firmware. The firmware has the position loop
of engine/bench_position_loop.py, with a higher sample rate than the log. The effort is the drive
constant times the voltage; the back-EMF is part of the axis's viscous friction. While the torque is
disabled, the motor is an open circuit: the effort is 0, and the viscous friction is purely
mechanical.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from frictool.engine.bench_position_loop import PositionServo, follow_reference
from frictool.engine.status_codes import OK
from frictool.plant.axis import VISCOUS
from frictool.plant.servo_firmware import FirmwareLaw, ServoDrive
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def limited_profile(goal: Vector, start: float, largest: float) -> Vector:
    """Return a profile (n,) that follows `goal` (n,) with a limited rate.

    The profile changes by at most `largest` per element; its value before the first element is
    `start`.
    """
    out = np.empty(goal.shape[0])
    at = start
    for k in range(goal.shape[0]):
        at += min(max(goal[k] - at, -largest), largest)
        out[k] = at
    return out


def profile_of(goal: Vector, law: FirmwareLaw, period: float) -> Vector:
    """Return the profile (n s,) [rad] of a goal (n,), with s firmware periods per sample."""
    steps = law.steps(period)
    times = np.arange(goal.size * steps) / steps
    goals = np.interp(times, np.arange(goal.size), goal)
    profile = limited_profile(goals, float(goal[0]), law.goal_speed * period / steps)
    return np.asarray(np.interp(times - law.delay / period, times, profile))


def follow_goal(
    p: Vector,
    load: Vector,
    state: Vector,
    law: FirmwareLaw,
    drive: ServoDrive,
    goal: Vector,
    period: float,
) -> tuple[int, Vector, Vector]:
    """Simulate an axis whose firmware follows a logged goal (n,).

    Parameters
    ----------
    p, load
        Axis (engine/effort_replay.py `replay_parameters`) and load (plant/position_load.py).
    state
        State (7,) of the axis, changed in place.
    law
        Parameters of the firmware.
    drive
        Logged gain, logged supply voltage and logged torque switch.
    goal
        Goal (n,), rad.
    period
        Sample period of the log, s.

    Returns
    -------
    tuple
        Status of engine/status_codes.py; position (n,), rad; applied effort (n,), N m.
    """
    steps = law.steps(period)
    profile = profile_of(goal, law, period)
    late = np.arange(profile.size) / steps - law.delay / period
    row = np.clip(np.floor(late), 0, goal.size - 1).astype(np.int64)
    gain, supply = drive.gain[row], drive.supply
    on = _mean_over_step(drive.enabled > 0.5, late, 1.0 / steps)
    switches = np.flatnonzero((np.diff(gain) != 0.0) | (np.diff(on) != 0.0)) + 1
    edges = np.concatenate(([0], switches, [profile.size]))
    position = np.empty(profile.size)
    velocity = np.empty(profile.size)
    effort = np.empty(profile.size)
    electrical = min(law.constant * law.back_emf, p[VISCOUS])
    axis = p.copy()
    for first, last in itertools.pairwise(edges.tolist()):
        part = slice(first, last)
        scale = law.constant * on[first] * float(np.median(supply[row[first] : row[last - 1] + 1]))
        servo = PositionServo(
            proportional=scale * law.duty_per_error * float(gain[first]),
            limit=scale * law.duty_limit,
        )
        axis[VISCOUS] = p[VISCOUS] - (1.0 - on[first]) * electrical
        status = follow_reference(
            axis,
            load,
            state,
            np.array(servo),
            profile[part],
            0.0,
            period / steps,
            position[part],
            velocity[part],
            effort[part],
        )
        if status != OK:
            return status, position[::steps], effort[::steps]
    return OK, position[::steps], effort[::steps]


def _mean_over_step(switch: NDArray[np.bool_], late: Vector, step: float) -> Vector:
    """Return the mean (m,) of an on-off signal `switch` (n,) over each of m intervals of its index.

    Interval k begins at the index `late`[k], which may be fractional, and has the length `step`.
    """
    held = np.concatenate(([0.0], np.cumsum(switch)))
    at = np.arange(held.size)
    before = np.minimum(late, 0.0) * float(switch[0])
    after = np.minimum(late + step, 0.0) * float(switch[0])
    rise = np.interp(late + step, at, held) + after - np.interp(late, at, held) - before
    return np.asarray(np.round(rise / step, 12))
