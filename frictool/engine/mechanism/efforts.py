"""The efforts on each block that are functions of the state: sources, held efforts, couplings, pushes, friction in slip.

Rows of the work array `w`, a column for each block: FORCE, all that is known; GROSS, the sum of its terms' sizes, which rounding is
relative to; HOLD_LOW <= 0 <= HOLD_HIGH, what friction on a block at rest can hold; DRIVEN, the sources' effort alone.
`power` gets what each element does or takes, in the order of engine/mechanism/state.py.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.curves import curve_value
from frictool.engine.mechanism.image import (
    BACK_LOSS,
    BLOCK,
    BLOCKS,
    BREAKAWAY_RATIO,
    COEFFICIENT,
    CONSTANT,
    COUPLING,
    COUPLING_ENDS,
    COUPLING_WIDTH,
    COUPLINGS,
    DAMPING,
    DRIVE_LOSS,
    FIRST_INNER,
    FRICTION_PLACES,
    FRICTION_WIDTH,
    FRICTIONS,
    GAP,
    INNER_END,
    JOINTS,
    KIND,
    LAG,
    LAW_VALUES,
    LEVEL,
    OFFSET,
    PRESSING,
    PRESSING_PLACES,
    PRESSINGS,
    PUSH,
    PUSH_PLACES,
    PUSHES,
    RATIO,
    SOURCE,
    SOURCE_BLOCKS,
    SOURCE_WIDTH,
    SOURCES,
    STIFFNESS,
    VALUES,
    VALUES_END,
)
from frictool.engine.mechanism.laws import DYNAMIC, EXACT, breakaway, rate, slip_force
from frictool.engine.mechanism.laws import force as force_of
from frictool.engine.mechanism.state import OPEN, STUCK
from frictool.friction.status import OK
from frictool.kernels import bare_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

FORCE, GROSS, HOLD_LOW, HOLD_HIGH, DRIVEN = range(5)
STIFF_MARGIN = 1e-10  # of a gap: a flank is passed when it is passed by this much


@bare_kernel
def drive_at(k: Places, p: Vector, source: int, t: float, inputs: Vector) -> float:
    """What flows t after the command was given. inputs: commands, what flowed at the beginning (u,) each, efforts on blocks (n,)."""
    lag = p[k[SOURCE] + source * SOURCE_WIDTH + LAG]
    target, before = inputs[source], inputs[k[SOURCES] + source]
    return target if lag == 0.0 else target + (before - target) * math.exp(-t / lag)


@bare_kernel
def _driving(k: Places, p: Vector, t: float, y: Vector, inputs: Vector, w: Vector, power: Vector) -> None:
    n, u = k[BLOCKS], k[SOURCES]
    for i in range(n):
        held = inputs[2 * u + i]
        w[FORCE, i], w[GROSS, i] = held, abs(held)
        w[HOLD_LOW, i], w[HOLD_HIGH, i], w[DRIVEN, i] = 0.0, 0.0, 0.0
        power[u + i] = held * y[n + i]
    for s in range(u):
        block = k[k[SOURCE_BLOCKS] + s]
        effort = p[k[SOURCE] + s * SOURCE_WIDTH + CONSTANT] * drive_at(k, p, s, t, inputs)
        w[FORCE, block] += effort
        w[GROSS, block] += abs(effort)
        w[DRIVEN, block] += effort
        power[s] = effort * y[n + block]
    for q in range(k[PUSHES]):
        block, curve = k[k[PUSH_PLACES] + 2 * q], k[k[PUSH_PLACES] + 2 * q + 1]
        effort = p[k[PUSH] + q]
        if curve >= 0:
            effort += curve_value(k, p, curve, y[block])
        w[FORCE, block] += effort
        w[GROSS, block] += abs(effort)


@bare_kernel
def coupling_stretch(k: Places, p: Vector, coupling: int, y: Vector) -> tuple[float, float]:
    """e = q_b - ratio q_a - offset, and e'."""
    n, row, ends = k[BLOCKS], k[COUPLING] + coupling * COUPLING_WIDTH, k[COUPLING_ENDS] + 3 * coupling
    a, b = k[ends], k[ends + 1]
    e, rate = y[b] - p[row + OFFSET], y[n + b]
    if a >= 0:
        e -= p[row + RATIO] * y[a]
        rate -= p[row + RATIO] * y[n + a]
    return e, rate


@bare_kernel
def _couplings(k: Places, p: Vector, y: Vector, modes: Places, w: Vector, guard: Vector, power: Vector) -> None:
    """Compliant links; the guard of one with a gap is above -1 while its flanks stay as their mode says."""
    n, flanks, checks = k[BLOCKS], k[BLOCKS] + 2 * k[JOINTS], k[BLOCKS] + 2 * k[JOINTS]
    at = k[SOURCES] + n + k[JOINTS]
    for c in range(k[COUPLINGS]):
        row, ends = k[COUPLING] + c * COUPLING_WIDTH, k[COUPLING_ENDS] + 3 * c
        a, b, curve, gap = k[ends], k[ends + 1], k[ends + 2], p[row + GAP]
        stiffness, damping, mode = p[row + STIFFNESS], p[row + DAMPING], modes[flanks + c]
        e, rate = coupling_stretch(k, p, c, y)
        guard[checks + c] = math.inf
        power[at + c] = 0.0
        if gap > 0.0:
            side = -1.0 if e < 0.0 else 1.0
            if mode != OPEN:
                side = float(mode)
            beyond = side * e - gap
            pressed = stiffness * beyond + side * damping * rate
            slack = STIFF_MARGIN * (0.5 * stiffness * gap) + 1e-11 * damping * abs(rate)
            if mode == OPEN:
                guard[checks + c] = -min(beyond / (STIFF_MARGIN * gap), pressed / slack)
                continue
            guard[checks + c] = pressed / slack
            e = side * beyond
        force = -(stiffness * e + damping * rate)
        if curve >= 0:
            force -= curve_value(k, p, curve, e)
        size = abs(stiffness * e) + abs(damping * rate)
        power[at + c] = damping * rate * rate
        w[FORCE, b] += force
        w[GROSS, b] += size
        if a < 0:
            continue
        ratio, speed = p[row + RATIO], y[n + a]
        w[FORCE, a] -= ratio * force
        w[GROSS, a] += abs(ratio) * size
        drive, back = p[row + DRIVE_LOSS], p[row + BACK_LOSS]
        if drive != 0.0 or back != 0.0:
            ahead = (drive if force * ratio > 0.0 else back) * abs(force)
            behind = (back if force * ratio > 0.0 else drive) * abs(force)
            if modes[a] == STUCK:
                w[HOLD_HIGH, a] += ahead
                w[HOLD_LOW, a] -= behind
            else:
                loss = ahead if modes[a] > 0 else -behind
                w[FORCE, a] -= loss
                power[at + c] += loss * speed


@bare_kernel
def _frictions(k: Places, p: Vector, laws: Places, y: Vector, modes: Places, out: Vector, w: Vector, power: Vector) -> int:
    n, status = k[BLOCKS], OK
    at = k[SOURCES] + n + k[JOINTS] + k[COUPLINGS]
    for f in range(k[FRICTIONS]):
        row = k[FRICTION_PLACES] + f * FRICTION_WIDTH
        block, kind = k[row + BLOCK], k[row + KIND]
        values = p[k[LAW_VALUES] + k[row + VALUES] : k[LAW_VALUES] + k[row + VALUES_END]]
        level = 1.0 if k[row + LEVEL] < 0 else curve_value(k, p, k[row + LEVEL], y[block])
        v, motion, force = y[n + block], modes[block], 0.0
        if kind == EXACT:
            if motion == STUCK:
                held = level * breakaway(laws[f, 1], 1.0, values)
                w[HOLD_HIGH, block] += held
                w[HOLD_LOW, block] -= level * breakaway(laws[f, 1], -1.0, values)
                w[GROSS, block] += held
            else:
                force = level * slip_force(laws[f, 0], v, float(motion), values)
        elif kind == DYNAMIC:
            first, end = 2 * n + k[row + FIRST_INNER], 2 * n + k[row + INNER_END]
            status += rate(laws[f, 0], y[first:end], v, values, out[first:end])
            force = level * force_of(laws[f, 1], y[first:end], out[first:end], v, values)
        else:
            force = level * slip_force(laws[f, 0], v, math.copysign(1.0, v), values)
        w[FORCE, block] -= force
        w[GROSS, block] += abs(force)
        power[at + f] = force * v
    at += k[FRICTIONS]
    for s in range(k[PRESSINGS]):
        block = k[k[PRESSING_PLACES] + 2 * s]
        row, motion = k[PRESSING] + 2 * s, modes[block]
        friction = p[row + COEFFICIENT] * max(0.0, curve_value(k, p, k[k[PRESSING_PLACES] + 2 * s + 1], y[block]))
        power[at + s] = 0.0
        if motion == STUCK:
            w[HOLD_HIGH, block] += p[row + BREAKAWAY_RATIO] * friction
            w[HOLD_LOW, block] -= p[row + BREAKAWAY_RATIO] * friction
        else:
            w[FORCE, block] -= motion * friction
            power[at + s] = motion * friction * y[n + block]
        w[GROSS, block] += friction
    return status


@part_kernel
def all_efforts(
    k: Places,
    p: Vector,
    laws: Places,
    t: float,
    y: Vector,
    modes: Places,
    inputs: Vector,
    out: Vector,
    w: Vector,
    guard: Vector,
    power: Vector,
) -> int:
    """Fills the rows of w, the rates of inner states in `out`, the guards of flanks, and what elements do; returns friction/status.py."""
    _driving(k, p, t, y, inputs, w, power)
    _couplings(k, p, y, modes, w, guard, power)
    return _frictions(k, p, laws, y, modes, out, w, power)
