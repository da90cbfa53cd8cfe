"""Event-driven simulation of a body with dry friction under a sequence of efforts.

The simulation is exact to rounding, except at low speed, in the Stribeck layer (`tolerance`).

    at rest            x and v are constant, and the effort is a power series; the instant at which
                       the effort crosses the breakaway threshold is exact to rounding
    Stribeck layer     Dormand-Prince with error control; its dense output locates the events
    above the layer    power series, exact to rounding, with Coulomb and viscous friction of fixed
                       sign (engine/power_series.py)

The direction is fixed within an interval of slip: no integrator evaluates sign(v). Rules prevent
endless cycles:

- An effort that equals the breakaway threshold to rounding breaks the body away only if the effort
  rises.
- If the initial acceleration of a slip is zero to rounding, it is set to zero.
- After a slip that begins and ends at the same instant, the threshold in the direction of this slip
  is slightly above the breakaway.
- A body leaves the Stribeck layer at a higher speed than it enters this layer. Likewise, the
  viscous coefficient changes at a higher speed while the body speeds up than while it slows down.
- A body rests at an end stop (event RESTS_AT_STOP) instead of a rebound with a flight shorter than
  SHORTEST_FLIGHT times the duration of the run.

Any other endless cycle ends the call with status TOO_MANY_EVENTS, at the returned time.

`run_extended` simulates extended friction (friction/law_extension.py) by the same driver, with the
pieces of extended_friction_motion.py and the events of extended_friction_events.py.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine import body as fb
from frictool.engine.dormand_prince import STAGES, Force
from frictool.engine.drive import DERIVATIVE, FREQUENCY, INTEGRAL, PROPORTIONAL, effort
from frictool.engine.extended_friction_events import extended_arrival, extended_slip_event, locate
from frictool.engine.extended_friction_motion import (
    DENSE_TERMS,
    FILM,
    RESTED,
    ROWS,
    ExtendedLaws,
    pass_time,
    sampled_friction,
    slip_piece,
)
from frictool.engine.extended_friction_motion import rest_piece as extended_rest_piece
from frictool.engine.motion_pieces import (
    DrivenBody,
    friction,
    layer_piece,
    rest_piece,
    straight_piece,
)
from frictool.engine.polynomial_events import value
from frictool.engine.power_series import TERMS
from frictool.engine.slip_events import arrive, region, slip_event
from frictool.engine.status_codes import EVENTS_FULL, NOT_FINITE, OK, TOO_MANY_EVENTS
from frictool.friction.law_extension import LAG
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import Vector

STEPS_PER_EVENT = 1000.0

# None without an extension; numba compiles both cases separately
Extension = ExtendedLaws | None


@kernel
def pieces_allowed(body: Vector, drive: Vector, span: float, events: int) -> float:
    """Return the allowed number of intervals of motion, which only an endless cycle exceeds.

    The number grows with `events`, `span` and the fastest rate of the equations of motion. If the
    Stribeck layer has no upper speed limit, the number also grows with (Coulomb friction)/(mass
    times `speed_scale`).
    """
    viscous = max(
        body[fb.VISCOUS], body[fb.VISCOUS + 1], body[fb.VISCOUS_BEYOND], body[fb.VISCOUS_BEYOND + 1]
    )
    rate = (viscous + abs(drive[DERIVATIVE])) / body[fb.MASS] + drive[FREQUENCY]
    rate += math.sqrt(abs(drive[PROPORTIONAL]) / body[fb.MASS]) + (
        abs(drive[INTEGRAL]) / body[fb.MASS]
    ) ** (1.0 / 3.0)
    if body[fb.LAYER] == math.inf:
        rate += (
            10.0
            * max(body[fb.COULOMB], body[fb.COULOMB + 1])
            / (body[fb.MASS] * body[fb.SPEED_SCALE])
        )
    allowed: float = STEPS_PER_EVENT * (events + 1) + 100.0 * rate * span
    return allowed


@bare_kernel
def _fill(
    driven: DrivenBody,
    laws: Extension,
    state: Vector,
    t: float,
    until: float,
    piece: Vector,
    terms: int,
    times: Vector,
    samples: Vector,
    filled: int,
) -> int:
    drive = driven.drive
    while filled < times.shape[0] and times[filled] < until:
        ahead = times[filled] - t
        x, v = value(piece[0, :terms], ahead), value(piece[1, :terms], ahead)
        u = effort(times[filled], x, v, value(piece[2, :terms], ahead), drive)
        if laws is None:
            opposing = friction(driven, state, v, u)
        else:
            y = x, v, value(piece[3, :terms], ahead)
            opposing = sampled_friction(driven, laws, state, ahead, y, u)
        row = samples[filled]
        row[fb.SAMPLE_POSITION], row[fb.SAMPLE_VELOCITY], row[fb.SAMPLE_EFFORT] = x, v, u
        row[fb.SAMPLE_FRICTION] = opposing
        row[fb.SAMPLE_MODE] = state[fb.DIRECTION]
        filled += 1
    return filled


@bare_kernel
def _advance_piece(
    driven: DrivenBody,
    state: Vector,
    t: float,
    longest: float,
    refused: float,
    piece: Vector,
    probe: Vector,
    slopes: Vector,
    pace: Vector,
) -> tuple[int, float, int, float, int]:
    terms = TERMS
    if state[fb.DIRECTION] == 0.0:
        spent, towards = rest_piece(driven, state, t, longest, refused, piece, probe)
        return terms, spent, fb.BREAKS_AWAY if towards != 0.0 else fb.NO_EVENT, towards, OK
    if state[fb.REGION] == fb.IN_LAYER:
        terms = DENSE_TERMS
        spent, status = layer_piece(driven, state, t, longest, pace, slopes, piece)
        if status != OK:
            return terms, 0.0, fb.NO_EVENT, 0.0, status
    else:
        spent = straight_piece(driven, state, t, longest, piece)
    spent, kind = slip_event(state, driven.body, piece, terms, spent, probe)
    if kind != fb.NO_EVENT:
        pace[0] = 0.0
    return terms, spent, kind, 0.0, OK


@kernel
def _advance_extended(
    driven: DrivenBody,
    laws: ExtendedLaws,
    state: Vector,
    t: float,
    longest: float,
    refused: float,
    piece: Vector,
    probe: Vector,
    slopes: Vector,
    pace: Vector,
) -> tuple[int, float, int, float, int]:
    if state[fb.DIRECTION] == 0.0:
        spent, towards = extended_rest_piece(driven, laws, state, t, longest, refused, piece)
        return TERMS, spent, fb.BREAKS_AWAY if towards != 0.0 else fb.NO_EVENT, towards, OK
    spent, status = slip_piece(driven, laws, state, t, longest, pace, slopes, piece)
    if status != OK:
        return DENSE_TERMS, 0.0, fb.NO_EVENT, 0.0, status
    spent, kind = extended_slip_event(laws, driven.body, state, piece, spent, probe)
    if kind != fb.NO_EVENT:
        pace[0] = 0.0
    return DENSE_TERMS, spent, kind, 0.0, OK


@bare_kernel
def _move(state: Vector, piece: Vector, terms: int, spent: float) -> None:
    for row in range(3):
        total = 0.0
        for k in range(terms - 1, -1, -1):
            total = total * spent + piece[row, k]
        state[row] = total


@kernel
def record(events: Vector, happened: int, t: float, kind: int, x: float, v: float) -> None:
    """Write one event to `events`; a breakaway at the instant of a stop has the kind SLIPS_BACK."""
    if (
        kind == fb.BREAKS_AWAY
        and happened > 0
        and events[happened - 1, 1] == fb.STOPS
        and events[happened - 1, 0] == t
    ):
        kind = fb.SLIPS_BACK
    row = events[happened]
    row[0] = t
    row[1] = kind
    row[2] = x
    row[3] = v


@kernel
def _segment(
    driven: DrivenBody,
    laws: Extension,
    state: Vector,
    t: float,
    end: float,
    span: float,
    times: Vector,
    samples: Vector,
    filled: int,
    events: Vector,
    happened: int,
) -> tuple[int, float, int, int]:
    body, drive = driven.body, driven.drive
    piece = np.zeros((4, TERMS))
    probe = np.zeros(TERMS)
    pace = np.zeros(3)
    left = pieces_allowed(body, drive, end - t, events.shape[0])
    if laws is None:
        slopes = np.empty((3, STAGES))
    else:
        slopes = np.zeros((STAGES, ROWS))
        if laws[2][LAG] > 0.0:
            left += 100.0 * (end - t) / laws[2][LAG]
    refused = 0.0
    began = -math.inf
    while t < end:
        left -= 1.0
        if laws is None:
            terms, spent, kind, towards, status = _advance_piece(
                driven, state, t, end - t, refused, piece, probe, slopes, pace
            )
        else:
            terms, spent, kind, towards, status = _advance_extended(
                driven, laws, state, t, end - t, refused, piece, probe, slopes, pace
            )
        if status != OK or left < 0.0:
            return status if status != OK else TOO_MANY_EVENTS, t, filled, happened
        later = t + spent if spent < end - t else end
        if filled < times.shape[0] and times[filled] < later:
            filled = _fill(driven, laws, state, t, later, piece, terms, times, samples, filled)
        _move(state, piece, terms, spent)
        if laws is not None:
            pass_time(laws, state, piece[3, :terms], spent)
        t = later
        if kind != fb.NO_EVENT:
            if happened == events.shape[0]:
                return EVENTS_FULL, t, filled, happened
            speed, direction = state[fb.VELOCITY], state[fb.DIRECTION]
            if laws is None:
                kind = arrive(driven, state, t, kind, towards, span)
            else:
                kind = extended_arrival(driven, laws, state, t, kind, towards, span)
            record(events, happened, t, kind, state[fb.POSITION], speed)
            happened += 1
            if kind == fb.BREAKS_AWAY:
                began = t
                refused = 0.0
            elif kind == fb.STOPS:
                refused = direction if t == began else 0.0
    return OK, t, filled, happened


@kernel
def _run(
    force: Force,
    law: Vector,
    laws: Extension,
    body: Vector,
    state: Vector,
    start: float,
    ends: Vector,
    drives: Vector,
    times: Vector,
    samples: Vector,
    events: Vector,
) -> tuple[int, float, int]:
    t = start
    filled = 0
    happened = 0
    span = ends[-1] - start
    if not (math.isfinite(span) and np.all(np.isfinite(state[:RESTED]))):
        return NOT_FINITE, t, 0
    if laws is None:
        state[fb.REGION] = region(body, abs(state[fb.VELOCITY]))
    else:
        locate(laws, body, state)
    for k in range(ends.shape[0]):
        driven = DrivenBody(force, law, body, drives[k])
        status, t, filled, happened = _segment(
            driven, laws, state, t, ends[k], span, times, samples, filled, events, happened
        )
        if status != OK:
            return status, t, happened
    driven = DrivenBody(force, law, body, drives[-1])
    last = np.zeros((ROWS, 1))
    for row in range(3):
        last[row, 0] = state[row]
    if laws is not None:
        last[3, 0] = state[FILM]
    _fill(driven, laws, state, t, math.inf, last, 1, times, samples, filled)
    return OK, t, happened


@kernel
def run(
    force: Force,
    law: Vector,
    body: Vector,
    state: Vector,
    start: float,
    ends: Vector,
    drives: Vector,
    times: Vector,
    samples: Vector,
    events: Vector,
) -> tuple[int, float, int]:
    """Simulate a body with friction from `start` [s] under a sequence of efforts.

    - ends (s,), drives (s, 10): the effort drives[i] (engine/drive.py) acts up to ends[i] [s]
    - law: parameters of `force(v, direction, law)`
    - times (n,): ascending, within the run

    `state` (5,) is changed in place; samples (n, 5) and events (m, 4) are filled. engine/body.py
    lists the entries of `state`, of `body` (16,), and of the rows of `samples` and `events`.

    Returns a status of engine/status_codes.py, the time reached and the number of events. If the
    status is not OK, samples after the time reached are unchanged.
    """
    return _run(force, law, None, body, state, start, ends, drives, times, samples, events)


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
    """Simulate as `run` does, for extended friction and the larger `state` (8,).

    extended_friction_events.py defines `state`. forward, backward, table: arrays of a
    PackedExtension. `body` is overwritten as workspace.
    """
    laws = (forward, backward, table, np.empty_like(forward))
    return _run(force, forward, laws, body, state, start, ends, drives, times, samples, events)
