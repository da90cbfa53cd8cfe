"""What ends a piece of slip, and what then becomes of the state: layer, knee, stop, end stops."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.body import (
    BEYOND_KNEE,
    BOUNCES,
    BREAKS_AWAY,
    DIRECTION,
    ENTERS_LAYER,
    IN_LAYER,
    INTEGRAL_STATE,
    KNEE,
    LAYER,
    LEAVES_LAYER,
    LOWER_STOP,
    MASS,
    NO_EVENT,
    PASSES_KNEE,
    POSITION,
    REGION,
    RESTITUTION,
    RESTS_AT_STOP,
    STOPS,
    STRAIGHT,
    UPPER_STOP,
    VELOCITY,
)
from frictool.engine.drive import effort
from frictool.engine.motion_pieces import friction_line
from frictool.engine.polynomial_events import NEVER, first_fall
from frictool.runtime.kernels import bare_kernel, kernel

Vector = NDArray[np.float64]

BELOW = 0.98  # of the layer's speed: where a slip that slows down enters it again
BELOW_KNEE = 1.0 - 2.0**-40  # of the knee's
SHORTEST_FLIGHT = 1e-9  # of the run


@kernel
def region(body: Vector, speed: float) -> float:
    """The region of a slip at this speed."""
    if speed < body[LAYER]:
        return IN_LAYER
    return STRAIGHT if speed < body[KNEE] else BEYOND_KNEE


@kernel
def sooner(
    piece: Vector, terms: int, row: int, sign: float, level: float, longest: float, probe: Vector
) -> float:
    """First t at which sign (piece[row] - level) falls to zero within `longest`, or NEVER."""
    for k in range(terms):
        probe[k] = sign * piece[row, k]
    probe[0] -= sign * level
    return first_fall(probe[:terms], longest)


@bare_kernel
def _swing(piece: Vector, terms: int, h: float) -> float:
    """What the speed does not change by more than within h."""
    total = 0.0
    for k in range(terms - 1, 0, -1):
        total = (total + abs(piece[1, k])) * h
    return total


@bare_kernel
def slip_event(
    state: Vector, body: Vector, piece: Vector, terms: int, longest: float, probe: Vector
) -> tuple[float, int]:
    """The first event on a piece of slip and when: a stop, the layer's or the knee's speed, an end
    stop."""
    direction, here, spent, kind = state[DIRECTION], state[REGION], longest, NO_EVENT
    upwards, upper = math.inf, NO_EVENT
    downwards, lower = 0.0, STOPS
    if here == IN_LAYER:
        upwards, upper = body[LAYER], LEAVES_LAYER
    elif here == STRAIGHT:
        upwards, upper = body[KNEE], PASSES_KNEE
        if body[LAYER] > 0.0:
            downwards, lower = BELOW * body[LAYER], ENTERS_LAYER
    else:
        downwards, lower = BELOW_KNEE * body[KNEE], PASSES_KNEE
    now, swing = direction * state[VELOCITY], _swing(piece, terms, spent)
    if now - swing <= downwards:
        crossing = sooner(piece, terms, 1, direction, direction * downwards, spent, probe)
        if crossing != NEVER:
            spent, kind = crossing, lower
    if now + swing >= upwards:
        crossing = sooner(piece, terms, 1, -direction, direction * upwards, spent, probe)
        if crossing != NEVER:
            spent, kind = crossing, upper
    wall = body[UPPER_STOP] if direction > 0.0 else body[LOWER_STOP]
    if math.isfinite(wall):
        crossing = sooner(piece, terms, 0, -direction, wall, spent, probe)
        if crossing != NEVER:
            spent, kind = crossing, BOUNCES
    return spent, kind


@kernel
def _bounce(state: Vector, body: Vector, drive: Vector, t: float, span: float) -> int:
    """At an end stop: back with the restitution, or to rest."""
    direction = state[DIRECTION]
    state[POSITION] = body[UPPER_STOP] if direction > 0.0 else body[LOWER_STOP]
    state[VELOCITY] *= -body[RESTITUTION]
    state[DIRECTION] = -direction
    state[REGION] = region(body, abs(state[VELOCITY]))
    outwards = direction * effort(t, state[POSITION], state[VELOCITY], state[INTEGRAL_STATE], drive)
    constant, _ = friction_line(body, STRAIGHT, -direction)
    returning = (outwards + abs(constant)) / body[MASS]
    if abs(state[VELOCITY]) * 2.0 <= returning * SHORTEST_FLIGHT * span or state[VELOCITY] == 0.0:
        state[VELOCITY] = 0.0
        state[DIRECTION] = 0.0
        return RESTS_AT_STOP
    return BOUNCES


@kernel
def arrive(
    state: Vector, body: Vector, drive: Vector, t: float, kind: int, towards: float, span: float
) -> int:
    """Changes direction, region and speed as the event asks; returns the event, which is another
    one where a rebound rests.

    `towards`: the direction that breaks away. `span` [s]: the length of the run.
    """
    direction = state[DIRECTION]
    if kind == BREAKS_AWAY:
        state[DIRECTION], state[REGION] = towards, region(body, 0.0)
    elif kind == LEAVES_LAYER:
        state[VELOCITY], state[REGION] = direction * body[LAYER], STRAIGHT
    elif kind == ENTERS_LAYER:
        state[VELOCITY], state[REGION] = direction * BELOW * body[LAYER], IN_LAYER
    elif kind == PASSES_KNEE:
        up = state[REGION] == STRAIGHT
        state[VELOCITY] = direction * (body[KNEE] if up else BELOW_KNEE * body[KNEE])
        state[REGION] = BEYOND_KNEE if up else STRAIGHT
    elif kind == STOPS:
        state[VELOCITY] = 0.0
        state[DIRECTION] = 0.0
    elif kind == BOUNCES:
        return _bounce(state, body, drive, t, span)
    return kind
