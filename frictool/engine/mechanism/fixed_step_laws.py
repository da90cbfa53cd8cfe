"""Laws with a fixed time step T_e: hybrid A, B, C (thesis 3.28-3.39), and laws with a rest band.

Thesis (2.32) and (2.35) define the laws with a rest band, which treat low velocities as rest. The
input of each law is an effort u on its block. u is the sum of the efforts of all other elements on
the blocks that move with this block, reflected to this block by the joints. The mode is updated at
the beginning of each step T_e and constant within the step; the motion within the step is
integrated as usual. Several laws with a fixed step may act on one tree of joints. The friction of
each law is then subtracted from the effort u of the laws that follow. While the friction of a
static law keeps a tree at rest, the laws with a fixed step in this tree are inactive.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import law_kernels as lk
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.curves import curve_value
from frictool.engine.mechanism.state import OPEN, STUCK, MechanismState, RateEvaluation
from frictool.engine.mechanism.workspace_rows import FORCE, GROSS, INERTIA, NEED, ON_BLOCK
from frictool.friction.static_kernels import sticking_force
from frictool.friction.status_codes import OK
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

HELD, SLIPS = 0, 1  # modes of a law


@bare_kernel
def _root_of(k: IntVector, p: Vector, modes: IntVector, block: int) -> tuple[int, float]:
    n = k[ly.BLOCKS]
    i = block
    along = 1.0
    while ly.joint_of(k, i) >= 0 and modes[n + ly.joint_of(k, i)] != OPEN:
        ratio = ly.ratio(p, ly.joint_row(k, ly.joint_of(k, i)))
        along *= ratio if ly.outward(k, i) == 1 else 1.0 / ratio
        i = ly.parent_of(k, i)
    return i, along


@bare_kernel
def _first_mode(k: IntVector) -> int:
    return int(k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS] + k[ly.STOPS])


@part_kernel
def timed_frictions(
    machine: CompiledMechanism, y: Vector, modes: IntVector, out: RateEvaluation, whole: bool
) -> int:
    """Subtract the friction of fixed-step laws from row FORCE; fill the rates of their states.

    The row NEED must contain values without the friction of fixed-step laws. Returns a status of
    friction/status_codes.py.
    """
    k, p, laws = machine
    rates, w, power = out.rates, out.w, out.power
    n = k[ly.BLOCKS]
    status = OK
    first = _first_mode(k)
    at = k[ly.SOURCES] + n + k[ly.JOINTS] + k[ly.COUPLINGS]
    for f in range(k[ly.FRICTIONS]):
        row = ly.friction_row(k, f)
        kind = ly.kind(k, row)
        block = ly.block(k, row)
        mode = modes[first + f]
        if kind < lk.HYBRID:
            continue
        values = p[ly.law_values(k, row)]
        begin, end = 2 * n + k[row + ly.FIRST_INNER], 2 * n + k[row + ly.INNER_END]
        level = 1.0 if ly.level(k, row) < 0 else curve_value(k, p, ly.level(k, row), y[block])
        root, along = _root_of(k, p, modes, block)
        v = y[n + block]
        u = -w[NEED, root] / (along * level)
        mass = w[INERTIA, root] / (along * along)
        friction = 0.0
        w[ON_BLOCK, block] = u
        if kind == lk.HYBRID:
            status += lk.hybrid_rate(laws[f, 4], mode, v, y[begin:end], values, rates[begin:end])
        if modes[root] != STUCK:
            if kind == lk.HYBRID and mode == HELD:
                friction = level * u - mass * lk.hybrid_acceleration(
                    laws[f, 3], mode, v, u, y[begin:end], values
                )
            elif kind == lk.HYBRID:
                friction = level * lk.hybrid_force(laws[f, 2], mode, v, u, y[begin:end], values)
            elif mode == HELD:
                friction = level * sticking_force(
                    u, lk.breakaway(laws[f, 1], 1.0, values), lk.breakaway(laws[f, 1], -1.0, values)
                )
            else:
                friction = level * lk.slip_force(laws[f, 0], v, math.copysign(1.0, v), values)
        w[FORCE, block] -= friction
        if whole:
            w[GROSS, block] += abs(friction)
        w[NEED, root] += friction * along
        power[at + f] = friction * v
    return status


@part_kernel
def seen_speeds(machine: CompiledMechanism, y: Vector, modes: IntVector, rates: Vector) -> None:
    """Set the rates of positions to 0 while a law with a rest band reports velocity 0.

    This applies to all blocks that move with the block of the law.
    """
    k, p, laws = machine
    n = k[ly.BLOCKS]
    for f in range(k[ly.FRICTIONS]):
        row = ly.friction_row(k, f)
        if ly.kind(k, row) != lk.BANDED:
            continue
        values = p[ly.law_values(k, row)]
        v = y[n + ly.block(k, row)]
        if lk.seen_velocity(laws[f, 3], v, values) == v:
            continue
        root, _ = _root_of(k, p, modes, ly.block(k, row))
        for i in range(n):
            if _root_of(k, p, modes, i)[0] == root:
                rates[i] = 0.0


@part_kernel
def switch(machine: CompiledMechanism, state: MechanismState) -> int:
    """Set the modes of fixed-step laws from the last efforts on the blocks; return a status."""
    k, p, laws = machine
    y = state.y
    modes = state.modes
    w = state.workspace.w
    n = k[ly.BLOCKS]
    status = OK
    first = _first_mode(k)
    for f in range(k[ly.FRICTIONS]):
        row = ly.friction_row(k, f)
        kind = ly.kind(k, row)
        block = ly.block(k, row)
        mode = modes[first + f]
        values = p[ly.law_values(k, row)]
        v = y[n + block]
        u = w[ON_BLOCK, block]
        if kind == lk.BANDED:
            modes[first + f] = HELD if abs(v) <= lk.band(laws[f, 2], values) else SLIPS
        elif kind == lk.HYBRID:
            z = y[ly.inner_states(k, row)]
            after = lk.mode_after(laws[f, 0], mode, v, u, z, values)
            if after != mode:
                modes[first + f] = after
                status += lk.enter(laws[f, 1], after, v, u, z, values)
    return status


@part_kernel
def keep(machine: CompiledMechanism, state: MechanismState) -> int:
    """Update the memories of hybrid laws after a step; return a status code."""
    k, p, laws = machine
    y, modes = state.y, state.modes
    status = OK
    first = _first_mode(k)
    for f in range(k[ly.FRICTIONS]):
        row = ly.friction_row(k, f)
        if ly.kind(k, row) == lk.HYBRID:
            values = p[ly.law_values(k, row)]
            z = y[ly.inner_states(k, row)]
            status += lk.hybrid_commit(laws[f, 5], modes[first + f], z, values)
    return status
