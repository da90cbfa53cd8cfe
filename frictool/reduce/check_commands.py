"""Test commands of the simulation check, which compares the mechanism before and after a reduction.

A run starts at rest at one of five positions of the travel. Its first move goes forward or
backward. The command of a run consists of:

- a step beyond the breakaway that moves the axis by an eighth of the travel, and a rest,
- a ramp until the axis breaks away and slips, and a rest,
- the same step and ramp in the opposite direction.

These moves open and close the backlash, with friction in both directions. Commands are in the
drive's unit and constant for one sample period. At a position with almost no friction, a small
error of the friction has a large effect on the position at rest. The command therefore ends before
a step that passes such a position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.reduce.one_inertia import OneInertia
from frictool.typing import Vector

START_POSITIONS = (0.15, 0.325, 0.5, 0.675, 0.85)  # relative to the travel
PART = 0.125  # distance of a step relative to the travel
BEYOND = 1.6  # effort of a step relative to the breakaway
RAMP_S, SLIP = 0.3, 1.15  # duration of a ramp [s]; its last effort relative to the breakaway
REST_S = 0.1  # s, rest after a move
LONGEST_S = 4.0  # s, longest push or coasting
LITTLE = 0.02  # smallest friction that stops the axis in time, relative to the push
STEPS = 101  # points along a move
SLOWEST = 1e-12  # speed treated as rest, relative to the largest speed
# distance over which the friction is checked, relative to the distance of the step; friction that
# is treated as vanishing, relative to the mean friction
BEYOND_END, FAINT = 1.25, 0.25
FREE = 0.3  # effort of a push if there is no friction, relative to the drive's limit


@dataclass(frozen=True)
class CheckRun:
    """Test run that begins at rest.

    start: initial position [rad | m].
    command: command (n,) [unit of the drive].
    """

    name: str
    start: float
    command: Vector


def runs(one: OneInertia, constant: float, limit: float, period: float) -> tuple[CheckRun, ...]:
    """Return the test runs of a reduced mechanism.

    constant: effort per unit of the command.
    limit: largest command [unit of the drive].
    period: sample period [s].
    """
    low, high = one.travel if one.travel is not None else one.ends
    checks = []
    for share in START_POSITIONS:
        start = low + share * (high - low)
        for direction, name in ((1.0, "forward"), (-1.0, "backward")):
            command = _command(one, start, direction, constant, limit, period)
            if command.size:
                checks.append(CheckRun(f"{name} from {start:.4g}", start, command))
    return tuple(checks)


def _command(
    one: OneInertia, start: float, direction: float, constant: float, limit: float, period: float
) -> Vector:
    most = limit * constant
    distance = PART * _span(one)
    parts = []
    here = start
    for side in (direction, -direction):
        along = here + side * np.linspace(0.0, distance, STEPS)
        slip, rest = _resisting(one, along, side)
        needed = BEYOND * max(float(np.max(rest)), 0.0)
        push = min(
            max(
                needed,
                min(FREE * most, one.inertia * _fast(one)) if needed <= LITTLE * most else 0.0,
            ),
            most,
        )
        if _fades(one, here, side, distance):
            break
        seconds, brakes = _push_time(one, push, slip, distance)
        moving = _constant(side * push, seconds, period)
        stop = _constant(-side * push, seconds, period) if brakes else np.empty(0)
        coast = _constant(
            0.0,
            min(LONGEST_S, 0.0 if brakes else 2.0 * seconds * push / float(np.mean(slip))) + REST_S,
            period,
        )
        broken = float(_resisting(one, along[-1:], side)[1][0])
        ramp = side * np.linspace(
            0.0, min(SLIP * max(broken, 0.0), most), max(2, round(RAMP_S / period))
        )
        parts += [moving, stop, coast, ramp, _constant(0.0, REST_S, period)]
        here = float(along[-1])
    return np.concatenate(parts) / constant if parts else np.empty(0)


def _fades(one: OneInertia, start: float, direction: float, distance: float) -> bool:
    slip, _ = _resisting(
        one, start + direction * np.linspace(0.0, BEYOND_END * distance, STEPS), direction
    )
    return bool(0.0 <= np.min(slip) < FAINT * np.mean(slip))


def _span(one: OneInertia) -> float:
    low, high = one.travel if one.travel is not None else one.ends
    return high - low


def _fast(one: OneInertia) -> float:
    return 2.0 * PART * _span(one) / 0.2**2


def _resisting(one: OneInertia, positions: Vector, direction: float) -> tuple[Vector, Vector]:
    side = one.forward if direction > 0.0 else one.backward
    load = direction * one.residual.at(positions)
    slip, rest = (
        np.interp(positions, one.positions, curve) for curve in (side.curve, side.breakaway)
    )
    return slip + load, rest + load


def _push_time(one: OneInertia, push: float, slip: Vector, distance: float) -> tuple[float, bool]:
    """Return the duration of a push [s], and True if a braking effort must follow the push.

    After the push the axis coasts or is braked, and comes to rest after `distance` [rad | m]. The
    work of the push, which acts over the first part of the distance, equals the work of the
    friction over the whole distance.

    slip: friction (n,) at equidistant positions of the move.
    """
    taken = float(np.mean(slip)) * distance
    brakes = taken <= LITTLE * push * distance
    part = 0.5 * distance if brakes else min(distance, taken / push)
    x = np.linspace(0.0, part, STEPS) ** 2 / max(part, 1e-300)  # points are dense at low speed
    left = push - np.interp(x, np.linspace(0.0, distance, len(slip)), slip)
    energy = np.concatenate([[0.0], np.cumsum(0.5 * (left[1:] + left[:-1]) * np.diff(x))])
    speed = np.sqrt(2.0 * np.maximum(energy, 0.0) / one.inertia)
    between = 0.5 * (speed[1:] + speed[:-1])
    # the load may exceed the push from some position on
    moving = between > SLOWEST * float(np.max(speed))
    if not np.any(moving):
        return RAMP_S, brakes
    return min(LONGEST_S, float(np.sum(np.diff(x)[moving] / between[moving]))), brakes


def _constant(value: float, seconds: float, period: float) -> Vector:
    return np.full(max(1, round(seconds / period)), value)
