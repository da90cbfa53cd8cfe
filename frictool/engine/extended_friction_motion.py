"""Motion of a body with extended friction (friction/law_extension.py), one interval per call.

    at rest    the breakaway threshold only grows: with the time at rest, and as the velocity of the
               film decays
    in slip    Dormand-Prince with error control on position, speed and film; there is no closed
               form if Coulomb friction and breakaway vary with position

The lubricant film is described by a lagged velocity, which determines the Stribeck effect. A piece
is an interval of time with one mode of motion (motion_pieces.py). Within a piece of slip the
derivatives are smooth, because four quantities are constant: the direction, the speed range
between two knees of the viscous friction, the region inside or above the Stribeck layer, and the
time at rest before the slip. The time at rest determines the breakaway, which is the value of the
Stribeck curve at speed 0.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine import body as fb
from frictool.engine import dormand_prince as dp
from frictool.engine.dormand_prince import Force, dense_output, local_error, stage_point
from frictool.engine.drive import effort, reference
from frictool.engine.motion_pieces import (
    FIRST_STEP,
    FLOOR,
    ROUNDING,
    SHORTEST_STEP,
    TRACE,
    DrivenBody,
    gross,
    lengthen,
    shortening,
    side,
)
from frictool.engine.polynomial_events import MAX_HALVINGS, RESOLUTION, curvature_bound, value
from frictool.engine.power_series import motion, reach
from frictool.engine.status_codes import NOT_FINITE, OK, STEP_TOO_SMALL
from frictool.friction.law_extension import BOUNDARY, LAG, VISCOUS_INDEX, levels, regime_table
from frictool.friction.lubricant_film import boundary_film, film_force
from frictool.friction.speed_regimes import regime_force
from frictool.runtime.kernels import inner_kernel, kernel
from frictool.typing import Vector

# forward and backward parameters, the extension's table, workspace for the current parameters
ExtendedLaws = tuple[Vector, Vector, Vector, Vector]

# indices in the state, after the indices of engine/body.py
FILM, RESTED, KNEES_PASSED = 5, 6, 7
EXTENDED_SIZE = 8
# rows of an integrated motion: x, v, q, w
ROWS = 4
DENSE_TERMS = 5  # terms of the polynomials of an integrated piece


@inner_kernel
def slip_friction(
    force: Force, laws: ExtendedLaws, state: Vector, x: float, v: float, w: float
) -> float:
    """Return the friction [N | N m] in slip at position x, velocity v and lagged film velocity w.

    w determines the Stribeck effect (lubricant film). `state` contains the direction, the speed
    range, the region and the time at rest.
    """
    forward, backward, table, p = laws
    direction = state[fb.DIRECTION]
    levels(forward, backward, table, x, direction, state[RESTED], p)
    viscous = p[int(table[VISCOUS_INDEX])] if table[VISCOUS_INDEX] >= 0.0 else 0.0
    added = direction * regime_force(direction * v, regime_table(table), int(state[KNEES_PASSED]))
    if state[fb.REGION] == fb.STRAIGHT:
        line: float = direction * p[0] + viscous * v + added
        return line
    film = direction * abs(boundary_film(w, table[BOUNDARY]))
    curve: float = film_force(force(film, direction, p), v, film, viscous) + added
    return curve


@kernel
def threshold(
    driven: DrivenBody, laws: ExtendedLaws, x: float, direction: float, rested: float, w: float
) -> float:
    """Return the largest effort [N | N m] in `direction` under which the body stays at rest.

    Without a lubricant film, this effort is the breakaway. The velocity w of a film follows the
    velocity of the body with a lag, so that w is not yet 0 at the start of a rest. The friction at
    the start of a slip is then lower than for w = 0. The result is the breakaway minus this
    difference.
    """
    force, body = driven.force, driven.body
    forward, backward, table, p = laws
    breakaway: float = body[fb.BREAKAWAY + side(direction)] * levels(
        forward, backward, table, x, direction, rested, p
    )
    film = direction * abs(boundary_film(w, table[BOUNDARY]))
    if film == 0.0:
        return breakaway
    viscous = p[int(table[VISCOUS_INDEX])] if table[VISCOUS_INDEX] >= 0.0 else 0.0
    return breakaway - direction * (
        force(0.0, direction, p) - film_force(force(film, direction, p), 0.0, film, viscous)
    )


@kernel
def film_at_rest(w: float, lag: float, spent: float) -> float:
    """Return the lagged velocity of the lubricant film after the body has rested for `spent` [s].

    w: lagged velocity at the start of the rest.
    """
    return w * math.exp(-spent / lag) if lag > 0.0 else 0.0


@kernel
def sampled_friction(
    driven: DrivenBody,
    laws: ExtendedLaws,
    state: Vector,
    ahead: float,
    y: tuple[float, float, float],
    u: float,
) -> float:
    """Return the friction [N | N m], `ahead` [s] after the start of an interval of motion.

    At rest the result is the effort u, limited by the breakaway thresholds of both directions. y:
    position, velocity and lagged film velocity at this time.
    """
    force = driven.force
    x, v, w = y
    lag = laws[2][LAG]
    if state[fb.DIRECTION] == 0.0:
        w = film_at_rest(state[FILM], lag, ahead)
        rested = state[RESTED] + ahead
        most = threshold(driven, laws, x, 1.0, rested, w)
        least = -threshold(driven, laws, x, -1.0, rested, w)
        return min(max(u, least), most)
    return slip_friction(force, laws, state, x, v, w if lag > 0.0 else v)


@kernel
def pass_time(laws: ExtendedLaws, state: Vector, film: Vector, spent: float) -> None:
    """Advance the film's velocity and the time at rest in `state` by the time `spent` [s].

    `state` must already contain the body's velocity at the end of this time. film: polynomial of
    the film's velocity in slip. During a rest the film's velocity decays exponentially.
    """
    lag = laws[2][LAG]
    if state[fb.DIRECTION] == 0.0:
        state[FILM] = film_at_rest(state[FILM], lag, spent)
        state[RESTED] += spent
    else:
        state[FILM] = value(film, spent)
    if lag == 0.0:
        state[FILM] = state[fb.VELOCITY]


@kernel
def _threshold_after(
    driven: DrivenBody, laws: ExtendedLaws, state: Vector, direction: float, spent: float
) -> float:
    w = film_at_rest(state[FILM], laws[2][LAG], spent)
    return threshold(driven, laws, state[fb.POSITION], direction, state[RESTED] + spent, w)


@kernel
def _crossing(
    driven: DrivenBody,
    laws: ExtendedLaws,
    state: Vector,
    direction: float,
    u: Vector,
    low: float,
    high: float,
    more: float,
) -> float:
    middle = 0.5 * (low + high)
    while low < middle < high:
        if (
            direction * value(u, middle)
            >= _threshold_after(driven, laws, state, direction, middle) + more
        ):
            high = middle
        else:
            low = middle
        middle = 0.5 * (low + high)
    return high


@kernel
def _first_breakaway(
    driven: DrivenBody,
    laws: ExtendedLaws,
    state: Vector,
    direction: float,
    u: Vector,
    h: float,
    more: float,
    size: float,
) -> tuple[float, bool]:
    """Return the time [s] at which the rest ends, and True if the body then breaks away.

    The breakaway threshold never falls. The body therefore rests on [a, b] if the largest effort on
    [a, b] is below the threshold at a.

    - more: amount by which the threshold is raised [N | N m]
    - size: sum of the magnitudes of the effort's terms
    """
    bound = curvature_bound(u, h)
    low = 0.0
    width = h
    above = direction * u[0] - _threshold_after(driven, laws, state, direction, 0.0) - more
    if above > ROUNDING * size:
        return 0.0, True
    # at the threshold, the body breaks away if the effort rises faster than the threshold
    if above >= -ROUNDING * size and more == 0.0:
        low = RESOLUTION * h
        later = direction * value(u, low) - _threshold_after(driven, laws, state, direction, low)
        if later > above and later > 0.0:
            return 0.0, True
    for _ in range(MAX_HALVINGS):
        high = min(low + width, h)
        width = high - low
        least = _threshold_after(driven, laws, state, direction, low) + more
        end = direction * value(u, high)
        if max(direction * value(u, low), end) + 0.125 * bound * width * width < least:
            if high >= h:
                return h, False
            low = high
            width = 2.0 * width
        elif width <= RESOLUTION * h:
            if end >= _threshold_after(driven, laws, state, direction, high) + more:
                return _crossing(driven, laws, state, direction, u, low, high, more), True
            if high >= h:
                return h, False
            low = high
            width = 2.0 * width
        else:
            width *= 0.5
    return low, False


@kernel
def rest_piece(
    driven: DrivenBody,
    laws: ExtendedLaws,
    state: Vector,
    t: float,
    longest: float,
    refused: float,
    piece: Vector,
) -> tuple[float, float]:
    """Return the duration [s] of a rest, and the direction of the breakaway that ends it (0: none).

    `motion_pieces.rest_piece` describes the parameters.
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
        size = body[fb.BREAKAWAY + side(direction)] + gross(state, t, drive)
        more = TRACE * size if direction == refused else 0.0
        proven, leaves = _first_breakaway(
            driven, laws, state, direction, piece[3], spent, more, size
        )
        if leaves or proven < spent:
            towards = direction if leaves else 0.0
        spent = proven
    return spent, towards


@inner_kernel
def _field(
    driven: DrivenBody, laws: ExtendedLaws, state: Vector, t: float, y: Vector, out: Vector
) -> None:
    force, drive = driven.force, driven.drive
    lag = laws[2][LAG]
    w = y[3] if lag > 0.0 else y[1]
    out[0] = y[1]
    out[1] = (
        effort(t, y[0], y[1], y[2], drive) - slip_friction(force, laws, state, y[0], y[1], w)
    ) / driven.body[fb.MASS]
    out[2] = y[0] - reference(t, drive)
    out[3] = (y[1] - w) / lag if lag > 0.0 else 0.0


@inner_kernel
def _step_error(h: float, slopes: Vector) -> float:
    return max(
        local_error(1, h, slopes), max(local_error(3, h, slopes), local_error(0, h, slopes) / h)
    )


@kernel
def slip_piece(
    driven: DrivenBody,
    laws: ExtendedLaws,
    state: Vector,
    t: float,
    longest: float,
    pace: Vector,
    slopes: Vector,
    piece: Vector,
) -> tuple[float, int]:
    """Integrate a slip with a lubricant film over one step; return its length [s] and a status.

    - pace (3,): as in `motion_pieces.layer_piece`
    - slopes (7, 4): derivatives at the step's stages
    """
    body, drive = driven.body, driven.drive
    mass = body[fb.MASS]
    y = np.empty(ROWS)
    point = np.empty(ROWS)
    y[0] = state[0]
    y[1] = state[1]
    y[2] = state[2]
    y[3] = state[FILM]
    _field(driven, laws, state, t, y, slopes[0])
    size = gross(state, t, drive)
    if y[1] == 0.0 and abs(slopes[0, 1]) * mass <= ROUNDING * (
        size + body[fb.BREAKAWAY + side(state[fb.DIRECTION])]
    ):
        slopes[0, 1] = 0.0
    if pace[0] == 0.0:
        largest = body[fb.BREAKAWAY] + body[fb.BREAKAWAY + 1] + size
        pace[0] = FIRST_STEP * body[fb.SPEED_SCALE] * mass / largest if largest > 0.0 else longest
        pace[1] = 0.0
        pace[2] = t
    wish = pace[0]
    cut = pace[0] > longest
    h = min(wish, longest)
    shortest = SHORTEST_STEP * max(abs(t), longest)
    allowed = body[fb.TOLERANCE] * max(
        FLOOR * body[fb.SPEED_SCALE], abs(y[1]), abs(slopes[0, 1]) * (t - pace[2])
    )
    while True:
        for i in range(1, dp.STAGES):
            stage_point(i, h, y, slopes, point)
            _field(driven, laws, state, t + dp.NODES[i] * h, point, slopes[i])
        error = _step_error(h, slopes) / allowed
        if error <= 1.0:
            lengthen(pace, h, wish if cut else 0.0, error)
            dense_output(y, slopes.T, h, piece)
            return h, OK
        if h <= shortest:
            return h, STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        cut = False
        h *= shortening(error)
