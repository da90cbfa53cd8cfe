"""Events that end an interval of slip with extended friction, and the state after the event.

The functions correspond to the functions of slip_events.py, but use a larger state:

    state (8,)   the state (5,) of engine/body.py, the lagged velocity of the lubricant film, the
                 time at rest, and the number of knees (speeds at which the viscous coefficient
                 changes) below the speed

During a rest, the time at rest is measured from the stop, or from the start of a run that begins at
rest. During a slip, the time at rest is the duration of the last rest. A pure delay of the film is
not supported here, since each event would cause another event after the delay;
engine/fixed_step_laws.py supports such a delay.
"""

from __future__ import annotations

import math

from frictool.engine import body as fb
from frictool.engine.extended_friction_motion import (
    DENSE_TERMS,
    FILM,
    KNEES_PASSED,
    RESTED,
    ExtendedLaws,
)
from frictool.engine.motion_pieces import DrivenBody, side
from frictool.engine.polynomial_events import NEVER
from frictool.engine.slip_events import BELOW, arrive, sooner
from frictool.friction.law_extension import BOUNDARY, LAG, levels, regime_table
from frictool.friction.lubricant_film import boundary_film
from frictool.friction.speed_regimes import count_passed_knees
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def locate(laws: ExtendedLaws, body: Vector, state: Vector) -> None:
    """Set the speed range, the region and, if the film has no lag, the film's velocity in `state`.

    The region states whether the velocity of the film is in the Stribeck layer or above it.
    """
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
    laws: ExtendedLaws, body: Vector, state: Vector, piece: Vector, spent: float, probe: Vector
) -> tuple[float, int]:
    row = 3 if laws[2][LAG] > 0.0 else 1
    if state[fb.REGION] == fb.IN_LAYER:
        if body[fb.LAYER] == math.inf:
            return spent, fb.NO_EVENT
        sign = -state[fb.DIRECTION]
        level = state[fb.DIRECTION] * (laws[2][BOUNDARY] + body[fb.LAYER])
        kind = fb.LEAVES_LAYER
    elif body[fb.LAYER] > 0.0:
        sign = math.copysign(1.0, piece[row, 0])
        level = sign * (laws[2][BOUNDARY] + BELOW * body[fb.LAYER])
        kind = fb.ENTERS_LAYER
    else:
        return spent, fb.NO_EVENT
    crossing = sooner(piece, DENSE_TERMS, row, sign, level, spent, probe)
    return (crossing, kind) if crossing != NEVER else (spent, fb.NO_EVENT)


@kernel
def extended_slip_event(
    laws: ExtendedLaws, body: Vector, state: Vector, piece: Vector, longest: float, probe: Vector
) -> tuple[float, int]:
    """Return time [s] and kind of the first event of a slip within `longest` [s].

    An event is a stop, a change of the viscous coefficient, the limit of the Stribeck layer, or an
    end stop.
    """
    regimes = regime_table(laws[2])
    passed = int(state[KNEES_PASSED])
    direction = state[fb.DIRECTION]
    spent = longest
    kind = fb.NO_EVENT
    below = regimes[2 * passed - 2] if passed > 0 else 0.0
    crossing = sooner(piece, DENSE_TERMS, 1, direction, direction * below, spent, probe)
    if crossing != NEVER:
        spent = crossing
        kind = fb.PASSES_KNEE if passed > 0 else fb.STOPS
    if 2 * passed < regimes.shape[0]:
        crossing = sooner(
            piece, DENSE_TERMS, 1, -direction, direction * regimes[2 * passed], spent, probe
        )
        if crossing != NEVER:
            spent = crossing
            kind = fb.PASSES_KNEE
    crossing, change = _layer_event(laws, body, state, piece, spent, probe)
    if change != fb.NO_EVENT:
        spent, kind = crossing, change
    wall = body[fb.UPPER_STOP] if direction > 0.0 else body[fb.LOWER_STOP]
    if math.isfinite(wall):
        crossing = sooner(piece, DENSE_TERMS, 0, -direction, wall, spent, probe)
        if crossing != NEVER:
            spent = crossing
            kind = fb.BOUNCES
    return spent, kind


@kernel
def _pass_knee(laws: ExtendedLaws, state: Vector) -> None:
    regimes = regime_table(laws[2])
    passed = int(state[KNEES_PASSED])
    speed = abs(state[fb.VELOCITY])
    upper = regimes[2 * passed] if 2 * passed < regimes.shape[0] else math.inf
    up = passed == 0 or upper - speed < speed - regimes[2 * passed - 2]
    state[fb.VELOCITY] = state[fb.DIRECTION] * (upper if up else regimes[2 * passed - 2])
    state[KNEES_PASSED] = passed + 1 if up else passed - 1


@kernel
def extended_arrival(
    driven: DrivenBody,
    laws: ExtendedLaws,
    state: Vector,
    t: float,
    kind: int,
    towards: float,
    span: float,
) -> int:
    """Update the state after an event of the given `kind` at t; return the resulting kind.

    `slip_events.arrive` describes parameters and result.
    """
    body = driven.body
    if kind == fb.PASSES_KNEE:
        _pass_knee(laws, state)
    elif kind in (fb.LEAVES_LAYER, fb.ENTERS_LAYER):
        state[fb.REGION] = fb.STRAIGHT if kind == fb.LEAVES_LAYER else fb.IN_LAYER
    else:
        forward, backward, table, p = laws
        levels(forward, backward, table, state[fb.POSITION], -state[fb.DIRECTION], state[RESTED], p)
        body[fb.COULOMB + side(-state[fb.DIRECTION])] = p[0]  # friction after a rebound
        kind = arrive(driven, state, t, kind, towards, span)
        locate(laws, body, state)
        if state[fb.DIRECTION] == 0.0:
            state[RESTED] = 0.0
    return kind
