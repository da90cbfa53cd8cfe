"""Updates between steps: modes at the start of a call, state after a step, modes after an event."""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import state as st
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.articulated_body import field
from frictool.engine.mechanism.dormand_prince8 import AFTER
from frictool.engine.mechanism.events import STRIKES, TOUCHES, EventRows, write, write_changes
from frictool.engine.mechanism.hysteresis_memory import remember
from frictool.engine.mechanism.impacts import impacts
from frictool.engine.mechanism.mode_guards import distance_to_guard, forces_hold
from frictool.engine.mechanism.mode_iteration import align, settle, stop_tree
from frictool.engine.mechanism.state import MechanismState, RateEvaluation
from frictool.engine.status_codes import LAW_FAILED, OK
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

FIRST_STEP = 1e-5  # s, first step of a state


@bare_kernel
def _note(k: IntVector, state: MechanismState) -> None:
    for i in range(state.modes.shape[0]):
        state.workspace.integers[st.BEFORE, i] = state.modes[i]
    for i in range(k[ly.BLOCKS]):
        state.workspace.lines[st.SPEEDS, i] = state.y[k[ly.BLOCKS] + i]


@bare_kernel
def _copy(values: Vector, to: Vector) -> None:
    for i in range(to.shape[0]):
        to[i] = values[i]


@bare_kernel
def _are_finite(values: Vector) -> bool:
    total = 0.0
    for value in values:
        total += value
    return math.isfinite(total)


@bare_kernel
def _evaluate(machine: CompiledMechanism, state: MechanismState, t: float) -> int:
    workspace = state.workspace
    out = RateEvaluation(
        workspace.slopes[0], workspace.w, workspace.lines[st.GUARD], workspace.powers[0]
    )
    return field(machine, t, state.y, state.modes, workspace.lines[st.INPUTS], out)


@part_kernel
def begin(machine: CompiledMechanism, state: MechanismState, events: EventRows) -> int:
    """Evaluate the rates under a new command, and update the modes if the command requires this.

    The first call for a state determines all modes. Returns a status of engine/status_codes.py.
    """
    k, p, _ = machine
    pace, workspace = state.pace, state.workspace
    if _evaluate(machine, state, 0.0) != 0:
        return LAW_FAILED
    fresh = pace[0] == 0.0
    if (
        not fresh
        and forces_hold(k, state.modes, workspace.lines[st.GUARD])
        and _are_finite(workspace.slopes[0])
    ):
        return OK
    _note(k, state)
    status = impacts(k, p, state.y, state.modes, workspace.w, state.work) if fresh else OK
    if status == OK:
        status = settle(machine, state, 0.0, events)
    if not fresh:
        write_changes(
            machine,
            pace[1],
            workspace.lines[st.SPEEDS],
            workspace.integers[st.BEFORE],
            state.modes,
            events,
        )
    pace[0] = max(pace[0], FIRST_STEP)
    return status


@part_kernel
def take_step(machine: CompiledMechanism, state: MechanismState, t: float) -> int:
    """Set the state to its value at the end of a step, t [s] after the last command.

    The work done in the step is added to `work`, and dynamic laws update their memory. Returns a
    status of engine/status_codes.py.
    """
    y, work, workspace = state.y, state.work, state.workspace
    _copy(workspace.lines[st.END], y)
    _copy(workspace.slopes[AFTER], workspace.slopes[0])
    _copy(workspace.powers[AFTER], workspace.powers[0])
    _copy(workspace.lines[st.TRIAL], workspace.lines[st.GUARD])
    spent = workspace.lines[st.SPENT]
    for e in range(work.shape[0]):
        work[e] += spent[e]
    if machine.whole[ly.INNER] > 0:
        failed, changed = remember(machine, y, workspace.lines[st.END])
        if changed:
            failed += _evaluate(machine, state, t)
        if failed != 0:
            return LAW_FAILED
    return OK


@bare_kernel
def _meet_or_halt(
    k: IntVector, p: Vector, now: float, state: MechanismState, events: EventRows
) -> bool:
    n, j, c = k[ly.BLOCKS], k[ly.JOINTS], k[ly.COUPLINGS]
    y = state.y
    modes = state.modes
    guard = state.workspace.lines[st.GUARD]
    meet = False
    for joint in range(j):
        if modes[n + joint] == st.OPEN and guard[n + joint] <= 0.0:
            _, rate = distance_to_guard(k, p, n + joint, y, y, modes)
            if rate < 0.0:
                write(events, now, TOUCHES, joint, -rate)
                meet = True
    for s in range(k[ly.STOPS]):
        if modes[n + 2 * j + c + s] == st.OPEN and guard[n + 2 * j + c + s] <= 0.0:
            _, rate = distance_to_guard(k, p, n + 2 * j + c + s, y, y, modes)
            if rate < 0.0:
                write(events, now, STRIKES, s, -rate)
                meet = True
    for index in range(n):
        i = ly.block_at(k, index)
        if guard[i] <= 0.0 and modes[i] != st.STUCK and y[n + i] != 0.0:
            stop_tree(k, index, p, y, modes)
    return meet


@part_kernel
def handle_event(
    machine: CompiledMechanism, state: MechanismState, t: float, events: EventRows
) -> int:
    """Handle the events that the guards indicate: impacts, stops and changes of modes.

    t [s]: time since the last command. Returns a status of engine/status_codes.py.
    """
    k, p, _ = machine
    y = state.y
    modes = state.modes
    workspace = state.workspace
    now = state.pace[1] + t
    status = OK
    _note(k, state)
    if _meet_or_halt(k, p, now, state, events):
        status = impacts(k, p, y, modes, workspace.w, state.work)
    align(k, p, y, modes)
    if status == OK:
        status = settle(machine, state, t, events)
    write_changes(
        machine, now, workspace.lines[st.SPEEDS], workspace.integers[st.BEFORE], modes, events
    )
    return status
