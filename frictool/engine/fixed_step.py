"""Laws that are printed for a fixed step, run as they are printed: hybrid A, B, C (3.28)-(3.39), and the laws with a band (2.32), (2.35).

The step T_e is a parameter of these models and not a tolerance: (3.11) ties it to their switching velocity. Each step is one of the
midpoint rule with the mode held; the mode is asked for at its start. x' is the velocity that the law reports (Karnopp's v_m is 0 in
the band), and so is what the drive's derivative gain sees.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from frictool.engine.body import (
    BREAKS_AWAY,
    SAMPLE_EFFORT,
    SAMPLE_FRICTION,
    SAMPLE_MODE,
    SAMPLE_POSITION,
    SAMPLE_VELOCITY,
    STOPS,
)
from frictool.engine.drive import effort, reference
from frictool.engine.status import EVENTS_FULL, LAW_FAILED, NOT_FINITE, OK
from frictool.friction.hybrid import STUCK
from frictool.friction.static import held_force
from frictool.kernels import kernel

Vector = NDArray[np.float64]
ModeAfter = Callable[[int, float, float, Vector, Vector], int]
Enter = Callable[[int, float, float, Vector, Vector], int]
Valued = Callable[[int, float, float, Vector, Vector], float]
Rate = Callable[[int, float, Vector, Vector, Vector], int]
Commit = Callable[[int, Vector, Vector], int]
SlipForce = Callable[[float, float, Vector], float]
OfDirection = Callable[[float, Vector], float]
Band = Callable[[Vector], float]


@kernel
def _switch(events: Vector, happened: int, t: float, stuck: bool, x: float, v: float) -> int:
    """Records that the body has stuck or broken away; returns the number of events, or -1 where there is no room."""
    if happened == events.shape[0]:
        return -1
    row = events[happened]
    row[0], row[1], row[2], row[3] = t, STOPS if stuck else BREAKS_AWAY, x, v
    return happened + 1


@kernel
def _put(row: Vector, x: float, v: float, u: float, friction: float, stuck: bool) -> None:
    """One sample; the mode is the direction of slip, 0 in stick."""
    row[SAMPLE_POSITION], row[SAMPLE_VELOCITY], row[SAMPLE_EFFORT], row[SAMPLE_FRICTION] = x, v, u, friction
    row[SAMPLE_MODE] = 0.0 if stuck else math.copysign(1.0, v if v != 0.0 else u)


@kernel
def run_hybrid(
    mode_after: ModeAfter,
    enter: Enter,
    force: Valued,
    acceleration: Valued,
    rate: Rate,
    commit: Commit,
    law: Vector,
    z: Vector,
    state: Vector,
    start: float,
    step: float,
    ends: Vector,
    drives: Vector,
    times: Vector,
    samples: Vector,
    events: Vector,
) -> tuple[int, float, int]:
    """Moves state = (x, v, q) and z, in place, from stick at `start` [s] to ends[-1] in steps of `step` [s].

    ends (s,), drives (s, 10): a step takes the drive that holds at its middle. times (n,), ascending: samples (n, 5) are those of the
    step that begins nearest. events (m, 4). Returns a status of engine/status.py, the time reached, the number of events.
    """
    steps, segment, filled, happened, mode = round((ends[-1] - start) / step), 0, 0, 0, STUCK
    slope, middle = np.zeros_like(z), np.zeros_like(z)
    for k in range(steps + 1):
        t, x, v, q = start + k * step, state[0], state[1], state[2]
        while segment + 1 < ends.shape[0] and t + 0.5 * step >= ends[segment]:
            segment += 1
        u = effort(t, x, v, q, drives[segment])
        after = mode_after(mode, v, u, z, law)
        if after != mode:
            mode, happened = after, _switch(events, happened, t, after == STUCK, x, v)
            if happened < 0:
                return EVENTS_FULL, t, events.shape[0]
            if enter(mode, v, u, z, law) != OK:
                return LAW_FAILED, t, happened
        while filled < times.shape[0] and times[filled] < t + 0.5 * step:
            _put(samples[filled], x, v, u, force(mode, v, u, z, law), mode == STUCK)
            filled += 1
        if k == steps:
            break
        failed = rate(mode, v, z, law, slope)
        half = v + 0.5 * step * acceleration(mode, v, u, z, law)
        middle[:] = z + 0.5 * step * slope
        there, over = x + 0.5 * step * v, q + 0.5 * step * (x - reference(t, drives[segment]))
        u = effort(t + 0.5 * step, there, half, over, drives[segment])
        failed += rate(mode, half, middle, law, slope)
        state[0], state[1] = x + step * half, v + step * acceleration(mode, half, u, middle, law)
        state[2] = q + step * (there - reference(t + 0.5 * step, drives[segment]))
        z += step * slope
        if failed + commit(mode, z, law) != OK:
            return LAW_FAILED, t, happened
        if not math.isfinite(state[1]):
            return NOT_FINITE, t, happened
    return OK, ends[-1], happened


@kernel
def _band_force(slip_force: SlipForce, breakaway: OfDirection, law: Vector, width: float, v: float, u: float) -> float:
    """The friction of a law with a band."""
    if abs(v) <= width:
        return held_force(u, breakaway(1.0, law), breakaway(-1.0, law))
    return slip_force(v, math.copysign(1.0, v), law)


@kernel
def run_band(
    slip_force: SlipForce,
    breakaway: OfDirection,
    band: Band,
    seen_velocity: OfDirection,
    law: Vector,
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
    """As `run_hybrid`, for a law whose velocities of at most `band` count as rest (2.32), (2.35)-(2.36)."""
    steps, segment, filled, happened, stuck = round((ends[-1] - start) / step), 0, 0, 0, True
    width = band(law)
    for k in range(steps + 1):
        t, x, v, q = start + k * step, state[0], state[1], state[2]
        while segment + 1 < ends.shape[0] and t + 0.5 * step >= ends[segment]:
            segment += 1
        seen = seen_velocity(v, law)
        u = effort(t, x, seen, q, drives[segment])
        if (abs(v) <= width) != stuck:
            stuck, happened = not stuck, _switch(events, happened, t, not stuck, x, v)
            if happened < 0:
                return EVENTS_FULL, t, events.shape[0]
        friction = _band_force(slip_force, breakaway, law, width, v, u)
        while filled < times.shape[0] and times[filled] < t + 0.5 * step:
            _put(samples[filled], x, seen, u, friction, stuck)
            filled += 1
        if k == steps:
            break
        half = v + 0.5 * step * (u - friction) / mass
        there, over = x + 0.5 * step * seen, q + 0.5 * step * (x - reference(t, drives[segment]))
        seen = seen_velocity(half, law)
        u = effort(t + 0.5 * step, there, seen, over, drives[segment])
        state[0], state[1] = x + step * seen, v + step * (u - _band_force(slip_force, breakaway, law, width, half, u)) / mass
        state[2] = q + step * (there - reference(t + 0.5 * step, drives[segment]))
        if not math.isfinite(state[1]):
            return NOT_FINITE, t, happened
    return OK, ends[-1], happened
