"""Events that end an interval of slip (engine/motion_pieces.py), and the state afterwards."""

from __future__ import annotations

import math

from frictool.engine import body as fb
from frictool.engine.drive import effort
from frictool.engine.motion_pieces import DrivenBody, friction_line
from frictool.engine.polynomial_events import NEVER, first_fall
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import Vector

# speed at which a slowing slip enters the Stribeck layer, or passes the knee, relative to the speed
# of the layer or the knee
BELOW = 0.98
BELOW_KNEE = 1.0 - 2.0**-40
# a rebound with a shorter flight, relative to the duration of the run, ends at rest at the stop
SHORTEST_FLIGHT = 1e-9


@kernel
def region(body: Vector, speed: float) -> float:
    """Return the speed region of a slip: IN_LAYER (Stribeck layer), STRAIGHT or BEYOND_KNEE."""
    if speed < body[fb.LAYER]:
        return fb.IN_LAYER
    return fb.STRAIGHT if speed < body[fb.KNEE] else fb.BEYOND_KNEE


@kernel
def sooner(
    piece: Vector, terms: int, row: int, sign: float, level: float, longest: float, probe: Vector
) -> float:
    """Return the first time [s] up to `longest` at which a polynomial passes `level`.

    The result is NEVER (-1) if the polynomial does not pass `level` in this time.

    The polynomial's coefficients are in `row` of `piece`: 0 for the position, 1 for the velocity, 3
    for the velocity of a lubricant film. At the returned time, sign * (polynomial - level) falls to
    zero. `probe` is workspace.
    """
    for k in range(terms):
        probe[k] = sign * piece[row, k]
    probe[0] -= sign * level
    return first_fall(probe[:terms], longest)


@bare_kernel
def _swing(piece: Vector, terms: int, h: float) -> float:
    total = 0.0
    for k in range(terms - 1, 0, -1):
        total = (total + abs(piece[1, k])) * h
    return total


@bare_kernel
def slip_event(
    state: Vector, body: Vector, piece: Vector, terms: int, longest: float, probe: Vector
) -> tuple[float, int]:
    """Return time [s] and kind of the first event in an interval of slip, within `longest` [s].

    An event occurs when the body stops, reaches an end stop, reaches the limit of the Stribeck
    layer, or reaches the speed at which the viscous coefficient changes. Without an event the
    result is (longest, NO_EVENT).
    """
    direction = state[fb.DIRECTION]
    here = state[fb.REGION]
    spent = longest
    kind = fb.NO_EVENT
    upwards, upper = math.inf, fb.NO_EVENT
    downwards = 0.0
    lower = fb.STOPS
    if here == fb.IN_LAYER:
        upwards = body[fb.LAYER]
        upper = fb.LEAVES_LAYER
    elif here == fb.STRAIGHT:
        upwards = body[fb.KNEE]
        upper = fb.PASSES_KNEE
        if body[fb.LAYER] > 0.0:
            downwards = BELOW * body[fb.LAYER]
            lower = fb.ENTERS_LAYER
    else:
        downwards = BELOW_KNEE * body[fb.KNEE]
        lower = fb.PASSES_KNEE
    now = direction * state[fb.VELOCITY]
    swing = _swing(piece, terms, spent)
    if now - swing <= downwards:
        crossing = sooner(piece, terms, 1, direction, direction * downwards, spent, probe)
        if crossing != NEVER:
            spent, kind = crossing, lower
    if now + swing >= upwards:
        crossing = sooner(piece, terms, 1, -direction, direction * upwards, spent, probe)
        if crossing != NEVER:
            spent, kind = crossing, upper
    wall = body[fb.UPPER_STOP] if direction > 0.0 else body[fb.LOWER_STOP]
    if math.isfinite(wall):
        crossing = sooner(piece, terms, 0, -direction, wall, spent, probe)
        if crossing != NEVER:
            spent = crossing
            kind = fb.BOUNCES
    return spent, kind


@kernel
def _bounce(driven: DrivenBody, state: Vector, t: float, span: float) -> int:
    body, drive = driven.body, driven.drive
    direction = state[fb.DIRECTION]
    state[fb.POSITION] = body[fb.UPPER_STOP] if direction > 0.0 else body[fb.LOWER_STOP]
    state[fb.VELOCITY] *= -body[fb.RESTITUTION]
    state[fb.DIRECTION] = -direction
    state[fb.REGION] = region(body, abs(state[fb.VELOCITY]))
    outwards = direction * effort(
        t, state[fb.POSITION], state[fb.VELOCITY], state[fb.INTEGRAL_STATE], drive
    )
    constant, _ = friction_line(body, fb.STRAIGHT, -direction)
    returning = (outwards + abs(constant)) / body[fb.MASS]
    if (
        abs(state[fb.VELOCITY]) * 2.0 <= returning * SHORTEST_FLIGHT * span
        or state[fb.VELOCITY] == 0.0
    ):
        state[fb.VELOCITY] = 0.0
        state[fb.DIRECTION] = 0.0
        return fb.RESTS_AT_STOP
    return fb.BOUNCES


@kernel
def arrive(
    driven: DrivenBody, state: Vector, t: float, kind: int, towards: float, span: float
) -> int:
    """Update the body's direction, region and speed after an event of the given `kind`.

    Returns the kind of the event; RESTS_AT_STOP replaces BOUNCES if the flight after the rebound
    would be too short.

    - towards: direction of a breakaway
    - span [s]: duration of the run
    """
    body = driven.body
    direction = state[fb.DIRECTION]
    if kind == fb.BREAKS_AWAY:
        state[fb.DIRECTION] = towards
        state[fb.REGION] = region(body, 0.0)
    elif kind == fb.LEAVES_LAYER:
        state[fb.VELOCITY] = direction * body[fb.LAYER]
        state[fb.REGION] = fb.STRAIGHT
    elif kind == fb.ENTERS_LAYER:
        state[fb.VELOCITY] = direction * BELOW * body[fb.LAYER]
        state[fb.REGION] = fb.IN_LAYER
    elif kind == fb.PASSES_KNEE:
        up = state[fb.REGION] == fb.STRAIGHT
        state[fb.VELOCITY] = direction * (body[fb.KNEE] if up else BELOW_KNEE * body[fb.KNEE])
        state[fb.REGION] = fb.BEYOND_KNEE if up else fb.STRAIGHT
    elif kind == fb.STOPS:
        state[fb.VELOCITY] = 0.0
        state[fb.DIRECTION] = 0.0
    elif kind == fb.BOUNCES:
        return _bounce(driven, state, t, span)
    return kind
