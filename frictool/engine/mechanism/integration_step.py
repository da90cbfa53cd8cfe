"""One integration step with constant modes: results at its end and at any instant within it."""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import state as st
from frictool.engine.mechanism.address_calls import (
    FLOAT,
    INDICES,
    INTEGER,
    VECTOR,
    call_by_address,
    function_type,
)
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.articulated_body import field, field_within
from frictool.engine.mechanism.dormand_prince8 import AFTER, NODES, SLOPES, STAGES
from frictool.engine.mechanism.mode_guards import BROKEN, is_forced
from frictool.engine.mechanism.state import MechanismState, RateEvaluation, Workspace
from frictool.engine.mechanism.stiff_step import PLACE_TIME, SLOW, stiff_step
from frictool.engine.mechanism.weighted_sums import on_path, path_of, stage_point, step_errors
from frictool.runtime.kernels import bare_kernel, kernel, part_kernel
from frictool.typing import IntVector, Vector


@bare_kernel
def _stages(
    machine: CompiledMechanism,
    y: Vector,
    modes: IntVector,
    workspace: Workspace,
    t: float,
    h: float,
    first: int,
    end: int,
    watching: int,
) -> float:
    point, inputs, guard = (
        workspace.lines[st.POINT],
        workspace.lines[st.INPUTS],
        workspace.lines[st.TRIAL],
    )
    failed = 0
    seen = 1.0
    watched = workspace.integers[st.WATCHED]
    for stage in range(first, end):
        stage_point(stage, h, y, workspace.slopes, point)
        failed += field_within(
            machine,
            t + NODES[stage] * h,
            point,
            modes,
            inputs,
            RateEvaluation(workspace.slopes[stage], workspace.w, guard, workspace.powers[stage]),
        )
        if NODES[stage] < seen:
            for index in range(watching):
                if guard[watched[index]] < BROKEN:
                    seen = NODES[stage]
    return seen if failed == 0 else -1.0


@kernel
def stages_of_step(
    machine: CompiledMechanism,
    y: Vector,
    modes: IntVector,
    workspace: Workspace,
    t: float,
    h: float,
    first: int,
    end: int,
    watching: int,
) -> float:
    """Compute derivatives and powers as `stages` does, from the arrays of the state."""
    return _stages(machine, y, modes, workspace, t, h, first, end, watching)


STAGES_OF_STEP = function_type(
    FLOAT, ly.MACHINE, VECTOR, INDICES, st.WORKSPACE, FLOAT, FLOAT, INTEGER, INTEGER, INTEGER
)
_stages_of_step = call_by_address(STAGES_OF_STEP)


@bare_kernel
def stages(
    machine: CompiledMechanism,
    state: MechanismState,
    t: float,
    h: float,
    first: int,
    end: int,
    watching: int,
) -> float:
    """Compute derivatives and powers at the stages first .. end - 1 of a step of length h.

    t [s]: time since the last command. Only the first `watching` guards of the row WATCHED are
    checked. Returns the fraction of the step at which the first guard is passed, 1 if none is
    passed, or -1 if a friction law fails.
    """
    address = machine.laws[machine.laws.shape[0] - 1, ly.STEP_STAGES]
    y, modes, workspace = state.y, state.modes, state.workspace
    seen: float = _stages_of_step(address, machine, y, modes, workspace, t, h, first, end, watching)
    return seen


@bare_kernel
def _watch(k: IntVector, modes: IntVector, guard: Vector, watched: IntVector) -> int:
    count = 0
    for index in range(k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]):
        if guard[index] < math.inf and is_forced(k, modes, index):
            watched[count] = index
            count += 1
    return count


@bare_kernel
def _error(k: IntVector, p: Vector, h: float, modes: IntVector, workspace: Workspace) -> float:
    n = k[ly.BLOCKS]
    worst = 0.0
    errors = workspace.lines[st.ERRORS]
    end = workspace.lines[st.END]
    step_errors(h, workspace.slopes, errors, workspace.lines[st.THIRD])
    for i in range(n):
        if modes[i] != st.STUCK:
            size = max(SLOW * ly.speed_scale(k, p, i), abs(end[n + i]))
            worst = max(worst, max(errors[i], errors[n + i] * PLACE_TIME) / (size * PLACE_TIME))
    for i in range(k[ly.INNER]):
        worst = max(worst, errors[2 * n + i] / ly.inner_size(k, p, i))
    return worst


@bare_kernel
def at_end(workspace: Workspace) -> RateEvaluation:
    """Return the arrays that receive rates, guards and powers at the end of a step."""
    return RateEvaluation(
        workspace.slopes[AFTER], workspace.w, workspace.lines[st.TRIAL], workspace.powers[AFTER]
    )


@bare_kernel
def _is_finite(end: Vector, rates: Vector) -> bool:
    total = 0.0
    for i in range(rates.shape[0]):
        total += end[i] + rates[i]
    return math.isfinite(total)


@part_kernel
def try_step(
    machine: CompiledMechanism, state: MechanismState, t: float, h: float, tolerance: float
) -> tuple[float, float]:
    """Try a step of length h from the state; t [s] is the time since the last command.

    The results for both ends of the step are in these arrays of the workspace:

                 at the start      at the end
        rates    row 0 of `slopes` row AFTER of `slopes`
        powers   row 0 of `powers` row AFTER of `powers`
        guards   row GUARD         row TRIAL
        state    `state.y`         row END

    GUARD, TRIAL and END are rows of `lines`.

    Returns two numbers: error/tolerance (inf if the rates cannot be evaluated), and the fraction of
    the step at which a guard of a force is first passed (1 without such a guard).
    """
    k, p, _ = machine
    y, modes, workspace = state.y, state.modes, state.workspace
    end = workspace.lines[st.END]
    out = at_end(workspace)
    watching = _watch(k, modes, workspace.lines[st.GUARD], workspace.integers[st.WATCHED])
    if k[ly.STIFF] > 0:
        return stiff_step(machine, state, t, h, tolerance, watching)
    seen = stages(machine, state, t, h, 1, STAGES, watching)
    stage_point(AFTER, h, y, workspace.slopes, end)
    failed = field(machine, t + h, end, modes, workspace.lines[st.INPUTS], out)
    worst = _error(k, p, h, modes, workspace)
    if seen < 0.0 or failed != 0 or not _is_finite(end, out.rates) or not math.isfinite(worst):
        return math.inf, 1.0
    return worst / tolerance, seen


@part_kernel
def trace(machine: CompiledMechanism, state: MechanismState, t: float, h: float) -> bool:
    """Compute the dense output (state, work) of a step; return False if a friction law fails."""
    workspace = state.workspace
    if machine.whole[ly.STIFF] > 0:  # `stiff_step` has filled the path
        return True
    seen = stages(machine, state, t, h, AFTER + 1, SLOPES, 0)
    path_of(h, workspace.slopes, workspace.slopes[st.PATH :])
    path_of(h, workspace.powers, workspace.powers[st.PATH :])
    return seen >= 0.0


@part_kernel
def look(machine: CompiledMechanism, state: MechanismState, t: float, h: float, at: float) -> bool:
    """Evaluate the dense output at the time `at` in 0 .. h; return True if the rates are finite.

    Fills the rows END, AFTER and TRIAL of the workspace (`try_step`) with the results of a step of
    length `at`.
    """
    y, workspace = state.y, state.workspace
    end = workspace.lines[st.END]
    out = at_end(workspace)
    on_path(at / h, workspace.slopes[st.PATH :], end)
    for i in range(y.shape[0]):
        end[i] += y[i]
    status = field(machine, t + at, end, state.modes, workspace.lines[st.INPUTS], out)
    return status == 0 and _is_finite(end, out.rates)
