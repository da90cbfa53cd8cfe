"""Moves one axis through a time in which its command is held: from event to event, in closed form between them.

    at rest    until the drive reaches the breakaway                     solved exactly in the drive's exponential
    slipping   until the speed falls to zero, or the backlash closes     solved to rounding (engine/slip.py)

The sign of the friction belongs to the phase: no integrator ever sees sign(v). After a stop the axis sticks where the effort is
within the breakaway and slips in the effort's direction where it is not. Parameters and state are those of plant/axis.py.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.slip import NEVER, Phase, distance, speed, stop_time, travel_time
from frictool.engine.status import NOT_FINITE, OK, TOO_MANY_EVENTS
from frictool.friction.coulomb import breakaway_direction, slip_force
from frictool.kernels import kernel
from frictool.plant.axis import (
    BACKLASH,
    BACKLASH_BREAKAWAY,
    BACKLASH_COULOMB,
    BREAKAWAY,
    CONSTANT,
    COULOMB,
    DRIVE,
    DRIVE_LIMIT,
    GAP,
    INERTIA,
    LAG,
    LOAD_POSITION,
    LOOSE,
    MODE,
    OFFSET,
    POSITION,
    SLIPPING,
    STATE_SIZE,
    STUCK,
    VELOCITY,
    VISCOUS,
)

Vector = NDArray[np.float64]
ROUNDING = 2.0**-50  # efforts smaller than this part of their terms are zero
MAX_EVENTS = 100  # a held command makes a handful: its effort is monotone


@kernel
def _relax(drive: float, command: float, lag: float, t: float) -> float:
    """The drive after t under a held command."""
    return command if drive == command or lag == 0.0 else command + (drive - command) * math.exp(-t / lag)


@kernel
def _rest(state: Vector, command: float, p: Vector, remaining: float, refused: float) -> tuple[float, float]:
    """At rest for up to `remaining`: moves the drive; returns how long, and the direction in which the axis then breaks away or 0.

    `refused`: a direction in which it has just not got going, its effort being on the threshold to rounding and no longer rising.
    """
    edge, lag, drive = 0.5 * p[BACKLASH], p[LAG], state[DRIVE]
    forward = p[BREAKAWAY] if state[GAP] >= edge else p[BACKLASH_BREAKAWAY]
    backward = p[BREAKAWAY] if state[GAP] <= -edge else p[BACKLASH_BREAKAWAY]
    direction = breakaway_direction(p[CONSTANT] * drive - p[OFFSET], forward, backward)
    if direction not in (0.0, refused):
        return 0.0, direction
    direction = breakaway_direction(p[CONSTANT] * command - p[OFFSET], forward, backward)
    if direction not in (0.0, refused) and lag > 0.0:
        threshold = forward if direction > 0.0 else -backward
        loosening = (threshold + p[OFFSET]) / p[CONSTANT]
        wait = max(0.0, -lag * math.log1p((loosening - drive) / (drive - command)))
        if wait < remaining:
            state[DRIVE] = loosening
            return wait, direction
    state[DRIVE] = _relax(drive, command, lag, remaining)
    return remaining, 0.0


@kernel
def _phase(state: Vector, command: float, p: Vector, direction: float, driving: bool) -> Phase:
    """The coming phase of slip; `driving`: the motor carries the load.

    Where the breakaway is the Coulomb friction, slip begins with no acceleration at all: what rounding leaves of it is taken out,
    or the axis would stop and break away again at the same instant.
    """
    coulomb = p[COULOMB] if driving else p[BACKLASH_COULOMB]
    viscous = p[VISCOUS] if driving else 0.0
    settled = direction * (p[CONSTANT] * command - p[OFFSET]) - slip_force(0.0, 1.0, coulomb, viscous)
    transient = direction * p[CONSTANT] * (state[DRIVE] - command)
    if state[VELOCITY] == 0.0:
        gross = abs(p[CONSTANT] * state[DRIVE]) + abs(p[CONSTANT] * command) + abs(p[OFFSET]) + coulomb
        if abs(settled + transient) <= ROUNDING * gross:
            transient = -settled
    rate = 1.0 / p[LAG] if p[LAG] > 0.0 else 0.0
    return (direction * state[VELOCITY], settled / p[INERTIA], transient / p[INERTIA], viscous / p[INERTIA], rate)


@kernel
def _slip(state: Vector, command: float, p: Vector, direction: float, remaining: float) -> tuple[float, float]:
    """Slips for up to `remaining`; returns how long, and the direction that goes on, 0 after a stop."""
    to_edge = 0.5 * p[BACKLASH] - direction * state[GAP]
    driving = to_edge <= 0.0
    phase = _phase(state, command, p, direction, driving)
    end = stop_time(phase, remaining)
    stopped = end != NEVER
    if not stopped:
        end = remaining
    moved = -1.0
    if not driving:
        contact = travel_time(phase, to_edge, end)
        if contact != NEVER:
            stopped, end, moved = False, contact, to_edge
    touched = moved >= 0.0
    if not touched:
        moved = max(0.0, distance(phase, end))
    state[POSITION] += direction * moved
    if driving:
        state[LOAD_POSITION] += direction * moved
    else:
        state[GAP] = direction * 0.5 * p[BACKLASH] if touched else state[GAP] + direction * moved
    state[VELOCITY] = 0.0 if stopped else direction * max(0.0, speed(phase, end))
    state[DRIVE] = _relax(state[DRIVE], command, p[LAG], end)
    return end, 0.0 if stopped else direction


@kernel
def advance(state: Vector, command: float, parameters: Vector, duration: float) -> int:
    """Advances `state` (6,), in place, by `duration` [s] under a held `command` [A or V]; `parameters` (12,). Returns engine/status.py."""
    total = command * 0.0 + duration
    for index in range(STATE_SIZE):
        total += state[index]
    if not math.isfinite(total) or duration < 0.0:
        return NOT_FINITE
    limit = parameters[DRIVE_LIMIT]
    command = min(max(command, -limit), limit)
    if parameters[LAG] == 0.0:
        state[DRIVE] = command
    direction = math.copysign(1.0, state[VELOCITY]) if state[VELOCITY] != 0.0 else 0.0
    remaining, refused = duration, 0.0
    for _ in range(MAX_EVENTS):
        if direction == 0.0:
            spent, direction = _rest(state, command, parameters, remaining, refused)
        else:
            attempted = direction if state[VELOCITY] == 0.0 else 0.0
            spent, direction = _slip(state, command, parameters, direction, remaining)
            refused = attempted if spent == 0.0 else 0.0
        remaining -= spent
        if remaining <= 0.0:
            driving = direction * state[GAP] >= 0.5 * parameters[BACKLASH]
            state[MODE] = STUCK if direction == 0.0 else direction * (SLIPPING if driving else LOOSE)
            return OK
    return TOO_MANY_EVENTS
