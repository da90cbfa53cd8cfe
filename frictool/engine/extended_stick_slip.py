"""Event-driven simulation of a body with extended friction (friction/extension.py).

It works as engine/stick_slip.py, with more state:

    state (8,)   that of engine/body.py, then the film's lagged velocity, the time at rest, the
                 number of knees passed

The time at rest counts from the stop, or from the start of a run that begins at rest; during slip
it is that of the last rest. A pure delay of the film is not supported: the motion after an event
would depend on all pieces within the preceding delay, and each of their kinks would return as an
event. The fixed-step laws support it (engine/fixed_step.py).
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine import body as fb
from frictool.engine.dormand_prince import STAGES, Force
from frictool.engine.drive import effort
from frictool.engine.extended_motion_pieces import (
    FILM,
    KNEES_PASSED,
    RESTED,
    ROWS,
    Laws,
    film_at_rest,
    rest_piece,
    slip_friction,
    slip_piece,
    threshold,
)
from frictool.engine.motion_pieces import side
from frictool.engine.polynomial_events import NEVER, value
from frictool.engine.power_series import TERMS
from frictool.engine.slip_events import BELOW, arrive, sooner
from frictool.engine.status import EVENTS_FULL, NOT_FINITE, OK, TOO_MANY_EVENTS
from frictool.engine.stick_slip import DENSE_TERMS, pieces_allowed, record
from frictool.friction.extension import BOUNDARY, LAG, levels, regime_table
from frictool.friction.lubricant_film import boundary_film
from frictool.friction.speed_regimes import count_passed_knees
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def _locate(laws: Laws, body: Vector, state: Vector) -> None:
    """Set layer side and speed regime of the state; without a lag also the film's velocity."""
    table = laws[2]
    if table[LAG] == 0.0:
        state[FILM] = state[fb.VELOCITY]
    state[fb.REGION] = (
        fb.IN_LAYER
        if abs(boundary_film(state[FILM], table[BOUNDARY])) < body[fb.LAYER]
        else fb.STRAIGHT
    )
    state[KNEES_PASSED] = count_passed_knees(abs(state[fb.VELOCITY]), regime_table(table))


@kernel
def _layer_event(
    laws: Laws, body: Vector, state: Vector, piece: Vector, spent: float, probe: Vector
) -> tuple[float, int]:
    """Return when the film's velocity leaves or enters the layer, and which of the two."""
    row = 3 if laws[2][LAG] > 0.0 else 1
    if state[fb.REGION] == fb.IN_LAYER:
        if body[fb.LAYER] == math.inf:
            return spent, fb.NO_EVENT
        sign, level, kind = (
            -state[fb.DIRECTION],
            state[fb.DIRECTION] * (laws[2][BOUNDARY] + body[fb.LAYER]),
            fb.LEAVES_LAYER,
        )
    elif body[fb.LAYER] > 0.0:
        sign = math.copysign(1.0, piece[row, 0])
        level, kind = sign * (laws[2][BOUNDARY] + BELOW * body[fb.LAYER]), fb.ENTERS_LAYER
    else:
        return spent, fb.NO_EVENT
    crossing = sooner(piece, DENSE_TERMS, row, sign, level, spent, probe)
    return (crossing, kind) if crossing != NEVER else (spent, fb.NO_EVENT)


@kernel
def _slip_event(
    laws: Laws, body: Vector, state: Vector, piece: Vector, longest: float, probe: Vector
) -> tuple[float, int]:
    """Return time and kind of the first event on a piece of slip: stop, knee, layer or end stop."""
    regimes, passed, direction = (
        regime_table(laws[2]),
        int(state[KNEES_PASSED]),
        state[fb.DIRECTION],
    )
    spent, kind = longest, fb.NO_EVENT
    below = regimes[2 * passed - 2] if passed > 0 else 0.0
    crossing = sooner(piece, DENSE_TERMS, 1, direction, direction * below, spent, probe)
    if crossing != NEVER:
        spent, kind = crossing, fb.PASSES_KNEE if passed > 0 else fb.STOPS
    if 2 * passed < regimes.shape[0]:
        crossing = sooner(
            piece, DENSE_TERMS, 1, -direction, direction * regimes[2 * passed], spent, probe
        )
        if crossing != NEVER:
            spent, kind = crossing, fb.PASSES_KNEE
    crossing, change = _layer_event(laws, body, state, piece, spent, probe)
    if change != fb.NO_EVENT:
        spent, kind = crossing, change
    wall = body[fb.UPPER_STOP] if direction > 0.0 else body[fb.LOWER_STOP]
    if math.isfinite(wall):
        crossing = sooner(piece, DENSE_TERMS, 0, -direction, wall, spent, probe)
        if crossing != NEVER:
            spent, kind = crossing, fb.BOUNCES
    return spent, kind


@kernel
def _pass_knee(laws: Laws, state: Vector) -> None:
    """Set the speed to that of the nearest knee, and the regime to the one on its other side."""
    regimes, passed, speed = (
        regime_table(laws[2]),
        int(state[KNEES_PASSED]),
        abs(state[fb.VELOCITY]),
    )
    upper = regimes[2 * passed] if 2 * passed < regimes.shape[0] else math.inf
    up = passed == 0 or upper - speed < speed - regimes[2 * passed - 2]
    state[fb.VELOCITY] = state[fb.DIRECTION] * (upper if up else regimes[2 * passed - 2])
    state[KNEES_PASSED] = passed + 1 if up else passed - 1


@kernel
def _arrive(
    laws: Laws,
    body: Vector,
    state: Vector,
    drive: Vector,
    t: float,
    kind: int,
    towards: float,
    span: float,
) -> int:
    """Change the state by an event; return the event, which differs if a rebound comes to rest."""
    if kind == fb.PASSES_KNEE:
        _pass_knee(laws, state)
    elif kind in (fb.LEAVES_LAYER, fb.ENTERS_LAYER):
        state[fb.REGION] = fb.STRAIGHT if kind == fb.LEAVES_LAYER else fb.IN_LAYER
    else:
        forward, backward, table, p = laws
        levels(forward, backward, table, state[fb.POSITION], -state[fb.DIRECTION], state[RESTED], p)
        body[fb.COULOMB + side(-state[fb.DIRECTION])] = p[0]  # friction after a rebound
        kind = arrive(state, body, drive, t, kind, towards, span)
        _locate(laws, body, state)
        if state[fb.DIRECTION] == 0.0:
            state[RESTED] = 0.0
    return kind


@kernel
def _fill(
    force: Force,
    laws: Laws,
    body: Vector,
    state: Vector,
    drive: Vector,
    t: float,
    until: float,
    piece: Vector,
    times: Vector,
    samples: Vector,
    filled: int,
) -> int:
    """Fill the samples within a piece [t, until); return how many are filled now."""
    lag, x = laws[2][LAG], state[fb.POSITION]
    while filled < times.shape[0] and times[filled] < until:
        ahead, row = times[filled] - t, samples[filled]
        x, v, q = value(piece[0], ahead), value(piece[1], ahead), value(piece[2], ahead)
        u = effort(times[filled], x, v, q, drive)
        if state[fb.DIRECTION] == 0.0:
            w, rested = film_at_rest(state[FILM], lag, ahead), state[RESTED] + ahead
            most = threshold(force, laws, body, x, 1.0, rested, w)
            least = -threshold(force, laws, body, x, -1.0, rested, w)
            row[fb.SAMPLE_FRICTION] = min(max(u, least), most)
        else:
            row[fb.SAMPLE_FRICTION] = slip_friction(
                force, laws, state, x, v, value(piece[3], ahead) if lag > 0.0 else v
            )
        (
            row[fb.SAMPLE_POSITION],
            row[fb.SAMPLE_VELOCITY],
            row[fb.SAMPLE_EFFORT],
            row[fb.SAMPLE_MODE],
        ) = (
            x,
            v,
            u,
            state[fb.DIRECTION],
        )
        filled += 1
    return filled


@kernel
def _move(laws: Laws, state: Vector, piece: Vector, spent: float) -> None:
    """Set the state to the end of a piece; at rest the film decays and the time at rest grows."""
    lag, resting = laws[2][LAG], state[fb.DIRECTION] == 0.0
    state[FILM] = film_at_rest(state[FILM], lag, spent) if resting else value(piece[3], spent)
    if resting:
        state[RESTED] += spent
    state[fb.POSITION], state[fb.VELOCITY] = value(piece[0], spent), value(piece[1], spent)
    state[fb.INTEGRAL_STATE] = value(piece[2], spent)
    if lag == 0.0:
        state[FILM] = state[fb.VELOCITY]


@kernel
def _segment(
    force: Force,
    laws: Laws,
    body: Vector,
    state: Vector,
    drive: Vector,
    t: float,
    end: float,
    span: float,
    times: Vector,
    samples: Vector,
    filled: int,
    events: Vector,
    happened: int,
) -> tuple[int, float, int, int]:
    """Simulate one drive up to `end`; return status, time reached, number of samples and events."""
    resting, slipping, probe = np.zeros((4, TERMS)), np.zeros((ROWS, DENSE_TERMS)), np.zeros(TERMS)
    y, slopes, pace = np.zeros(ROWS), np.zeros((STAGES, ROWS)), np.zeros(3)
    left, refused, began = pieces_allowed(body, drive, end - t, events.shape[0]), 0.0, -math.inf
    if laws[2][LAG] > 0.0:
        left += 100.0 * (end - t) / laws[2][LAG]
    while t < end:
        left -= 1.0
        status, kind, towards, longest = OK, fb.NO_EVENT, 0.0, end - t
        if state[fb.DIRECTION] == 0.0:
            piece = resting
            spent, towards = rest_piece(force, laws, body, state, drive, t, longest, refused, piece)
            kind = fb.BREAKS_AWAY if towards != 0.0 else fb.NO_EVENT
        else:
            piece = slipping
            y[0], y[1], y[2], y[3] = (
                state[fb.POSITION],
                state[fb.VELOCITY],
                state[fb.INTEGRAL_STATE],
                state[FILM],
            )
            spent, status = slip_piece(
                force, laws, body, state, drive, t, longest, y, pace, slopes, piece
            )
            if status == OK:
                spent, kind = _slip_event(laws, body, state, piece, spent, probe)
        if status != OK or left < 0.0:
            return status if status != OK else TOO_MANY_EVENTS, t, filled, happened
        later = t + spent if spent < longest else end
        filled = _fill(force, laws, body, state, drive, t, later, piece, times, samples, filled)
        _move(laws, state, piece, spent)
        t = later
        if kind == fb.NO_EVENT:
            continue
        pace[0] = 0.0
        if happened == events.shape[0]:
            return EVENTS_FULL, t, filled, happened
        speed, direction = state[fb.VELOCITY], state[fb.DIRECTION]
        kind = _arrive(laws, body, state, drive, t, kind, towards, span)
        record(events, happened, t, kind, state[fb.POSITION], speed)
        happened += 1
        if kind == fb.BREAKS_AWAY:
            began, refused = t, 0.0
        elif kind == fb.STOPS:
            refused = direction if t == began else 0.0
    return OK, t, filled, happened


@kernel
def run_extended(
    force: Force,
    forward: Vector,
    backward: Vector,
    table: Vector,
    body: Vector,
    state: Vector,
    start: float,
    ends: Vector,
    drives: Vector,
    times: Vector,
    samples: Vector,
    events: Vector,
) -> tuple[int, float, int]:
    """Simulate as `stick_slip.run`, with `state` (8,) in place and an extension.

    forward, backward, table: packed by friction/extension.py. `body` is overwritten as workspace.
    """
    t, filled, happened, span = start, 0, 0, ends[-1] - start
    if not (math.isfinite(span) and np.all(np.isfinite(state[:RESTED]))):
        return NOT_FINITE, t, 0
    laws = (forward, backward, table, np.empty_like(forward))
    _locate(laws, body, state)
    for k in range(ends.shape[0]):
        status, t, filled, happened = _segment(
            force,
            laws,
            body,
            state,
            drives[k],
            t,
            ends[k],
            span,
            times,
            samples,
            filled,
            events,
            happened,
        )
        if status != OK:
            return status, t, happened
    last = np.array(
        (state[fb.POSITION], state[fb.VELOCITY], state[fb.INTEGRAL_STATE], state[FILM])
    ).reshape((ROWS, 1))
    _fill(force, laws, body, state, drives[-1], t, math.inf, last, times, samples, filled)
    return OK, t, happened
