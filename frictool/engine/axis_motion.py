"""Motion of one axis under a constant command, from event to event, in closed form if possible.

    at rest    until the effort of the drive (an exponential of time) reaches the breakaway
    slipping   until the speed falls to zero or the backlash closes; both times are exact to
               rounding (engine/slip_closed_form.py)

With `AxisLaws` (plant/axis_friction_laws.py), more events end a slip: an end stop, a speed at which
the viscous coefficient changes (knee), the limit of the Stribeck layer, and an end of the range in
which polynomials describe the friction over position. If the breakaway grows with the time at rest,
engine/drive_lag.py computes the time of the breakaway.

A slip has a closed form if the friction is linear in speed, and neither friction nor load
(plant/position_load.py) depends on the position. Without a closed form, a slip is integrated in
steps (engine/slip_integration.py). A dynamic law such as LuGre has neither stick nor slip and is
integrated by engine/dynamic_law_axis.py.

The sign of the friction is fixed within a slip: no integrator ever evaluates sign(v). After a stop
the axis sticks if the effort is within the breakaway; otherwise it slips in the direction of the
effort. plant/axis.py defines the parameters and the state.
"""

from __future__ import annotations

import math

from frictool.engine.axis_friction import (
    MAP_EDGE,
    Laws,
    at_edge,
    is_curved,
    next_boundary,
    slip_line,
    speed_band,
    strength,
    threshold,
)
from frictool.engine.drive_lag import lagged_drive, outgrowing_time
from frictool.engine.dynamic_law_axis import has_dynamic_law, move_under_law
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
from frictool.engine.status_codes import NOT_FINITE, OK, STEP_TOO_SMALL, TOO_MANY_EVENTS
from frictool.friction.coulomb_viscous import breakaway_direction, slip_force
from frictool.plant import axis as ax
from frictool.plant import axis_friction_laws as al
from frictool.plant.position_load import is_loaded, opposing_effort
from frictool.runtime.kernels import inner_kernel, kernel
from frictool.typing import Vector

ROUNDING = 2.0**-50  # largest effort that is treated as zero, relative to the sum of its terms
MAX_EVENTS = 100  # largest number of events in a call; the effort is monotone in a call
MAX_REBOUNDS = 10_000  # largest number of events in a call if the axis can rebound from stops
SHORTEST_FLIGHT = 1e-6  # s; a rebound with a shorter flight ends at rest at the stop


@inner_kernel
def _opposing(p: Vector, laws: Laws, x: float) -> float:
    return float(p[ax.OFFSET]) if laws is None else opposing_effort(laws, x)


@inner_kernel
def _rest(
    state: Vector, command: float, p: Vector, laws: Laws, remaining: float, refused: float
) -> tuple[float, float]:
    """Keep the axis at rest for up to `remaining` [s]; return duration and breakaway direction.

    The direction is 0 if the axis does not break away.

    refused: direction in which the axis cannot break away, because a slip in this direction has
    just ended at the instant at which it began; 0 if there is none.
    """
    lag = p[ax.LAG]
    drive = state[ax.DRIVE]
    opposing = _opposing(p, laws, state[ax.POSITION])
    forward, backward = threshold(state, p, laws, 1.0), threshold(state, p, laws, -1.0)
    direction = breakaway_direction(p[ax.CONSTANT] * drive - opposing, forward, backward)
    if direction not in (0.0, refused):
        return 0.0, direction
    direction = breakaway_direction(p[ax.CONSTANT] * command - opposing, forward, backward)
    if direction not in (0.0, refused) and lag > 0.0:
        if laws is not None and p[al.RISE_TIME] > 0.0 and at_edge(state, p, direction):
            wait = _wait(state, command, p, direction, remaining)
            loosening = lagged_drive(drive, command, lag, max(wait, 0.0))
        else:
            loosening = ((forward if direction > 0.0 else -backward) + opposing) / p[ax.CONSTANT]
            wait = max(0.0, -lag * math.log1p((loosening - drive) / (drive - command)))
        if wait != NEVER and wait < remaining:
            state[ax.DRIVE] = loosening
            return wait, direction
    state[ax.DRIVE] = lagged_drive(drive, command, lag, remaining)
    return remaining, 0.0


@kernel
def _wait(state: Vector, command: float, p: Vector, direction: float, remaining: float) -> float:
    full, fresh = strength(p, direction, state[ax.POSITION])
    settled = direction * (p[ax.CONSTANT] * command - opposing_effort(p, state[ax.POSITION]))
    losing = direction * p[ax.CONSTANT] * (command - state[ax.DRIVE])
    return outgrowing_time(
        full, fresh, p[al.RISE_TIME], state[ax.RESTED], settled, losing, p[ax.LAG], remaining
    )


@inner_kernel
def _phase(
    state: Vector, command: float, p: Vector, direction: float, coulomb: float, viscous: float
) -> Phase:
    """Return the tuple `phase` (slip_closed_form.py) of a slip that begins at the present state.

    If the breakaway equals the Coulomb friction, the initial acceleration is zero up to a rounding
    error. The error is removed, because the axis could otherwise stop and break away again.
    """
    settled = direction * (p[ax.CONSTANT] * command - p[ax.OFFSET]) - slip_force(
        0.0, 1.0, coulomb, viscous
    )
    transient = direction * p[ax.CONSTANT] * (state[ax.DRIVE] - command)
    if state[ax.VELOCITY] == 0.0:
        gross = (
            abs(p[ax.CONSTANT] * state[ax.DRIVE])
            + abs(p[ax.CONSTANT] * command)
            + abs(p[ax.OFFSET])
            + coulomb
        )
        if abs(settled + transient) <= ROUNDING * gross:
            # without a lag the effort is constant
            settled = settled if p[ax.LAG] > 0.0 else 0.0
            transient = -settled
    rate = 1.0 / p[ax.LAG] if p[ax.LAG] > 0.0 else 0.0
    return (
        direction * state[ax.VELOCITY],
        settled / p[ax.INERTIA],
        transient / p[ax.INERTIA],
        viscous / p[ax.INERTIA],
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
    coulomb, viscous = slip_line(state, p, laws, direction, driving)
    phase = _phase(state, command, p, direction, coulomb, viscous)
    lower = 0.0
    upper = math.inf
    length = math.inf
    kind_of_end = CONTACT
    if not driving:
        length = to_edge
    if laws is not None:
        if driving:
            lower, upper = speed_band(p, abs(state[ax.VELOCITY]))
        ahead, _ = next_boundary(p, state[ax.POSITION], direction)
        if ahead < length:
            length, kind_of_end = ahead, PLACE
        if length <= 0.0:
            return 0.0, 0.0, phase[0], kind_of_end
    end = fall_time(phase, lower, remaining)
    kind = SLOWER
    if end == NEVER:
        end, kind = remaining, HELD
    if upper < math.inf:
        crossing = rise_time(phase, upper, end)
        if crossing != NEVER:
            end, kind = crossing, FASTER
    if length < math.inf:
        crossing = travel_time(phase, length, end)
        if crossing != NEVER:
            return crossing, length, max(0.0, speed(phase, crossing)), kind_of_end
    return (
        end,
        max(0.0, distance(phase, end)),
        0.0 if kind == SLOWER else max(0.0, speed(phase, end)),
        kind,
    )


@kernel
def _arrive(state: Vector, p: Vector, direction: float, start: float) -> float:
    """Update the state at a boundary (`next_boundary`); return the direction of motion afterwards.

    An axis that is pressed against the stop would rebound infinitely often in a finite time.
    Rebounds with a flight shorter than SHORTEST_FLIGHT are therefore left out.
    """
    _, kind_of_end = next_boundary(p, start, direction)
    if kind_of_end == MAP_EDGE:
        low, high = p[al.MAP_LOW], p[al.MAP_HIGH]
        state[ax.POSITION] = (
            low if abs(state[ax.POSITION] - low) < abs(state[ax.POSITION] - high) else high
        )
        return direction
    wall = p[al.STOP_PAIR + (1 if direction > 0.0 else 0)]
    if direction * (wall - start) > 0.0:  # an axis that starts beyond its stop stays there
        state[ax.POSITION] = wall
    state[ax.VELOCITY] *= -p[al.RESTITUTION]
    outwards = (
        direction
        * (p[ax.CONSTANT] * state[ax.DRIVE] - opposing_effort(p, state[ax.POSITION]))
        / p[ax.INERTIA]
    )
    if 2.0 * abs(state[ax.VELOCITY]) <= outwards * SHORTEST_FLIGHT:
        state[ax.VELOCITY] = 0.0
    return -direction


@inner_kernel
def _slip(
    state: Vector,
    command: float,
    p: Vector,
    laws: Laws,
    curved: Laws,
    direction: float,
    remaining: float,
) -> tuple[float, float, int]:
    to_edge = 0.5 * p[ax.BACKLASH] - direction * state[ax.GAP]
    driving = to_edge <= 0.0
    w = direction * state[ax.VELOCITY]
    x = state[ax.POSITION]
    if curved is not None and (
        is_loaded(curved) or (driving and is_curved(state, curved, direction))
    ):
        spent, moved, after, kind = curved_slip(
            state, command, curved, direction, remaining, to_edge
        )
    else:
        spent, moved, after, kind = _straight_slip(
            state, command, p, laws, direction, remaining, driving, to_edge
        )
    state[ax.POSITION] += direction * moved
    if driving:
        state[ax.LOAD_POSITION] += direction * moved
    else:
        state[ax.GAP] = (
            direction * 0.5 * p[ax.BACKLASH]
            if kind == CONTACT
            else state[ax.GAP] + direction * moved
        )
    state[ax.DRIVE] = lagged_drive(state[ax.DRIVE], command, p[ax.LAG], spent)
    if laws is not None and kind in (SLOWER, FASTER):
        lower, upper = speed_band(p, w)
        after = upper if kind == FASTER else lower if driving else 0.0
    state[ax.VELOCITY] = direction * after if after > 0.0 else 0.0
    if laws is not None and kind == PLACE:
        direction = _arrive(state, laws, direction, x)
    return spent, 0.0 if state[ax.VELOCITY] == 0.0 and kind in (SLOWER, PLACE) else direction, kind


@inner_kernel
def _advance(
    state: Vector, command: float, p: Vector, laws: Laws, curved: Laws, duration: float
) -> int:
    direction = math.copysign(1.0, state[ax.VELOCITY]) if state[ax.VELOCITY] != 0.0 else 0.0
    remaining = duration
    refused = 0.0
    for _ in range(MAX_EVENTS if laws is None else MAX_REBOUNDS):
        if direction == 0.0:
            spent, direction = _rest(state, command, p, laws, remaining, refused)
            if laws is not None:
                state[ax.RESTED] += spent
        else:
            attempted = direction if state[ax.VELOCITY] == 0.0 else 0.0
            spent, direction, kind = _slip(state, command, p, laws, curved, direction, remaining)
            refused = attempted if spent == 0.0 else 0.0
            if laws is not None:
                if kind == FAILED:
                    return STEP_TOO_SMALL
                if direction == 0.0 and spent > 0.0:
                    state[ax.RESTED] = 0.0
        remaining -= spent
        if remaining <= 0.0:
            driving = direction * state[ax.GAP] >= 0.5 * p[ax.BACKLASH]
            state[ax.MODE] = (
                ax.STUCK if direction == 0.0 else direction * (ax.SLIPPING if driving else ax.LOOSE)
            )
            return OK
    return TOO_MANY_EVENTS


@inner_kernel
def _is_held(state: Vector, command: float, p: Vector, laws: Laws) -> bool:
    opposing = _opposing(p, laws, state[ax.POSITION])
    forward, backward = threshold(state, p, laws, 1.0), threshold(state, p, laws, -1.0)
    now = breakaway_direction(p[ax.CONSTANT] * state[ax.DRIVE] - opposing, forward, backward)
    later = breakaway_direction(p[ax.CONSTANT] * command - opposing, forward, backward)
    return now == 0.0 and later == 0.0


@kernel
def is_held(state: Vector, command: float, p: Vector) -> bool:
    """Return True if the axis rests and stays at rest as long as `command` [A | V] acts.

    The test is exact, because the drive tends monotonically to the command and the breakaway does
    not fall during a rest. The result is always False for two kinds of axes: with a winding, the
    drive limit changes within a period; with a dynamic law, the axis deflects under any effort.
    """
    if state[ax.VELOCITY] != 0.0 or p[ax.RESISTANCE] > 0.0:
        return False
    command = min(max(command, -p[ax.DRIVE_LIMIT]), p[ax.DRIVE_LIMIT])
    if p.shape[0] > al.PLAIN_SIZE:
        return bool(not has_dynamic_law(p) and _is_held(state, command, p, p))
    return bool(_is_held(state, command, p, None))


@kernel
def rest_on(state: Vector, command: float, p: Vector, duration: float, decay: float) -> None:
    """Advance the state of an axis that stays at rest (`is_held`); faster than `advance`.

    decay: factor e^(-duration/lag), where lag is the time constant of the drive; 0 without a lag.
    """
    command = min(max(command, -p[ax.DRIVE_LIMIT]), p[ax.DRIVE_LIMIT])
    if decay == 0.0:
        state[ax.DRIVE] = command
    elif state[ax.DRIVE] != command:
        state[ax.DRIVE] = command + (state[ax.DRIVE] - command) * decay
    if p.shape[0] > al.PLAIN_SIZE:
        state[ax.RESTED] += duration


@kernel
def drive_range(p: Vector, velocity: float) -> tuple[float, float]:
    """Return the lowest and highest drive [A | V] that the drive limit and the winding allow."""
    low = -p[ax.DRIVE_LIMIT]
    high = p[ax.DRIVE_LIMIT]
    if p[ax.RESISTANCE] > 0.0:
        back = p[ax.CONSTANT] * velocity
        low = max(low, (-p[ax.SUPPLY] - back) / p[ax.RESISTANCE])
        high = min(high, (p[ax.SUPPLY] - back) / p[ax.RESISTANCE])
    return low, high


@kernel
def drive_from_now(state: Vector, command: float, p: Vector) -> float:
    """Return the present drive [A | V], limited to `drive_range`.

    With a lag, the present drive is the drive in `state`; without a lag, it is `command`.
    """
    low, high = drive_range(p, state[ax.VELOCITY])
    return float(min(max(state[ax.DRIVE] if p[ax.LAG] > 0.0 else command, low), high))


@kernel
def advance(state: Vector, command: float, parameters: Vector, duration: float) -> int:
    """Advance `state` (7,), in place, by `duration` [s] under a constant `command` [A | V].

    plant/axis.py lists the entries of `state` and of `parameters` (14,). `AxisLaws` extend
    `parameters` to (EXTENDED_SIZE,). A dynamic law (engine/dynamic_law_axis.py) and a load
    (plant/position_load.py `with_load`) append values to `parameters`; a dynamic law also appends
    its internal states to `state`. With a winding, supply voltage and back-EMF limit the current.
    This limit is computed for the speed at the beginning of the call. Returns a status of
    engine/status_codes.py.
    """
    return int(advance_axis(state, command, parameters, parameters, duration))


@kernel
def advance_axis(
    state: Vector, command: float, parameters: Vector, curved: Laws, duration: float
) -> int:
    """Advance `state` as `advance` does; slips are integrated in steps only if required.

    curved: None if every slip has a closed form (axis_friction.py `is_straight`), else
    `parameters`.
    """
    total = command * 0.0 + duration
    for index in range(ax.STATE_SIZE):
        total += state[index]
    if not math.isfinite(total) or duration < 0.0:
        return NOT_FINITE
    limit = parameters[ax.DRIVE_LIMIT]
    command = min(max(command, -limit), limit)
    if parameters[ax.RESISTANCE] > 0.0:
        low, high = drive_range(parameters, state[ax.VELOCITY])
        command = min(max(command, low), high)
        state[ax.DRIVE] = min(max(state[ax.DRIVE], low), high)
    if parameters[ax.LAG] == 0.0:
        state[ax.DRIVE] = command
    if parameters.shape[0] == al.PLAIN_SIZE:
        return _advance(state, command, parameters, None, None, duration)
    if curved is not None and has_dynamic_law(curved):
        return int(move_under_law(state, command, curved, duration))
    return _advance(state, command, parameters, parameters, curved, duration)
