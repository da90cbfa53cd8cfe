"""Efforts on each block as functions of the state: sources, external efforts, couplings, frictions.

workspace_rows.py defines the rows FORCE, GROSS, HOLD_LOW, HOLD_HIGH and DRIVEN of the work array
`w`. `power` contains the power that each element delivers or absorbs, in the order of
engine/mechanism/state.py.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.curves import curve_value
from frictool.engine.mechanism.law_kernels import (
    DYNAMIC,
    EXACT,
    SMOOTH,
    breakaway,
    rate,
    slip_force,
)
from frictool.engine.mechanism.law_kernels import force as force_of
from frictool.engine.mechanism.sources import flowing_at
from frictool.engine.mechanism.state import OPEN, STUCK, RateEvaluation
from frictool.engine.mechanism.workspace_rows import DRIVEN, FORCE, GROSS, HOLD_HIGH, HOLD_LOW
from frictool.friction.status_codes import OK
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

STIFF_MARGIN = 1e-10  # tolerance of the contact of a compliant flank, relative to the gap


@bare_kernel
def _driving(
    k: IntVector, p: Vector, t: float, y: Vector, inputs: Vector, out: RateEvaluation, whole: bool
) -> None:
    w, power = out.w, out.power
    n, u = k[ly.BLOCKS], k[ly.SOURCES]
    for i in range(n):
        held = inputs[2 * u + i]
        w[FORCE, i] = held
        if whole:
            w[GROSS, i] = abs(held)
        w[HOLD_LOW, i], w[HOLD_HIGH, i], w[DRIVEN, i] = 0.0, 0.0, 0.0
        power[u + i] = held * y[n + i]
    for s in range(u):
        block = ly.source_block(k, s)
        effort = ly.constant(p, ly.source_row(k, s)) * flowing_at(k, p, s, t, inputs)
        w[FORCE, block] += effort
        if whole:
            w[GROSS, block] += abs(effort)
        w[DRIVEN, block] += effort
        power[s] = effort * y[n + block]
    for q in range(k[ly.PUSHES]):
        block, curve = ly.push_block(k, q), ly.push_curve(k, q)
        effort = ly.push_of(k, p, q)
        if curve >= 0:
            effort += curve_value(k, p, curve, y[block])
        w[FORCE, block] += effort
        if whole:
            w[GROSS, block] += abs(effort)


@bare_kernel
def coupling_stretch(k: IntVector, p: Vector, coupling: int, y: Vector) -> tuple[float, float]:
    """Return the stretch e = q_b - ratio q_a - offset of a compliant link, and its rate e'.

    q_a and q_b are the positions of the blocks a and b of the link.
    """
    n = k[ly.BLOCKS]
    row = ly.coupling_row(k, coupling)
    a, b = ly.coupling_a(k, coupling), ly.coupling_b(k, coupling)
    e = y[b] - ly.offset(p, row)
    rate = y[n + b]
    if a >= 0:
        e -= ly.ratio(p, row) * y[a]
        rate -= ly.ratio(p, row) * y[n + a]
    return e, rate


@bare_kernel
def _at_flank(
    e: float,
    rate: float,
    gap: float,
    stiffness: float,
    damping: float,
    mode: int,
    guard: Vector,
    index: int,
) -> tuple[float, bool]:
    side = -1.0 if e < 0.0 else 1.0
    if mode != OPEN:
        side = float(mode)
    beyond = side * e - gap
    pressed = stiffness * beyond + side * damping * rate
    slack = STIFF_MARGIN * (0.5 * stiffness * gap) + 1e-11 * damping * abs(rate)
    if mode == OPEN:
        guard[index] = -min(beyond / (STIFF_MARGIN * gap), pressed / slack)
        return 0.0, False
    guard[index] = pressed / slack
    return side * beyond, True


@bare_kernel
def _couplings(
    k: IntVector, p: Vector, y: Vector, modes: IntVector, out: RateEvaluation, whole: bool
) -> None:
    w, guard, power = out.w, out.guard, out.power
    n = k[ly.BLOCKS]
    flanks = k[ly.BLOCKS] + 2 * k[ly.JOINTS]
    at = k[ly.SOURCES] + n + k[ly.JOINTS]
    row = k[ly.COUPLING]
    ends = k[ly.COUPLING_ENDS]
    for c in range(k[ly.COUPLINGS]):
        a = k[ends]
        b = k[ends + 1]
        curve = k[ends + 2]
        ratio = ly.ratio(p, row)
        gap = ly.gap(p, row)
        stiffness = ly.stiffness(p, row)
        damping = ly.damping(p, row)
        drive, back = ly.drive_loss(p, row), ly.back_loss(p, row)
        e = y[b] - ly.offset(p, row)
        rate = y[n + b]
        row = row + ly.COUPLING_WIDTH
        ends = ends + 3
        if a >= 0:
            e -= ratio * y[a]
            rate -= ratio * y[n + a]
        if gap > 0.0:
            e, pressed = _at_flank(
                e, rate, gap, stiffness, damping, modes[flanks + c], guard, flanks + c
            )
            if not pressed:
                power[at + c] = 0.0
                continue
        force = -(stiffness * e + damping * rate)
        if curve >= 0:
            force -= curve_value(k, p, curve, e)
        size = abs(stiffness * e) + abs(damping * rate)
        lost = damping * rate * rate
        w[FORCE, b] += force
        if whole:
            w[GROSS, b] += size
        if a >= 0:
            w[FORCE, a] -= ratio * force
            if whole:
                w[GROSS, a] += abs(ratio) * size
            if drive != 0.0 or back != 0.0:
                ahead = (drive if force * ratio > 0.0 else back) * abs(force)
                behind = (back if force * ratio > 0.0 else drive) * abs(force)
                if modes[a] == STUCK:
                    w[HOLD_HIGH, a] += ahead
                    w[HOLD_LOW, a] -= behind
                else:
                    loss = ahead if modes[a] > 0 else -behind
                    w[FORCE, a] -= loss
                    lost += loss * y[n + a]
        power[at + c] = lost


@bare_kernel
def _frictions(
    machine: CompiledMechanism, y: Vector, modes: IntVector, out: RateEvaluation, whole: bool
) -> int:
    k, p, laws = machine
    rates, w, power = out.rates, out.w, out.power
    n = k[ly.BLOCKS]
    status = OK
    at = k[ly.SOURCES] + n + k[ly.JOINTS] + k[ly.COUPLINGS]
    row = k[ly.FRICTION_INDICES]
    first_value = k[ly.LAW_VALUES]
    for f in range(k[ly.FRICTIONS]):
        block, kind, curve = ly.block(k, row), ly.kind(k, row), ly.level(k, row)
        values = p[first_value + k[row + ly.VALUES] : first_value + k[row + ly.VALUES_END]]
        v = y[n + block]
        motion = modes[block]
        force = 0.0
        level = 1.0
        if curve >= 0:
            level = curve_value(k, p, curve, y[block])
        if kind == EXACT and motion == STUCK:
            held = level * breakaway(laws[f, 1], 1.0, values)
            w[HOLD_HIGH, block] += held
            w[HOLD_LOW, block] -= level * breakaway(laws[f, 1], -1.0, values)
            if whole:
                w[GROSS, block] += held
        elif kind == EXACT and ly.straight(k, row) > 0:
            force = level * (motion * values[0] + values[ly.straight(k, row)] * v)
        elif kind == EXACT:
            force = level * slip_force(laws[f, 0], v, float(motion), values)
        elif kind == DYNAMIC:
            first, end = 2 * n + k[row + ly.FIRST_INNER], 2 * n + k[row + ly.INNER_END]
            status += rate(laws[f, 0], y[first:end], v, values, rates[first:end])
            force = level * force_of(laws[f, 1], y[first:end], rates[first:end], v, values)
        elif kind == SMOOTH:
            force = level * slip_force(laws[f, 0], v, math.copysign(1.0, v), values)
        row += ly.FRICTION_WIDTH
        w[FORCE, block] -= force
        if whole:
            w[GROSS, block] += abs(force)
        power[at + f] = force * v
    return status


@bare_kernel
def _pressings(
    k: IntVector, p: Vector, y: Vector, modes: IntVector, out: RateEvaluation, whole: bool
) -> None:
    w, power = out.w, out.power
    n = k[ly.BLOCKS]
    at = k[ly.SOURCES] + k[ly.BLOCKS] + k[ly.JOINTS] + k[ly.COUPLINGS] + k[ly.FRICTIONS]
    for s in range(k[ly.PRESSINGS]):
        block = ly.pressing_block(k, s)
        row = ly.pressing_row(k, s)
        motion = modes[block]
        friction = ly.coefficient(p, row) * max(
            0.0, curve_value(k, p, ly.pressing_curve(k, s), y[block])
        )
        power[at + s] = 0.0
        if motion == STUCK:
            w[HOLD_HIGH, block] += ly.breakaway_ratio(p, row) * friction
            w[HOLD_LOW, block] -= ly.breakaway_ratio(p, row) * friction
        else:
            w[FORCE, block] -= motion * friction
            power[at + s] = motion * friction * y[n + block]
        if whole:
            w[GROSS, block] += friction


@bare_kernel
def efforts(
    machine: CompiledMechanism,
    t: float,
    y: Vector,
    modes: IntVector,
    inputs: Vector,
    out: RateEvaluation,
    whole: bool,
) -> int:
    """Fill the efforts on each block in `out.w`, and the other arrays of `out`.

    The module docstring names the rows of `out.w`. The other arrays are the rates of the internal
    states of friction laws, the guards of flanks, and the powers. Returns a status of
    friction/status_codes.py.
    """
    k, p, _ = machine
    _driving(k, p, t, y, inputs, out, whole)
    _couplings(k, p, y, modes, out, whole)
    _pressings(k, p, y, modes, out, whole)
    return _frictions(machine, y, modes, out, whole)


@part_kernel
def all_efforts(
    machine: CompiledMechanism,
    t: float,
    y: Vector,
    modes: IntVector,
    inputs: Vector,
    out: RateEvaluation,
) -> int:
    """Call `efforts`; also compute the results that only the ends of a step need."""
    return efforts(machine, t, y, modes, inputs, out, True)
