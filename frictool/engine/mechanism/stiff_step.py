"""Implicit integration step for a mechanism with a stiff link, by a Rosenbrock method of order 4.

The method is RODAS of engine/rosenbrock.py, with a dense Jacobian J:

    W k_i = f(t + c_i h, y + sum_j A_ij k_j) + sum_j C_ij k_j/h + h d_i f_t
    W = I/(gamma h) - J

J is computed by differences, without the springs and dampers of the links. The derivatives of the
spring and damper forces are added analytically, because difference quotients of these large forces
would be inaccurate. The work of the elements is integrated with the same stages. The method is
L-stable: after the deflection of a stiff, damped link has settled, only the motion limits the step
length.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import state as st
from frictool.engine.mechanism.address_calls import FLOAT, INTEGER, call_by_address, function_type
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.articulated_body import field
from frictool.engine.mechanism.dormand_prince8 import AFTER
from frictool.engine.mechanism.efforts import coupling_stretch
from frictool.engine.mechanism.mode_guards import BROKEN
from frictool.engine.mechanism.sources import is_steady
from frictool.engine.mechanism.state import MechanismState, RateEvaluation
from frictool.engine.mechanism.weighted_sums import BUMPS, on_path
from frictool.engine.rosenbrock import DENSE, GAMMA, IN_TIME, NODES, STAGES, A, C
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import IntVector, Vector

SLOW = 0.1  # smallest reference speed of the relative tolerance, in units of the speed scale
PLACE_TIME = 1e-2  # s, tolerance of a position divided by the tolerance of a speed
NUDGE = 1e-7  # difference of a state for the Jacobian, relative to the state
TIME_NUDGE = 1e-3  # difference of time for the derivative by time, relative to the step
ROUNDING = 2e-15  # rounding error of a stretch, relative to the positions of its ends
SINGULAR = 1e-300  # replacement of a pivot that is 0
NO_SPRING = 1e-30  # factor of a spring that does not count, so that guards do not divide by 0
LOOKS = 4  # parts of a step at whose ends guards of forces are checked


@bare_kernel
def _nudge(k: IntVector, p: Vector, y: Vector, modes: IntVector, j: int) -> float:
    """Return the increment of state j for the Jacobian's difference quotients.

    The increment does not reverse a slip.
    """
    n = k[ly.BLOCKS]
    if j >= 2 * n:
        size = ly.inner_size(k, p, j - 2 * n)
        return float(10.0 * NUDGE * max(size, abs(y[j]))) if math.isfinite(size) else 0.0
    block = j if j < n else j - n
    scale = PLACE_TIME * ly.speed_scale(k, p, block)
    size = NUDGE * max(abs(y[j]), scale if j < n else SLOW * ly.speed_scale(k, p, block))
    sign = 1.0
    if j >= n:
        sign = float(modes[block]) if abs(modes[block]) == 1 else math.copysign(1.0, y[j])
    return float(size * sign)


@bare_kernel
def _set_springs(k: IntVector, p: Vector, springs: Vector, restore: bool) -> None:
    """Make stiffness and damping of all couplings negligible, or restore them.

    `springs` (c, 2) contains the values between the two calls: a call with `restore` False writes
    the array, a call with `restore` True reads it.
    """
    for c in range(k[ly.COUPLINGS]):
        at = ly.coupling_row(k, c) + ly.STIFFNESS
        if restore:
            p[at], p[at + 1] = springs[c, 0], springs[c, 1]
        else:
            springs[c, 0], springs[c, 1] = p[at], p[at + 1]
            p[at], p[at + 1] = NO_SPRING * p[at], NO_SPRING * p[at + 1]


@bare_kernel
def _differences(
    machine: CompiledMechanism,
    state: MechanismState,
    t: float,
    jacobian: Vector,
    of_work: Vector,
    springs: Vector,
) -> int:
    """Fill the Jacobian of rates and powers with respect to the state.

    The stiffness and the damping of the links are left out.
    """
    k, p = machine.whole, machine.numbers
    y, modes, workspace = state.y, state.modes, state.workspace
    inputs, point = workspace.lines[st.INPUTS], workspace.lines[st.POINT]
    s, e = y.shape[0], state.work.shape[0]
    base = RateEvaluation(
        workspace.slopes[2], workspace.w, workspace.lines[st.TRIAL], workspace.powers[2]
    )
    out = RateEvaluation(
        workspace.slopes[1], workspace.w, workspace.lines[st.TRIAL], workspace.powers[1]
    )
    _set_springs(k, p, springs, False)
    failed = field(machine, t, y, modes, inputs, base)
    for j in range(s):
        point[j] = y[j]
    for j in range(s):
        nudge = _nudge(k, p, y, modes, j)
        if nudge == 0.0:
            continue
        point[j] = y[j] + nudge
        nudge = point[j] - y[j]
        failed += field(machine, t, point, modes, inputs, out)
        for i in range(s):
            jacobian[i, j] = (out.rates[i] - base.rates[i]) / nudge
        for i in range(e):
            of_work[i, j] = (out.power[i] - base.power[i]) / nudge
        point[j] = y[j]
    _set_springs(k, p, springs, True)
    return failed


@bare_kernel
def _add_springs(
    machine: CompiledMechanism,
    state: MechanismState,
    t: float,
    jacobian: Vector,
    of_work: Vector,
) -> int:
    """Add the derivatives of the spring and damper forces of each coupling, as outer products.

    Each outer product has two vectors. One vector is the response of rates and powers to a force in
    the link. The other vector is the derivative of this force with respect to the state. A common
    motion of both ends therefore changes no force, up to rounding.
    """
    k, p = machine.whole, machine.numbers
    y, modes, workspace = state.y, state.modes, state.workspace
    inputs = workspace.lines[st.INPUTS]
    n, u = k[ly.BLOCKS], k[ly.SOURCES]
    s, e = y.shape[0], state.work.shape[0]
    flanks = n + 2 * k[ly.JOINTS]
    at = u + n + k[ly.JOINTS]
    out = RateEvaluation(
        workspace.slopes[1], workspace.w, workspace.lines[st.TRIAL], workspace.powers[1]
    )
    failed = 0
    for c in range(k[ly.COUPLINGS]):
        row = ly.coupling_row(k, c)
        gap = ly.gap(p, row)
        if gap > 0.0 and modes[flanks + c] == st.OPEN:
            continue
        a, b = ly.coupling_a(k, c), ly.coupling_b(k, c)
        ratio, stiffness, damping = ly.ratio(p, row), ly.stiffness(p, row), ly.damping(p, row)
        e_c, rate = coupling_stretch(k, p, c, y)
        if gap > 0.0:
            e_c -= modes[flanks + c] * gap
        force = -(stiffness * e_c + damping * rate)
        share = 0.0  # loss at end a per force in the link
        if a >= 0 and modes[a] != st.STUCK:
            forward = (force * ratio > 0.0) == (modes[a] > 0)
            share = ly.drive_loss(p, row) if forward else ly.back_loss(p, row)
            share *= math.copysign(1.0, force) * (1.0 if modes[a] > 0 else -1.0)
        push = abs(force) + ly.mass_of(k, p, b) * ly.speed_scale(k, p, b)
        if push == 0.0:
            push = 1.0
        before_b, before_a = inputs[2 * u + b], 0.0
        inputs[2 * u + b] += push
        if a >= 0:
            before_a = inputs[2 * u + a]
            inputs[2 * u + a] -= (ratio + share) * push
        failed += field(machine, t, y, modes, inputs, out)
        inputs[2 * u + b] = before_b
        if a >= 0:
            inputs[2 * u + a] = before_a
        for end in range(2):
            block, along = (b, 1.0) if end == 0 else (a, -ratio)
            if block < 0:
                continue
            for i in range(s):
                response = (out.rates[i] - workspace.slopes[0, i]) / push
                jacobian[i, block] -= response * (stiffness * along)
                jacobian[i, n + block] -= response * (damping * along)
            for i in range(e):
                if u <= i < u + n:
                    continue
                response = (out.power[i] - workspace.powers[0, i]) / push
                of_work[i, block] -= response * (stiffness * along)
                of_work[i, n + block] -= response * (damping * along)
            speed = y[n + a] if a >= 0 else 0.0
            of_work[at + c, block] -= share * speed * stiffness * along
            of_work[at + c, n + block] += (2.0 * damping * rate - share * speed * damping) * along
        if a >= 0:
            of_work[at + c, n + a] += share * force
    return failed


@bare_kernel
def _factorise(w: Vector, pivots: IntVector) -> None:
    s = w.shape[0]
    for j in range(s):
        best = j
        for i in range(j + 1, s):
            if abs(w[i, j]) > abs(w[best, j]):
                best = i
        pivots[j] = best
        if w[best, j] == 0.0:  # the step is then rejected, because its result is not finite
            w[best, j] = SINGULAR
        if best != j:
            for column in range(s):
                w[j, column], w[best, column] = w[best, column], w[j, column]
        for i in range(j + 1, s):
            if w[i, j] != 0.0:
                w[i, j] /= w[j, j]
                for column in range(j + 1, s):
                    w[i, column] -= w[i, j] * w[j, column]


@bare_kernel
def _solve(w: Vector, pivots: IntVector, x: Vector) -> None:
    s = w.shape[0]
    for j in range(s):
        best = pivots[j]
        if best != j:
            x[j], x[best] = x[best], x[j]
    for j in range(s):
        for i in range(j + 1, s):
            x[i] -= w[i, j] * x[j]
    for j in range(s - 1, -1, -1):
        x[j] /= w[j, j]
        for i in range(j):
            x[i] -= w[i, j] * x[j]


@bare_kernel
def _rounding_errors(k: IntVector, p: Vector, y: Vector, jacobian: Vector, floor: Vector) -> None:
    """Fill `floor` (n,) with the speed error that the rounding of each link's stretch causes."""
    n = k[ly.BLOCKS]
    for i in range(n):
        floor[i] = 0.0
    for c in range(k[ly.COUPLINGS]):
        row = ly.coupling_row(k, c)
        a, b = ly.coupling_a(k, c), ly.coupling_b(k, c)
        size = abs(y[b]) + abs(ly.offset(p, row))
        if a >= 0:
            size += abs(ly.ratio(p, row) * y[a])
            root = ly.group_of(k, a)
            speed = ROUNDING * size / abs(ly.ratio(p, row)) * math.sqrt(abs(jacobian[n + a, a]))
            floor[root] = max(floor[root], speed / abs(ly.group_ratio(k, p, a)))
        root = ly.group_of(k, b)
        speed = ROUNDING * size * math.sqrt(abs(jacobian[n + b, b]))
        floor[root] = max(floor[root], speed / abs(ly.group_ratio(k, p, b)))


@bare_kernel
def _relative_error(
    k: IntVector,
    p: Vector,
    modes: IntVector,
    end: Vector,
    errors: Vector,
    floor: Vector,
    tolerance: float,
) -> float:
    n = k[ly.BLOCKS]
    worst = 0.0
    for i in range(n):
        if modes[i] != st.STUCK:
            size = tolerance * max(SLOW * ly.speed_scale(k, p, i), abs(end[n + i]))
            size += floor[ly.group_of(k, i)] * abs(ly.group_ratio(k, p, i))
            worst = max(worst, max(abs(errors[i]) / PLACE_TIME, abs(errors[n + i])) / size)
    for i in range(k[ly.INNER]):
        worst = max(worst, abs(errors[2 * n + i]) / (tolerance * ly.inner_size(k, p, i)))
    return worst


@bare_kernel
def _energy_scale(k: IntVector, p: Vector, end: Vector) -> float:
    energy = 0.0
    for i in range(k[ly.BLOCKS]):
        speed = max(SLOW * ly.speed_scale(k, p, i), abs(end[k[ly.BLOCKS] + i]))
        energy += ly.mass_of(k, p, i) * speed * speed
    return energy


@bare_kernel
def _fill_path(stages: Vector, gain: Vector, path: Vector) -> None:
    for row in range(BUMPS):
        for i in range(path.shape[1]):
            path[row, i] = 0.0
    for i in range(path.shape[1]):
        path[0, i] = gain[i]
        for j in range(STAGES - 1):
            path[1, i] += DENSE[0, j] * stages[j, i]
            path[2, i] += DENSE[1, j] * stages[j, i]


@bare_kernel
def _sum_before(stages: Vector, weights: Vector, i: int, base: Vector, out: Vector) -> None:
    for row in range(stages.shape[1]):
        total = base[row]
        for j in range(i):
            total += weights[i, j] * stages[j, row]
        out[row] = total


@kernel
def rosenbrock_step(
    machine: CompiledMechanism,
    state: MechanismState,
    t: float,
    h: float,
    tolerance: float,
    watching: int,
) -> float:
    """Try an implicit step, with the arguments of `integration_step.try_step`.

    Returns error/tolerance, inf if the rates cannot be evaluated. The row SPENT contains the work
    of the step. If the step is accepted, the rows from PATH on contain the dense output. The first
    `watching` guards of the row WATCHED are checked at 1/4, 1/2 and 3/4 of the step: THIRD[0] is
    the first of these fractions at which a guard is passed. THIRD[0] is 1 if no guard is passed, or
    if the step is rejected.
    """
    k, p = machine.whole, machine.numbers
    y, modes, workspace = state.y, state.modes, state.workspace
    s, e = y.shape[0], state.work.shape[0]
    inputs, end, point = (
        workspace.lines[st.INPUTS],
        workspace.lines[st.END],
        workspace.lines[st.POINT],
    )
    rates, power = workspace.slopes[1], workspace.powers[1]
    out = RateEvaluation(rates, workspace.w, workspace.lines[st.TRIAL], power)
    jacobian, of_work = np.zeros((s, s)), np.zeros((e, s))
    springs = np.empty((k[ly.COUPLINGS], 2))
    failed = _differences(machine, state, t, jacobian, of_work, springs)
    failed += _add_springs(machine, state, t, jacobian, of_work)
    in_time, work_in_time = np.zeros(s), np.zeros(e)
    if not is_steady(k, inputs):
        ahead = TIME_NUDGE * h
        for side in (1.0, -1.0):
            failed += field(machine, t + side * ahead, y, modes, inputs, out)
            for i in range(s):
                in_time[i] += side * rates[i] / (2.0 * ahead)
            for i in range(e):
                work_in_time[i] += side * power[i] / (2.0 * ahead)
    w, pivots = np.empty((s, s)), np.empty(s, dtype=np.int64)
    for i in range(s):
        for j in range(s):
            w[i, j] = -jacobian[i, j]
        w[i, i] += 1.0 / (GAMMA * h)
    _factorise(w, pivots)
    stages, works = np.zeros((STAGES, s)), np.zeros((STAGES, e))
    nothing = np.zeros(e)
    right = np.empty(s)
    for i in range(s):
        rates[i] = workspace.slopes[0, i]
    for i in range(e):
        power[i] = workspace.powers[0, i]
    for stage in range(STAGES):
        if stage > 0:
            _sum_before(stages, A, stage, y, point)
            failed += field(machine, t + NODES[stage] * h, point, modes, inputs, out)
        for i in range(s):
            total = rates[i] + h * IN_TIME[stage] * in_time[i]
            for j in range(stage):
                total += C[stage, j] / h * stages[j, i]
            right[i] = total
        _solve(w, pivots, right)
        for i in range(s):
            stages[stage, i] = right[i]
        for i in range(e):
            total = power[i] + h * IN_TIME[stage] * work_in_time[i]
            for j in range(stage):
                total += C[stage, j] / h * works[j, i]
            for j in range(s):
                total += of_work[i, j] * right[j]
            works[stage, i] = GAMMA * h * total
    _sum_before(stages, A, STAGES - 1, y, end)
    spent = workspace.lines[st.SPENT]
    _sum_before(works, A, STAGES - 1, nothing, spent)
    for i in range(e):
        spent[i] += works[STAGES - 1, i]
    gain = np.empty(s)
    total = 0.0
    for i in range(s):
        end[i] += stages[STAGES - 1, i]
        gain[i] = end[i] - y[i]
        total += end[i]
    floor = np.empty(k[ly.BLOCKS])
    _rounding_errors(k, p, y, jacobian, floor)
    error = _relative_error(k, p, modes, end, stages[STAGES - 1], floor, tolerance)
    worst = 0.0
    for i in range(e):
        worst = max(worst, abs(works[STAGES - 1, i]))
    error = max(error, worst / (tolerance * _energy_scale(k, p, end)))
    workspace.lines[st.THIRD][0] = 1.0
    if failed != 0 or not math.isfinite(total + error):
        return math.inf
    if error > 1.0:
        return error
    _fill_path(stages, gain, workspace.slopes[st.PATH :])
    _fill_path(works, spent, workspace.powers[st.PATH :])
    if watching > 0:
        for part in range(1, LOOKS):
            on_path(part / LOOKS, workspace.slopes[st.PATH :], point)
            for i in range(s):
                point[i] += y[i]
            failed += field(machine, t + part / LOOKS * h, point, modes, inputs, out)
            for index in range(watching):
                if out.guard[workspace.integers[st.WATCHED, index]] < BROKEN:
                    workspace.lines[st.THIRD][0] = min(workspace.lines[st.THIRD][0], part / LOOKS)
    out = RateEvaluation(
        workspace.slopes[AFTER], workspace.w, workspace.lines[st.TRIAL], workspace.powers[AFTER]
    )
    failed += field(machine, t + h, end, modes, inputs, out)
    for i in range(s):
        total += out.rates[i]
    return error if failed == 0 and math.isfinite(total) else math.inf


ROSENBROCK_STEP = function_type(FLOAT, ly.MACHINE, st.STATE, FLOAT, FLOAT, FLOAT, INTEGER)
_rosenbrock_step = call_by_address(ROSENBROCK_STEP)


@bare_kernel
def stiff_step(
    machine: CompiledMechanism,
    state: MechanismState,
    t: float,
    h: float,
    tolerance: float,
    watching: int,
) -> tuple[float, float]:
    """Try an implicit step; return error/tolerance and the fraction at which a guard is passed."""
    address = machine.laws[machine.laws.shape[0] - 1, ly.STIFF_STEP]
    error: float = _rosenbrock_step(address, machine, state, t, h, tolerance, watching)
    return error, state.workspace.lines[st.THIRD][0]


@bare_kernel
def add_effort_changes(k: IntVector, p: Vector, state: MechanismState) -> None:
    """Add the absolute change of each coupling's spring effort in a step to `state.pace`.

    The row END contains the state at the end of the step. Rounding errors of the stretch increase
    the sum.
    """
    y, end = state.y, state.workspace.lines[st.END]
    for c in range(k[ly.COUPLINGS]):
        row = ly.coupling_row(k, c)
        before, _ = coupling_stretch(k, p, c, y)
        after, _ = coupling_stretch(k, p, c, end)
        state.pace[st.SWINGS + c] += ly.stiffness(p, row) * abs(after - before)
