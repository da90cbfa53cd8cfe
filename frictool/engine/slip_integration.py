"""Integration of a slip with a load or nonlinear friction, by Dormand-Prince with error control.

    y' = w        w' = (d (K i(t) - offset - load(x)) - F_c(x) - (F_s - F_c)(x) exp(-|w/v_s|^delta)
                  - added - viscous w)/J    x = x0 + d y

Here d is the direction of motion, y the distance from the initial position x0, and w >= 0 the
speed. K is the effort per unit of the drive i, J the inertia, F_c the Coulomb friction and F_s the
breakaway. The viscous friction is added + viscous w, with coefficients that depend on the speed
range of w. i(t) is an exponential, and the load (plant/position_load.py) depends on the position.
While the motor moves inside the backlash, the Coulomb friction of the backlash replaces all other
friction.

A slip ends at a limit of its speed range or of the Stribeck layer, at an end stop, or when the
backlash closes. A slip also ends at an end of the range in which polynomials describe the friction
over position. These events are located as roots of the dense output. Between two events, all
derivatives are smooth.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.engine import dormand_prince as dp
from frictool.engine.axis_friction import (
    breakaway_at,
    coulomb_at,
    has_stribeck,
    next_boundary,
    speed_band,
    straight_line,
)
from frictool.engine.dormand_prince import dense_output, fill_row
from frictool.engine.drive_lag import lagged_drive
from frictool.engine.polynomial_events import NEVER
from frictool.engine.slip_events import sooner
from frictool.friction.stribeck import curve
from frictool.plant import axis as ax
from frictool.plant.axis_friction_laws import LAYER, STRIBECK_EXPONENT, STRIBECK_VELOCITY
from frictool.plant.position_load import load_size, opposing_effort
from frictool.runtime.kernels import inner_kernel, kernel
from frictool.typing import Vector

# reasons for the end of a step or a slip
HELD, SLOWER, FASTER, PLACE, FAILED, CONTACT = 0, 1, 2, 3, 4, 5

TOLERANCE = 1e-12  # tolerance of the speed, relative to the speed or its change within a step
FLOOR = 2.0**-5  # smallest reference speed of the tolerance in the layer, in units of v_s
FIRST_STEP = 2.0  # first step, relative to the time in which all efforts together would reach v_s
# largest effort that is treated as zero at the start of a slip, relative to its terms
ROUNDING = 2.0**-46
GROWTH, SHRINKAGE, SAFETY = 5.0, 0.2, 0.9
SHORTEST_STEP = 2.0**-50  # shortest step, relative to the remaining time
MAX_STEPS = 1_000_000
# rows of the dense output; the third row is not used here
DISTANCE, SPEED, ROWS, TERMS = 0, 1, 3, 5
DRIVING = 5  # index in `law`: 1 if the motor moves the load, 0 if it moves inside the backlash


class _Slip(NamedTuple):
    """Slip under a constant command.

    law (6,): values for friction/stribeck.py, followed by 1 if the motor moves the load, else 0.
    line: (c, b) of the viscous friction c + b w at the speed w.
    """

    state: Vector
    command: float
    p: Vector
    direction: float
    law: Vector
    line: tuple[float, float]


@inner_kernel
def _acceleration(slip: _Slip, t: float, y: float, w: float) -> float:
    state, command, p, direction, law, line = slip
    x = state[ax.POSITION] + direction * y
    if law[DRIVING] > 0.0:
        friction = coulomb_at(p, direction, x)
        if has_stribeck(p) and w < p[LAYER]:
            law[0] = friction
            law[1] = breakaway_at(p, direction, x, state[ax.RESTED])
            friction = curve(w, law)
    else:
        friction = p[ax.BACKLASH_COULOMB]
    effort = direction * (
        p[ax.CONSTANT] * lagged_drive(state[ax.DRIVE], command, p[ax.LAG], t)
        - opposing_effort(p, x)
    )
    return float((effort - friction - line[0] - line[1] * w) / p[ax.INERTIA])


@inner_kernel
def _step(slip: _Slip, t: float, h: float, start: float, at: Vector, slopes: Vector) -> float:
    y = at[DISTANCE]
    w1 = at[SPEED]
    a1 = start
    w2 = w1 + h * dp.A21 * a1
    a2 = _acceleration(slip, t + dp.C2 * h, y + h * dp.A21 * w1, w2)
    w3 = w1 + h * (dp.A31 * a1 + dp.A32 * a2)
    a3 = _acceleration(slip, t + dp.C3 * h, y + h * (dp.A31 * w1 + dp.A32 * w2), w3)
    w4 = w1 + h * (dp.A41 * a1 + dp.A42 * a2 + dp.A43 * a3)
    a4 = _acceleration(slip, t + dp.C4 * h, y + h * (dp.A41 * w1 + dp.A42 * w2 + dp.A43 * w3), w4)
    w5 = w1 + h * (dp.A51 * a1 + dp.A52 * a2 + dp.A53 * a3 + dp.A54 * a4)
    y5 = y + h * (dp.A51 * w1 + dp.A52 * w2 + dp.A53 * w3 + dp.A54 * w4)
    a5 = _acceleration(slip, t + dp.C5 * h, y5, w5)
    w6 = w1 + h * (dp.A61 * a1 + dp.A62 * a2 + dp.A63 * a3 + dp.A64 * a4 + dp.A65 * a5)
    y6 = y + h * (dp.A61 * w1 + dp.A62 * w2 + dp.A63 * w3 + dp.A64 * w4 + dp.A65 * w5)
    a6 = _acceleration(slip, t + h, y6, w6)
    w7 = w1 + h * (dp.A71 * a1 + dp.A73 * a3 + dp.A74 * a4 + dp.A75 * a5 + dp.A76 * a6)
    y7 = y + h * (dp.A71 * w1 + dp.A73 * w3 + dp.A74 * w4 + dp.A75 * w5 + dp.A76 * w6)
    a7 = _acceleration(slip, t + h, y7, w7)
    fill_row(slopes[DISTANCE], (w1, w2, w3, w4, w5, w6, w7))
    fill_row(slopes[SPEED], (a1, a2, a3, a4, a5, a6, a7))
    return abs(h * (dp.E1 * a1 + dp.E3 * a3 + dp.E4 * a4 + dp.E5 * a5 + dp.E6 * a6 + dp.E7 * a7))


@inner_kernel
def _end_of(
    piece: Vector, h: float, lower: float, upper: float, length: float, probe: Vector
) -> tuple[float, int]:
    spent, kind = h, HELD
    crossing = sooner(piece, TERMS, SPEED, 1.0, lower, spent, probe)
    if crossing != NEVER:
        spent, kind = crossing, SLOWER
    if upper < math.inf:
        crossing = sooner(piece, TERMS, SPEED, -1.0, upper, spent, probe)
        if crossing != NEVER:
            spent, kind = crossing, FASTER
    if length < math.inf:
        crossing = sooner(piece, TERMS, DISTANCE, -1.0, length, spent, probe)
        if crossing != NEVER:
            spent, kind = crossing, PLACE
    return spent, kind


@inner_kernel
def _move(at: Vector, piece: Vector, spent: float) -> None:
    for row in range(2):
        total = 0.0
        for k in range(TERMS - 1, -1, -1):
            total = total * spent + piece[row, k]
        at[row] = total


@kernel
def _gross(state: Vector, command: float, p: Vector, direction: float, driving: bool) -> float:
    held = (
        breakaway_at(p, direction, state[ax.POSITION], state[ax.RESTED])
        if driving
        else p[ax.BACKLASH_BREAKAWAY]
    )
    drive = abs(p[ax.CONSTANT]) * (abs(command) + abs(state[ax.DRIVE]))
    return float(drive + abs(p[ax.OFFSET]) + held + load_size(p, state[ax.POSITION]))


@kernel
def curved_slip(
    state: Vector, command: float, p: Vector, direction: float, remaining: float, to_edge: float
) -> tuple[float, float, float, int]:
    """Integrate a slip for up to `remaining` [s] from `state`, which is not changed.

    The slip ends at a limit of `speed_band` or at the `next_boundary`. to_edge [rad | m]: distance
    after which the backlash closes; <= 0 if the backlash is closed. Returns duration [s], distance
    [rad | m], final speed [rad/s | m/s], and the cause of the end: HELD (no event within
    `remaining`), SLOWER or FASTER (lower or upper limit of the speed), PLACE (boundary), CONTACT
    (backlash closes) or FAILED (no accurate step).
    """
    at = np.zeros(ROWS)
    slopes = np.zeros((ROWS, dp.STAGES))
    piece = np.empty((ROWS, TERMS))
    probe = np.empty(TERMS)
    law = np.array([0.0, 0.0, p[STRIBECK_VELOCITY], p[STRIBECK_EXPONENT], 0.0, 1.0])
    at[SPEED] = abs(state[ax.VELOCITY])
    length = next_boundary(p, state[ax.POSITION], direction)[0]
    kind_of_end = PLACE
    if to_edge > 0.0:
        law[DRIVING] = 0.0
        layered, line, (lower, upper) = False, (0.0, 0.0), (0.0, math.inf)
        if to_edge <= length:
            length, kind_of_end = to_edge, CONTACT
    else:
        layered = at[SPEED] < p[LAYER]
        line, (lower, upper) = straight_line(p, direction, at[SPEED]), speed_band(p, at[SPEED])
    if length <= 0.0:
        return 0.0, 0.0, at[SPEED], kind_of_end
    gross = _gross(state, command, p, direction, to_edge <= 0.0) / p[ax.INERTIA]
    slip = _Slip(state, command, p, direction, law, line)
    start = _acceleration(slip, 0.0, 0.0, at[SPEED])
    if at[SPEED] == 0.0 and abs(start) <= ROUNDING * gross:
        start = 0.0
    wish = FIRST_STEP * p[STRIBECK_VELOCITY] / gross if layered and gross > 0.0 else remaining
    t = 0.0
    shortest = SHORTEST_STEP * remaining
    for _ in range(MAX_STEPS):
        h = min(wish, remaining - t)
        error = _step(slip, t, h, start, at, slopes)
        allowed = TOLERANCE * max(at[SPEED], FLOOR * p[STRIBECK_VELOCITY] if layered else gross * h)
        if not error <= allowed:
            if h <= shortest:
                break
            wish = h * (
                max(SHRINKAGE, SAFETY * (allowed / error) ** 0.2)
                if math.isfinite(error)
                else SHRINKAGE
            )
            continue
        dense_output(at, slopes, h, piece)
        spent, kind = _end_of(piece, h, lower, upper, length, probe)
        kind = kind_of_end if kind == PLACE else kind
        _move(at, piece, spent)
        t = t + spent if spent < remaining - t else remaining
        if kind != HELD or t >= remaining:
            return t, at[DISTANCE], max(0.0, at[SPEED]), kind
        start = slopes[SPEED, dp.STAGES - 1]
        grown = h * min(GROWTH, SAFETY * (allowed / error) ** 0.2) if error > 0.0 else h * GROWTH
        wish = max(grown, wish if h < wish else 0.0)
    return t, at[DISTANCE], max(0.0, at[SPEED]), FAILED
