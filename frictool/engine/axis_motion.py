"""Moves one axis through a time in which its command is held: from event to event, in closed form
between them where there is one.

    at rest    until the drive reaches the breakaway                     solved exactly in the
               drive's exponential
    slipping   until the speed falls to zero, or the backlash closes     solved to rounding
               (engine/slip_closed_form.py)

With laws (plant/axis_friction_laws.py) a slip also ends at a knee, at the layer of the Stribeck
curve, at an end of the position's polynomials and at an end stop; a breakaway that grows with the
time at rest is met by the drive's exponential (engine/drive_lag.py). Where friction curves over
speed or position, or a load follows the position (plant/position_load.py), the slip is integrated
in steps (engine/slip_integration.py); everywhere else it stays in closed form.

The sign of the friction belongs to the phase: no integrator ever sees sign(v). After a stop the
axis sticks where the effort is within the breakaway and slips in the effort's direction where it is
not. Parameters and state are those of plant/axis.py.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.axis_friction import (
    MAP_EDGE,
    Laws,
    at_edge,
    is_curved,
    next_place,
    slip_line,
    speed_band,
    strength,
    threshold,
)
from frictool.engine.drive_lag import lagged_drive, outgrowing_time
from frictool.engine.slip_closed_form import (
    NEVER,
    Phase,
    distance,
    fall_time,
    rise_time,
    speed,
    travel_time,
)
from frictool.engine.slip_integration import (
    CONTACT,
    FAILED,
    FASTER,
    HELD,
    PLACE,
    SLOWER,
    curved_slip,
)
from frictool.engine.status import NOT_FINITE, OK, STEP_TOO_SMALL, TOO_MANY_EVENTS
from frictool.friction.coulomb_viscous import breakaway_direction, slip_force
from frictool.plant.axis import (
    BACKLASH,
    CONSTANT,
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
    RESISTANCE,
    RESTED,
    SLIPPING,
    STATE_SIZE,
    STUCK,
    SUPPLY,
    VELOCITY,
)
from frictool.plant.axis_friction_laws import (
    MAP_HIGH,
    MAP_LOW,
    PLAIN_SIZE,
    RESTITUTION,
    RISE_TIME,
    STOP_PAIR,
)
from frictool.plant.position_load import is_loaded, opposing_effort
from frictool.runtime.kernels import inner_kernel, kernel

Vector = NDArray[np.float64]
ROUNDING = 2.0**-50  # efforts smaller than this part of their terms are zero
MAX_EVENTS = 100  # a held command makes a handful: its effort is monotone
MAX_REBOUNDS = 10_000  # and where end stops throw the axis back
SHORTEST_FLIGHT = 1e-6  # s; a rebound that would last less rests at its end stop


@inner_kernel
def _opposing(p: Vector, laws: Laws, x: float) -> float:
    """Offset, with laws also the load, at x [N m | N]."""
    return float(p[OFFSET]) if laws is None else opposing_effort(laws, x)


@inner_kernel
def _rest(
    state: Vector, command: float, p: Vector, laws: Laws, remaining: float, refused: float
) -> tuple[float, float]:
    """At rest for up to `remaining`: moves the drive; returns how long, and the direction in which
    the axis then breaks away or 0.

    `refused`: a direction in which it has just not got going, its effort being on the threshold to
    rounding and no longer rising.
    """
    lag, drive, opposing = p[LAG], state[DRIVE], _opposing(p, laws, state[POSITION])
    forward, backward = threshold(state, p, laws, 1.0), threshold(state, p, laws, -1.0)
    direction = breakaway_direction(p[CONSTANT] * drive - opposing, forward, backward)
    if direction not in (0.0, refused):
        return 0.0, direction
    direction = breakaway_direction(p[CONSTANT] * command - opposing, forward, backward)
    if direction not in (0.0, refused) and lag > 0.0:
        if laws is not None and p[RISE_TIME] > 0.0 and at_edge(state, p, direction):
            wait = _wait(state, command, p, direction, remaining)
            loosening = lagged_drive(drive, command, lag, max(wait, 0.0))
        else:
            loosening = ((forward if direction > 0.0 else -backward) + opposing) / p[CONSTANT]
            wait = max(0.0, -lag * math.log1p((loosening - drive) / (drive - command)))
        if wait != NEVER and wait < remaining:
            state[DRIVE] = loosening
            return wait, direction
    state[DRIVE] = lagged_drive(drive, command, lag, remaining)
    return remaining, 0.0


@kernel
def _wait(state: Vector, command: float, p: Vector, direction: float, remaining: float) -> float:
    """Until the drive outgrows a breakaway that grows with the time at rest, or NEVER."""
    full, fresh = strength(p, direction, state[POSITION])
    settled = direction * (p[CONSTANT] * command - opposing_effort(p, state[POSITION]))
    losing = direction * p[CONSTANT] * (command - state[DRIVE])
    return outgrowing_time(
        full, fresh, p[RISE_TIME], state[RESTED], settled, losing, p[LAG], remaining
    )


@inner_kernel
def _phase(
    state: Vector, command: float, p: Vector, direction: float, coulomb: float, viscous: float
) -> Phase:
    """The coming phase of slip.

    Where the breakaway is the Coulomb friction, slip begins with no acceleration at all: what
    rounding leaves of it is taken out, or the axis would stop and break away again at the same
    instant.
    """
    settled = direction * (p[CONSTANT] * command - p[OFFSET]) - slip_force(
        0.0, 1.0, coulomb, viscous
    )
    transient = direction * p[CONSTANT] * (state[DRIVE] - command)
    if state[VELOCITY] == 0.0:
        gross = (
            abs(p[CONSTANT] * state[DRIVE]) + abs(p[CONSTANT] * command) + abs(p[OFFSET]) + coulomb
        )
        if abs(settled + transient) <= ROUNDING * gross:
            settled = settled if p[LAG] > 0.0 else 0.0  # without a lag nothing is on its way either
            transient = -settled
    rate = 1.0 / p[LAG] if p[LAG] > 0.0 else 0.0
    return (
        direction * state[VELOCITY],
        settled / p[INERTIA],
        transient / p[INERTIA],
        viscous / p[INERTIA],
        rate,
    )


@inner_kernel
def _straight_slip(
    state: Vector,
    command: float,
    p: Vector,
    laws: Laws,
    direction: float,
    remaining: float,
    driving: bool,
    to_edge: float,
) -> tuple[float, float, float, int]:
    """Slips for up to `remaining` in closed form; returns how long, how far, the speed then, how it
    ended. The state stays as it is."""
    coulomb, viscous = slip_line(state, p, laws, direction, driving)
    phase = _phase(state, command, p, direction, coulomb, viscous)
    lower, upper, length, place = 0.0, math.inf, math.inf, CONTACT
    if not driving:
        length = to_edge
    if laws is not None:
        if driving:
            lower, upper = speed_band(p, abs(state[VELOCITY]))
        ahead, _ = next_place(p, state[POSITION], direction)
        if ahead < length:
            length, place = ahead, PLACE
        if length <= 0.0:
            return 0.0, 0.0, phase[0], place
    end, kind = fall_time(phase, lower, remaining), SLOWER
    if end == NEVER:
        end, kind = remaining, HELD
    if upper < math.inf:
        crossing = rise_time(phase, upper, end)
        if crossing != NEVER:
            end, kind = crossing, FASTER
    if length < math.inf:
        crossing = travel_time(phase, length, end)
        if crossing != NEVER:
            return crossing, length, max(0.0, speed(phase, crossing)), place
    return (
        end,
        max(0.0, distance(phase, end)),
        0.0 if kind == SLOWER else max(0.0, speed(phase, end)),
        kind,
    )


@kernel
def _arrive(state: Vector, p: Vector, direction: float, start: float) -> float:
    """At the place that came next from `start`: an end of the position's polynomials, passed, or an
    end stop. Returns the direction.

    A motor that its effort pushes against the stop rebounds without end in finite time: the last
    rebounds are left out.
    """
    _, place = next_place(p, start, direction)
    if place == MAP_EDGE:
        low, high = p[MAP_LOW], p[MAP_HIGH]
        state[POSITION] = low if abs(state[POSITION] - low) < abs(state[POSITION] - high) else high
        return direction
    wall = p[STOP_PAIR + (1 if direction > 0.0 else 0)]
    if direction * (wall - start) > 0.0:  # an axis that was put beyond its stop stays there
        state[POSITION] = wall
    state[VELOCITY] *= -p[RESTITUTION]
    outwards = (
        direction * (p[CONSTANT] * state[DRIVE] - opposing_effort(p, state[POSITION])) / p[INERTIA]
    )
    if 2.0 * abs(state[VELOCITY]) <= outwards * SHORTEST_FLIGHT:
        state[VELOCITY] = 0.0
    return -direction


@inner_kernel
def _slip(
    state: Vector, command: float, p: Vector, laws: Laws, direction: float, remaining: float
) -> tuple[float, float, int]:
    """Slips for up to `remaining`; returns how long, the direction that goes on, 0 after a stop,
    and how the slip ended."""
    to_edge = 0.5 * p[BACKLASH] - direction * state[GAP]
    driving = to_edge <= 0.0
    w, x = direction * state[VELOCITY], state[POSITION]
    if laws is not None and (is_loaded(laws) or (driving and is_curved(state, laws, direction))):
        spent, moved, after, kind = curved_slip(state, command, laws, direction, remaining, to_edge)
    else:
        spent, moved, after, kind = _straight_slip(
            state, command, p, laws, direction, remaining, driving, to_edge
        )
    state[POSITION] += direction * moved
    if driving:
        state[LOAD_POSITION] += direction * moved
    else:
        state[GAP] = (
            direction * 0.5 * p[BACKLASH] if kind == CONTACT else state[GAP] + direction * moved
        )
    state[DRIVE] = lagged_drive(state[DRIVE], command, p[LAG], spent)
    if laws is not None and kind in (SLOWER, FASTER):
        lower, upper = speed_band(p, w)
        after = upper if kind == FASTER else lower if driving else 0.0
    state[VELOCITY] = direction * after if after > 0.0 else 0.0
    if laws is not None and kind == PLACE:
        direction = _arrive(state, laws, direction, x)
    return spent, 0.0 if state[VELOCITY] == 0.0 and kind in (SLOWER, PLACE) else direction, kind


@inner_kernel
def _advance(state: Vector, command: float, p: Vector, laws: Laws, duration: float) -> int:
    direction = math.copysign(1.0, state[VELOCITY]) if state[VELOCITY] != 0.0 else 0.0
    remaining, refused = duration, 0.0
    for _ in range(MAX_EVENTS if laws is None else MAX_REBOUNDS):
        if direction == 0.0:
            spent, direction = _rest(state, command, p, laws, remaining, refused)
            if laws is not None:
                state[RESTED] += spent
        else:
            attempted = direction if state[VELOCITY] == 0.0 else 0.0
            spent, direction, kind = _slip(state, command, p, laws, direction, remaining)
            refused = attempted if spent == 0.0 else 0.0
            if laws is not None:
                if kind == FAILED:
                    return STEP_TOO_SMALL
                if direction == 0.0 and spent > 0.0:
                    state[RESTED] = 0.0
        remaining -= spent
        if remaining <= 0.0:
            driving = direction * state[GAP] >= 0.5 * p[BACKLASH]
            state[MODE] = (
                STUCK if direction == 0.0 else direction * (SLIPPING if driving else LOOSE)
            )
            return OK
    return TOO_MANY_EVENTS


@kernel
def drive_range(p: Vector, velocity: float) -> tuple[float, float]:
    """The lowest and the highest drive [A | V] that can flow at this speed: the drive's limit, and
    what the winding leaves."""
    low, high = -p[DRIVE_LIMIT], p[DRIVE_LIMIT]
    if p[RESISTANCE] > 0.0:
        back = p[CONSTANT] * velocity
        low, high = (
            max(low, (-p[SUPPLY] - back) / p[RESISTANCE]),
            min(high, (p[SUPPLY] - back) / p[RESISTANCE]),
        )
    return low, high


@kernel
def drive_from_now(state: Vector, command: float, p: Vector) -> float:
    """The drive [A | V] that acts from this instant on: what flows, or without a lag the command,
    within its range."""
    low, high = drive_range(p, state[VELOCITY])
    return float(min(max(state[DRIVE] if p[LAG] > 0.0 else command, low), high))


@kernel
def advance(state: Vector, command: float, parameters: Vector, duration: float) -> int:
    """Advances `state` (7,), in place, by `duration` [s] under a held `command` [A or V]. Returns
    engine/status.py.

    `parameters`: (14,), or (EXTENDED_SIZE,) with laws, or more with a load (plant/position_load.py
    `under_load`). The winding's bound is that of the speed at the beginning.
    """
    total = command * 0.0 + duration
    for index in range(STATE_SIZE):
        total += state[index]
    if not math.isfinite(total) or duration < 0.0:
        return NOT_FINITE
    limit = parameters[DRIVE_LIMIT]
    command = min(max(command, -limit), limit)
    if parameters[RESISTANCE] > 0.0:
        low, high = drive_range(parameters, state[VELOCITY])
        command, state[DRIVE] = min(max(command, low), high), min(max(state[DRIVE], low), high)
    if parameters[LAG] == 0.0:
        state[DRIVE] = command
    if parameters.shape[0] > PLAIN_SIZE:
        return _advance(state, command, parameters, parameters, duration)
    return _advance(state, command, parameters, None, duration)
