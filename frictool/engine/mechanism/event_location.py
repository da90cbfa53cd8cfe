"""Location of the first instant within a step at which a guard falls to its limit.

A guard (mode_guards.py) that is below its limit is called passed.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.dormand_prince8 import AFTER
from frictool.engine.mechanism.integration_step import look, trace
from frictool.engine.mechanism.mode_guards import (
    BROKEN,
    distance_to_guard,
    is_any_broken,
    is_broken,
    is_forced,
)
from frictool.engine.mechanism.state import (
    AT_HIGH,
    AT_LOW,
    END,
    GUARD,
    PATH,
    RATES_HIGH,
    RATES_LOW,
    SPENT,
    TRIAL,
    Y_HIGH,
    Y_LOW,
    MechanismState,
    Workspace,
)
from frictool.engine.mechanism.weighted_sums import on_path
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

ROUNDS = 200  # largest number of iterations of the search
# zero of a cubic: largest number of iterations; change in the last iteration, relative to the step
NEWTON = 60
NEAR = 1e-15
# value of a guard at the located instant: AT_END for a speed or a position, BEYOND for a force; the
# mode ends because BEYOND is below BROKEN
AT_END, BEYOND = -0.5, -2.0
FAR = -4.0  # lowest value of a force's guard at the located instant
NEAREST = 4e-16  # distance below which instants are treated as one, relative to the time


@bare_kernel
def _is_there(
    k: IntVector,
    p: Vector,
    y: Vector,
    modes: IntVector,
    guard: Vector,
    begin: Vector,
    index: int,
    count: int,
) -> bool:
    if is_forced(k, modes, index):
        if not FAR <= guard[index] < BROKEN:
            return False
    else:
        if not BROKEN <= guard[index] <= 0.0:
            return False
        if index >= k[ly.BLOCKS] and distance_to_guard(k, p, index, y, y, modes)[1] >= 0.0:
            return False
    for other in range(count):
        if guard[other] < (FAR if is_forced(k, modes, other) else BROKEN) and is_broken(
            k, p, other, y, modes, guard, begin
        ):
            return False
    return True


@bare_kernel
def _crossing(g0: float, r0: float, g1: float, r1: float, h: float) -> float:
    slope = (g1 - g0) / h
    a = (r0 + r1 - 2.0 * slope) / (h * h)
    b = (3.0 * slope - 2.0 * r0 - r1) / h
    low = 0.0
    high = h
    for step in range(8):
        s = h * (8 - step) / 8.0
        if g0 + s * (r0 + s * (b + s * a)) > 0.0:
            low = s
            break
        high = s
    s = 0.5 * (low + high)
    for _ in range(NEWTON):
        value = g0 + s * (r0 + s * (b + s * a))
        rate = r0 + s * (2.0 * b + s * 3.0 * a)
        low, high = (s, high) if value > 0.0 else (low, s)
        after = s - value / rate if rate != 0.0 else low
        if not low < after < high:
            after = 0.5 * (low + high)
        if abs(after - s) <= NEAR * h:
            return after
        s = after
    return s


@bare_kernel
def _has_rate(k: IntVector, modes: IntVector, index: int) -> bool:
    return not is_forced(k, modes, index) or index >= k[ly.BLOCKS] + 2 * k[ly.JOINTS]


@bare_kernel
def _smooth_crossing(
    k: IntVector,
    p: Vector,
    index: int,
    aim: float,
    modes: IntVector,
    workspace: Workspace,
    low: float,
    high: float,
) -> float:
    g1, r1 = distance_to_guard(
        k, p, index, workspace.lines[Y_HIGH], workspace.lines[RATES_HIGH], modes
    )
    g0, r0 = distance_to_guard(
        k, p, index, workspace.lines[Y_LOW], workspace.lines[RATES_LOW], modes
    )
    past = aim * g1 / workspace.lines[AT_HIGH][index]
    return low + _crossing(g0 - past, r0, g1 - past, r1, high - low)


@bare_kernel
def _keep(
    count: int,
    y: Vector,
    rates: Vector,
    guard: Vector,
    y_kept: Vector,
    rates_kept: Vector,
    kept: Vector,
) -> None:
    for i in range(rates.shape[0]):
        y_kept[i], rates_kept[i] = y[i], rates[i]
    for index in range(count):
        kept[index] = guard[index]


@bare_kernel
def _keep_low(count: int, y: Vector, rates: Vector, guard: Vector, workspace: Workspace) -> None:
    _keep(
        count,
        y,
        rates,
        guard,
        workspace.lines[Y_LOW],
        workspace.lines[RATES_LOW],
        workspace.lines[AT_LOW],
    )


@bare_kernel
def _keep_high(count: int, workspace: Workspace) -> None:
    kept = workspace.lines[Y_HIGH], workspace.lines[RATES_HIGH], workspace.lines[AT_HIGH]
    _keep(
        count,
        workspace.lines[END],
        workspace.slopes[AFTER],
        workspace.lines[TRIAL],
        kept[0],
        kept[1],
        kept[2],
    )


@bare_kernel
def _first(
    k: IntVector,
    p: Vector,
    modes: IntVector,
    workspace: Workspace,
    low: float,
    high: float,
    lead: int,
    weights: tuple[float, float],
) -> tuple[float, int]:
    at = high
    leader = -1
    at_low = workspace.lines[AT_LOW]
    at_high = workspace.lines[AT_HIGH]
    for index in range(k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS] + k[ly.STOPS]):
        if not is_broken(
            k, p, index, workspace.lines[Y_HIGH], modes, at_high, workspace.lines[GUARD]
        ):
            continue
        if _has_rate(k, modes, index):
            aim = BEYOND if is_forced(k, modes, index) else AT_END
            root = _smooth_crossing(k, p, index, aim, modes, workspace, low, high)
        else:
            g0, g1 = at_low[index] - BEYOND, at_high[index] - BEYOND
            if not math.isfinite(g0):
                g0 = abs(g1)
            if index == lead:
                g0, g1 = g0 * weights[0], g1 * weights[1]
            root = low + (high - low) * max(g0, 0.0) / (max(g0, 0.0) - min(g1, -1e-3))
        if root < at or leader < 0:
            at, leader = root, index
    return at, leader


@part_kernel
def locate(
    machine: CompiledMechanism, state: MechanismState, t: float, h: float
) -> tuple[float, bool]:
    """Shorten a step of length h to the first instant at which a guard is passed (a mode ends).

    Before the call, row GUARD of the workspace contains the guards at the beginning of the step.
    Row TRIAL contains the guards at the end, where at least one guard must be passed. The search is
    a bracketed root search on the step's dense output. Afterwards the rows END, AFTER, TRIAL and
    SPENT contain the results of the shortened step. Returns the new length, and True if the rates
    could not be evaluated.

    """
    k, p, _ = machine
    y, modes, workspace = state.y, state.modes, state.workspace
    count = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS] + k[ly.STOPS]
    end, after, trial = workspace.lines[END], workspace.slopes[AFTER], workspace.lines[TRIAL]
    low, high, lead, weights, kept = 0.0, h, -1, (1.0, 1.0), 0
    _keep_low(count, y, workspace.slopes[0], workspace.lines[GUARD], workspace)
    _keep_high(count, workspace)
    if not trace(machine, state, t, h):
        return h, True
    for attempt in range(ROUNDS):
        at, leader = _first(k, p, modes, workspace, low, high, lead, weights)
        if leader != lead:
            weights, kept, lead = (1.0, 1.0), 0, leader
        if lead < 0 or high - low <= NEAREST * max(t, 1e-6):
            at = high
        elif attempt % 4 == 3 or not low < at < high:
            at = 0.5 * (low + high)
            if not low < at < high:
                at = high
        if not look(machine, state, t, h, at):
            return at, True
        if at == high or _is_there(k, p, end, modes, trial, workspace.lines[GUARD], lead, count):
            on_path(at / h, workspace.powers[PATH:], workspace.lines[SPENT])
            return at, False
        if is_any_broken(k, p, end, modes, trial, workspace.lines[GUARD]):
            high, weights, kept = at, (weights[0] * 0.5 if kept == 1 else 1.0, 1.0), 1
            _keep_high(count, workspace)
        else:
            low, weights, kept = at, (1.0, weights[1] * 0.5 if kept == -1 else 1.0), -1
            _keep_low(count, end, after, trial, workspace)
    return high, True
