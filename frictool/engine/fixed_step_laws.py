"""Laws with a fixed time step: hybrid A, B, C (thesis 3.28-3.39), and laws with a rest band.

Thesis (2.32) and (2.35) define the laws with a rest band. Such a law treats velocities up to a
limit as rest. For such velocities, Karnopp's law (2.35) reports the velocity 0; the law (2.32)
reports the true velocity. The rate of the position and the drive's derivative term use the reported
velocity. The step T_e is a parameter of all these laws, not a tolerance: thesis (3.11) limits T_e
by the capture velocity. Each step uses the midpoint rule; the mode is determined at the start of
the step.

The extensions (friction/law_extension.py) are the same as in the event-driven engine; Coulomb
friction and breakaway are constant in each step. A pure delay of the film is a whole number of
steps. A film does not affect the laws with a rest band, because their friction in slip has no
Stribeck effect.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from frictool.engine import body as fb
from frictool.engine.drive import effort, reference
from frictool.engine.status_codes import EVENTS_FULL, LAW_FAILED, NOT_FINITE, OK
from frictool.friction.hybrid_kernels import MASS, SLIPPING, STUCK
from frictool.friction.law_extension import BOUNDARY, DELAY, LAG, levels, regime_table
from frictool.friction.lubricant_film import boundary_film, delayed_film, film_force, lagged_film
from frictool.friction.speed_regimes import knee_force
from frictool.friction.static_kernels import sticking_force
from frictool.friction.stribeck import BREAKAWAY, VISCOUS
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

ModeAfter = Callable[[int, float, float, Vector, Vector], int]
Enter = Callable[[int, float, float, Vector, Vector], int]
Valued = Callable[[int, float, float, Vector, Vector], float]
Rate = Callable[[int, float, Vector, Vector, Vector], int]
Commit = Callable[[int, Vector, Vector], int]
SlipForce = Callable[[float, float, Vector], float]
OfDirection = Callable[[float, Vector], float]
Band = Callable[[Vector], float]
# friction/law_extension.py: parameters of both directions, table, workspace for the current
# parameters
Laws = tuple[Vector, Vector, Vector, Vector]
DRY = 1e-300  # stands for the film speed 0, so that the film has a direction


@kernel
def _switch(events: Vector, happened: int, t: float, stuck: bool, x: float, v: float) -> int:
    if happened == events.shape[0]:
        return -1
    row = events[happened]
    row[0] = t
    row[1] = fb.STOPS if stuck else fb.BREAKS_AWAY
    row[2] = x
    row[3] = v
    return happened + 1


@kernel
def _put(row: Vector, x: float, v: float, u: float, friction: float, stuck: bool) -> None:
    row[fb.SAMPLE_POSITION] = x
    row[fb.SAMPLE_VELOCITY] = v
    row[fb.SAMPLE_EFFORT] = u
    row[fb.SAMPLE_FRICTION] = friction
    row[fb.SAMPLE_MODE] = 0.0 if stuck else math.copysign(1.0, v if v != 0.0 else u)


@kernel
def _hold(laws: Laws, x: float, v: float, u: float, stuck: bool, rested: float) -> None:
    forward, backward, table, p = laws
    if table.shape[0] > 0:
        direction = math.copysign(1.0, u if stuck or v == 0.0 else v)
        levels(forward, backward, table, x, direction, rested, p)


@kernel
def _film(laws: Laws, v: float, u: float, w: float) -> float:
    return math.copysign(max(DRY, abs(boundary_film(w, laws[2][BOUNDARY]))), v if v != 0.0 else u)


@kernel
def _hybrid_friction(
    force: Valued, mode: int, v: float, u: float, z: Vector, laws: Laws, w: float
) -> float:
    table, p = laws[2], laws[3]
    if mode == STUCK or table.shape[0] == 0:
        return force(mode, v, u, z, p)
    film = _film(laws, v, u, w)
    return film_force(force(mode, film, u, z, p), v, film, p[VISCOUS]) + knee_force(
        v, regime_table(table)
    )


@kernel
def _hybrid_acceleration(
    force: Valued,
    acceleration: Valued,
    mode: int,
    v: float,
    u: float,
    z: Vector,
    laws: Laws,
    w: float,
) -> float:
    if mode == STUCK or laws[2].shape[0] == 0:
        return acceleration(mode, v, u, z, laws[3])
    gained: float = (u - _hybrid_friction(force, mode, v, u, z, laws, w)) / laws[3][MASS]
    return gained


@kernel
def _hold_breakaway(force: Valued, u: float, z: Vector, laws: Laws, w: float) -> None:
    table, p = laws[2], laws[3]
    if table.shape[0] > 0 and table[LAG] + table[DELAY] > 0.0:
        film = _film(laws, 0.0, u, w)
        p[BREAKAWAY] = abs(film_force(force(SLIPPING, film, u, z, p), 0.0, film, p[VISCOUS]))


@kernel
def _film_after(laws: Laws, w: float, v: float, after: float, span: float) -> float:
    """Return the lubricant film's lagged velocity after `span` [s].

    w is the lagged velocity at the start. During `span`, the velocity changes linearly from v to
    `after`. A pure delay is handled between steps only. Without a film, the result is `after`.
    """
    table = laws[2]
    if table.shape[0] == 0:
        return after
    return w if table[DELAY] > 0.0 else lagged_film(w, v, after, table[LAG], span)


@kernel
def run_hybrid(
    mode_after: ModeAfter,
    enter: Enter,
    force: Valued,
    acceleration: Valued,
    rate: Rate,
    commit: Commit,
    laws: Laws,
    z: Vector,
    past: Vector,
    state: Vector,
    start: float,
    step: float,
    ends: Vector,
    drives: Vector,
    times: Vector,
    samples: Vector,
    events: Vector,
) -> tuple[int, float, int]:
    """Simulate state = (x, v, q) and z, in place, from rest at `start` [s] to ends[-1].

    x is the position, v the velocity, q the integral of the position error, and z the law's state.

    - step [s]: length of a step
    - ends (s,), drives (s, 10): the effort drives[i] acts up to ends[i] [s]; each step uses the
      effort in the middle of the step
    - times (n,): ascending
    - laws: as in `dynamic_law_motion.run_dynamic`
    - past (d + 1,): workspace for a film delay of d steps

    Fills samples (n, 5), with the values at the step start nearest to each element of `times`, and
    events (m, 4).

    Returns a status of engine/status_codes.py, the time reached, and the number of events.
    """
    steps = round((ends[-1] - start) / step)
    segment = 0
    filled = 0
    happened = 0
    mode = STUCK
    slope = np.zeros_like(z)
    middle = np.zeros_like(z)
    law = laws[3]
    rested = 0.0
    w = 0.0
    for k in range(steps + 1):
        t = start + k * step
        x = state[0]
        v = state[1]
        q = state[2]
        while segment + 1 < ends.shape[0] and t + 0.5 * step >= ends[segment]:
            segment += 1
        u = effort(t, x, v, q, drives[segment])
        if past.shape[0] > 1:
            w = delayed_film(past, v)
        _hold(laws, x, v, u, mode == STUCK, rested)
        if mode == STUCK:
            _hold_breakaway(force, u, z, laws, w)
        after = mode_after(mode, v, u, z, law)
        if after != mode:
            rested = 0.0 if after == STUCK else rested
            _hold(laws, x, v, u, mode == STUCK, rested)
            mode = after
            happened = _switch(events, happened, t, after == STUCK, x, v)
            if happened < 0:
                return EVENTS_FULL, t, events.shape[0]
            if enter(mode, v, u, z, law) != OK:
                return LAW_FAILED, t, happened
        while filled < times.shape[0] and times[filled] < t + 0.5 * step:
            _put(
                samples[filled],
                x,
                v,
                u,
                _hybrid_friction(force, mode, v, u, z, laws, w),
                mode == STUCK,
            )
            filled += 1
        if k == steps:
            break
        failed = rate(mode, v, z, law, slope)
        half = v + 0.5 * step * _hybrid_acceleration(force, acceleration, mode, v, u, z, laws, w)
        between = _film_after(laws, w, v, half, 0.5 * step)
        middle[:] = z + 0.5 * step * slope
        there = x + 0.5 * step * v
        over = q + 0.5 * step * (x - reference(t, drives[segment]))
        u = effort(t + 0.5 * step, there, half, over, drives[segment])
        failed += rate(mode, half, middle, law, slope)
        state[0] = x + step * half
        state[1] = v + step * _hybrid_acceleration(
            force, acceleration, mode, half, u, middle, laws, between
        )
        w = _film_after(laws, w, v, state[1], step)
        rested += step if mode == STUCK else 0.0
        state[2] = q + step * (there - reference(t + 0.5 * step, drives[segment]))
        z += step * slope
        if failed + commit(mode, z, law) != OK:
            return LAW_FAILED, t, happened
        if not math.isfinite(state[1]):
            return NOT_FINITE, t, happened
    return OK, ends[-1], happened


@kernel
def _band_force(
    slip_force: SlipForce,
    breakaway: OfDirection,
    laws: Laws,
    width: float,
    x: float,
    v: float,
    u: float,
    rested: float,
) -> float:
    stuck = abs(v) <= width
    table = laws[2]
    law = laws[3]
    _hold(laws, x, v, u, stuck, rested)
    if stuck:
        # at rest, friction opposes the effort, not the velocity
        return sticking_force(u, breakaway(1.0, law), breakaway(-1.0, law))
    added = knee_force(v, regime_table(table)) if table.shape[0] > 0 else 0.0
    return slip_force(v, math.copysign(1.0, v), law) + added


@kernel
def run_band(
    slip_force: SlipForce,
    breakaway: OfDirection,
    band: Band,
    seen_velocity: OfDirection,
    laws: Laws,
    mass: float,
    state: Vector,
    start: float,
    step: float,
    ends: Vector,
    drives: Vector,
    times: Vector,
    samples: Vector,
    events: Vector,
) -> tuple[int, float, int]:
    """Simulate as `run_hybrid` does, with a law that treats |velocity| <= band(p) as rest."""
    steps = round((ends[-1] - start) / step)
    segment = 0
    filled = 0
    happened = 0
    stuck = True
    law = laws[3]
    rested = 0.0
    width = band(law)
    for k in range(steps + 1):
        t = start + k * step
        x = state[0]
        v = state[1]
        q = state[2]
        while segment + 1 < ends.shape[0] and t + 0.5 * step >= ends[segment]:
            segment += 1
        seen = seen_velocity(v, law)
        u = effort(t, x, seen, q, drives[segment])
        if (abs(v) <= width) != stuck:
            stuck, happened = not stuck, _switch(events, happened, t, not stuck, x, v)
            rested = 0.0 if stuck else rested
            if happened < 0:
                return EVENTS_FULL, t, events.shape[0]
        friction = _band_force(slip_force, breakaway, laws, width, x, v, u, rested)
        while filled < times.shape[0] and times[filled] < t + 0.5 * step:
            _put(samples[filled], x, seen, u, friction, stuck)
            filled += 1
        if k == steps:
            break
        half = v + 0.5 * step * (u - friction) / mass
        there = x + 0.5 * step * seen
        over = q + 0.5 * step * (x - reference(t, drives[segment]))
        seen = seen_velocity(half, law)
        u = effort(t + 0.5 * step, there, seen, over, drives[segment])
        rested += step if stuck else 0.0
        friction = _band_force(slip_force, breakaway, laws, width, there, half, u, rested)
        state[0] = x + step * seen
        state[1] = v + step * (u - friction) / mass
        state[2] = q + step * (there - reference(t + 0.5 * step, drives[segment]))
        if not math.isfinite(state[1]):
            return NOT_FINITE, t, happened
    return OK, ends[-1], happened
