"""One interval (piece) of a body's motion: at rest, in the Stribeck layer, or above it.

A piece is an interval of time in which x, v, q and u are polynomials of the time since its start. x
is the position, v the velocity, q the integral of the position error, and u the effort. An array
`piece` has a row of coefficients for x, v, q and, outside the Stribeck layer, u.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictool.engine import body as fb
from frictool.engine import drive as dr
from frictool.engine.dormand_prince import STAGES, Force, dense_output, layer_step
from frictool.engine.drive import effort
from frictool.engine.polynomial_events import NEVER, first_fall
from frictool.engine.power_series import TERMS, motion, reach
from frictool.engine.status_codes import NOT_FINITE, OK, STEP_TOO_SMALL
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import Vector

ROUNDING = 2.0**-48  # largest effort that is treated as zero, relative to its terms
TRACE = 2.0**-40  # amount by which `rest_piece` raises a threshold, relative to the effort's terms
SHORTEST_STEP = 2.0**-50  # shortest step, relative to the time or to the run
# first step, relative to the time in which the largest force would accelerate the body through the
# Stribeck layer
FIRST_STEP = 2.0
FLOOR = 2.0**-5  # smallest reference speed of the relative tolerance, in units of the speed scale
GROWTH, SHRINKAGE, SAFETY = 10.0, 0.2, 0.85
# exponents of the present and the last error in the next step length: proportional-integral control
# of the step length (Gustafsson 1991)
NOW = 0.85 / 5.0
BEFORE = 0.4 / 5.0
LEAST_ERROR = 1e-10


class DrivenBody(NamedTuple):
    """A body (engine/body.py) with its friction law under one drive (engine/drive.py)."""

    force: Force
    law: Vector
    body: Vector
    drive: Vector


@kernel
def side(direction: float) -> int:
    """Return the index of `direction` in a pair (backward, forward)."""
    return 1 if direction > 0.0 else 0


@bare_kernel
def friction_line(body: Vector, region: float, direction: float) -> tuple[float, float]:
    """Return (c, b) such that the signed friction force in the speed region `region` is c + b v."""
    index = side(direction)
    coulomb = direction * body[fb.COULOMB + index]
    viscous = body[fb.VISCOUS + index]
    if region != fb.BEYOND_KNEE:
        return coulomb, viscous
    beyond = body[fb.VISCOUS_BEYOND + index]
    return coulomb + direction * (viscous - beyond) * body[fb.KNEE], beyond


@bare_kernel
def friction(driven: DrivenBody, state: Vector, v: float, u: float) -> float:
    """Return the friction [N | N m] at velocity v; at rest, the effort u limited by the breakaway.

    If a body at rest touches an end stop, the stop balances the remaining effort.
    """
    force, law, body = driven.force, driven.law, driven.body
    if state[fb.DIRECTION] == 0.0:
        held: float = min(max(u, -body[fb.BREAKAWAY]), body[fb.BREAKAWAY + 1])
        return held
    if state[fb.REGION] == fb.IN_LAYER:
        curve: float = force(v, state[fb.DIRECTION], law)
        return curve
    constant, viscous = friction_line(body, state[fb.REGION], state[fb.DIRECTION])
    return constant + viscous * v


@kernel
def gross(state: Vector, t: float, drive: Vector) -> float:
    """Return the sum of the magnitudes of the effort's terms, for bounds of rounding errors."""
    distance: float = (
        abs(state[fb.POSITION]) + abs(drive[dr.TARGET]) + abs(drive[dr.TARGET_SPEED] * t)
    )
    free: float = (
        abs(drive[dr.AMPLITUDE]) * (1.0 + abs(drive[dr.FREQUENCY] * t))
        + abs(drive[dr.OFFSET])
        + abs(drive[dr.SLOPE] * t)
    )
    summed: float = abs(drive[dr.INTEGRAL]) * (abs(state[fb.INTEGRAL_STATE]) + distance * abs(t))
    fed_back: float = abs(drive[dr.PROPORTIONAL]) * distance + abs(
        drive[dr.DERIVATIVE] * state[fb.VELOCITY]
    )
    return free + summed + fed_back


@kernel
def rest_piece(
    driven: DrivenBody,
    state: Vector,
    t: float,
    longest: float,
    refused: float,
    piece: Vector,
    probe: Vector,
) -> tuple[float, float]:
    """Return the duration [s] of a rest, and the direction of the breakaway that ends it (0: none).

    refused: direction of a slip that has just begun and ended at the same instant (0: none); the
    breakaway threshold in this direction is raised slightly.
    """
    body, drive = driven.body, driven.drive
    motion(state, t, drive, body[fb.MASS], 0.0, False, 0.0, piece)
    spent = min(longest, reach(piece[3]))
    towards = 0.0
    for direction in (-1.0, 1.0):
        blocked = (
            state[fb.POSITION] >= body[fb.UPPER_STOP]
            if direction > 0.0
            else state[fb.POSITION] <= body[fb.LOWER_STOP]
        )
        if blocked:
            continue
        threshold = body[fb.BREAKAWAY + side(direction)]
        for k in range(TERMS):
            probe[k] = -direction * piece[3, k]
        probe[0] += threshold
        size = threshold + gross(state, t, drive)
        if direction == refused:
            probe[0] += TRACE * size
        elif abs(probe[0]) <= ROUNDING * size:
            probe[0] = 0.0
        crossing = first_fall(probe, spent)
        if crossing != NEVER:
            spent, towards = crossing, direction
    return spent, towards


@bare_kernel
def _acceleration(driven: DrivenBody, state: Vector, t: float) -> float:
    body, drive = driven.body, driven.drive
    u = effort(t, state[fb.POSITION], state[fb.VELOCITY], state[fb.INTEGRAL_STATE], drive)
    opposing = friction(driven, state, state[fb.VELOCITY], u)
    if state[fb.VELOCITY] == 0.0 and abs(u - opposing) <= ROUNDING * (
        abs(opposing) + gross(state, t, drive)
    ):
        return 0.0
    gained: float = (u - opposing) / body[fb.MASS]
    return gained


@bare_kernel
def lengthen(pace: Vector, h: float, least: float, error: float) -> None:
    """Set the next step length in `pace`, at least `least`, after an accepted step of length h.

    error: the step's error divided by the tolerance.
    """
    size = math.log(max(error, LEAST_ERROR))
    pace[0] = max(least, h * min(GROWTH, SAFETY * math.exp(BEFORE * pace[1] - NOW * size)))
    pace[1] = size


@bare_kernel
def shortening(error: float) -> float:
    """Return the step-size factor after a rejected step."""
    return max(SHRINKAGE, SAFETY * error**-0.2) if math.isfinite(error) else SHRINKAGE


@bare_kernel
def layer_piece(
    driven: DrivenBody,
    state: Vector,
    t: float,
    longest: float,
    pace: Vector,
    slopes: Vector,
    piece: Vector,
) -> tuple[float, int]:
    """Integrate one step in the Stribeck layer; return the length of the step [s] and a status.

    pace (3,): step length to try [s], 0 at first; logarithm of the last error; time at which the
    body entered the layer [s]. The error of v is at most `tolerance` times the largest of three
    speeds: FLOOR times `speed_scale`, abs(v), and acceleration times time spent in the layer.
    """
    force, law, body, drive = driven
    # the last stage of a step is the first stage of the next step
    mass = body[fb.MASS]
    start = slopes[1, STAGES - 1]
    if pace[0] == 0.0:
        start = _acceleration(driven, state, t)
        largest = body[fb.BREAKAWAY] + body[fb.BREAKAWAY + 1] + gross(state, t, drive)
        pace[0] = (
            FIRST_STEP * min(body[fb.LAYER], body[fb.SPEED_SCALE]) * mass / largest
            if largest > 0.0
            else longest
        )
        pace[1] = 0.0
        pace[2] = t
    wish = pace[0]
    cut = pace[0] > longest
    h = wish
    shortest = SHORTEST_STEP * max(abs(t), longest)
    allowed = body[fb.TOLERANCE] * max(
        FLOOR * body[fb.SPEED_SCALE], abs(state[fb.VELOCITY]), abs(start) * (t - pace[2])
    )
    while True:
        h = min(h, longest)
        error = (
            layer_step(force, law, mass, state[fb.DIRECTION], drive, t, h, start, state, slopes)
            / allowed
        )
        if error <= 1.0:
            lengthen(pace, h, wish if cut else 0.0, error)
            dense_output(state, slopes, h, piece)
            return h, OK
        if h <= shortest:
            return h, STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        cut = False
        h *= shortening(error)


@kernel
def straight_piece(
    driven: DrivenBody, state: Vector, t: float, longest: float, piece: Vector
) -> float:
    """Fill `piece` with a slip above the Stribeck layer, in closed form; return its length [s]."""
    body, drive = driven.body, driven.drive
    start = _acceleration(driven, state, t)
    _, viscous = friction_line(body, state[fb.REGION], state[fb.DIRECTION])
    motion(state, t, drive, body[fb.MASS], viscous, True, start, piece)
    return min(longest, reach(piece[1]))
