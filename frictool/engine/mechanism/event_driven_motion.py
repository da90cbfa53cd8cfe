"""Event-driven simulation of a mechanism under constant commands.

    machine = prepare(packed)                   engine/mechanism/preparation.py, once
    state = rest(packed, machine, start)        engine/mechanism/state.py
    status = advance(machine, state, command, external, duration, TOLERANCE,
                     EventRows(rows, count))

Between events all modes are constant and the rates smooth. The motion is integrated by the
Dormand-Prince method 8(5,3) with error control, or by implicit steps if a link is stiff
(stiff_step.py). A guard (mode_guards.py) measures how far a mode is from its end. If a guard falls
to its limit within a step, the step ends at this instant. The step's dense output gives the instant
to rounding. Then the modes are determined again. If nothing moves and all drives are steady, the
remaining duration is skipped.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import address_calls as ac
from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import state as st
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.articulated_body import field
from frictool.engine.mechanism.dormand_prince8 import AFTER
from frictool.engine.mechanism.event_handling import begin, handle_event, take_step
from frictool.engine.mechanism.event_location import locate
from frictool.engine.mechanism.events import EVENTS, EventRows
from frictool.engine.mechanism.fixed_step_laws import keep, switch
from frictool.engine.mechanism.hysteresis_memory import first_reversal
from frictool.engine.mechanism.integration_step import try_step
from frictool.engine.mechanism.mode_guards import first_dip, is_any_broken
from frictool.engine.mechanism.sources import is_steady, let_flow, longest_step, take_inputs
from frictool.engine.mechanism.state import MechanismState, RateEvaluation
from frictool.engine.mechanism.stiff_step import add_effort_changes
from frictool.engine.mechanism.weighted_sums import gained
from frictool.engine.status_codes import LAW_FAILED, NOT_FINITE, OK, STEP_TOO_SMALL, TOO_MANY_EVENTS
from frictool.runtime.kernels import bare_kernel, kernel, part_kernel
from frictool.typing import IntVector, Vector

# tolerance of a speed, relative to the larger of the speed and a tenth of the speed scale
TOLERANCE = 1e-8
MAX_EVENTS = 200_000  # largest number of events in a call
GROWTH, SHRINKAGE, SAFETY = 4.0, 0.2, 0.9
MANY_LAGS = 50.0  # half lags after which a drive's lag no longer limits the step
SHORTEST = 1e-15  # shortest step, relative to the time reached, or in s


@bare_kernel
def _is_settled(k: IntVector, state: MechanismState) -> bool:
    n = k[ly.BLOCKS]
    if k[ly.INNER] > 0 or k[ly.TIMED] > 0 or not is_steady(k, state.workspace.lines[st.INPUTS]):
        return False
    moves = False
    for i in range(n, 2 * n):
        moves = moves or state.y[i] != 0.0 or state.workspace.slopes[0, i] != 0.0
    return not moves


@bare_kernel
def _change(k: IntVector, error: float) -> float:
    if error == 0.0:
        return GROWTH
    power = -0.25 if k[ly.STIFF] > 0 else -0.125
    return min(GROWTH, max(SHRINKAGE, SAFETY * error**power)) if math.isfinite(error) else SHRINKAGE


@bare_kernel
def _dip(k: IntVector, p: Vector, state: MechanismState, h: float, seen: float) -> float:
    workspace = state.workspace
    guard, end = workspace.lines[st.GUARD], workspace.lines[st.END]
    return min(
        seen * h,
        first_dip(
            k, p, h, state.y, workspace.slopes[0], end, workspace.slopes[AFTER], state.modes, guard
        ),
    )


@part_kernel
def _through(
    machine: CompiledMechanism,
    state: MechanismState,
    command: Vector,
    external: Vector,
    duration: float,
    tolerance: float,
    events: EventRows,
) -> int:
    k, p, _ = machine
    y = state.y
    modes = state.modes
    pace = state.pace
    workspace = state.workspace
    take_inputs(k, p, command, external, y, state.drive, workspace.lines[st.INPUTS])
    status = begin(machine, state, events)
    t = 0.0
    counted = 0
    looked = False
    h = min(pace[0], duration)
    within = longest_step(k, p, workspace.lines[st.INPUTS])
    while t < duration and status == OK:
        if _is_settled(k, state):
            t = duration
            break
        h = min(h, duration - t, within if t < MANY_LAGS * within else duration)
        error, seen = try_step(machine, state, t, h, tolerance)
        if error > 1.0:
            if h <= SHORTEST * max(t, 1.0):
                status = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
                break
            h = h * _change(k, error)
            looked = False
            continue
        sooner = first_reversal(k, p, h, y, workspace.lines[st.END]) if k[ly.INNER] > 0 else h
        if sooner < h:
            h = sooner
            continue
        broken = is_any_broken(
            k,
            p,
            workspace.lines[st.END],
            modes,
            workspace.lines[st.TRIAL],
            workspace.lines[st.GUARD],
        )
        sooner = h if broken or looked else _dip(k, p, state, h, seen)
        if sooner < h:
            h = sooner
            looked = True
            continue
        taken = h
        longer = h * _change(k, error)
        failed = False
        if broken:
            taken, failed = locate(machine, state, t, h)
        elif k[ly.STIFF] == 0:
            gained(h, workspace.powers, workspace.lines[st.SPENT])
        if failed:
            status = NOT_FINITE
            break
        last = taken == duration - t and not broken
        t = duration if last else t + taken
        if k[ly.STIFF] > 0:
            add_effort_changes(k, p, state)
        status = take_step(machine, state, t)
        if not broken:
            pace[0] = max(pace[0], longer) if looked or last else longer
            h = longer
        elif status == OK:
            counted += 1
            status = (
                handle_event(machine, state, t, events)
                if counted <= MAX_EVENTS
                else TOO_MANY_EVENTS
            )
            h = pace[0]
        looked = False
    let_flow(k, p, workspace.lines[st.INPUTS], t, state.drive)
    pace[1] = pace[1] + t
    pace[2] = t
    return status


@part_kernel
def _in_law_steps(
    machine: CompiledMechanism,
    state: MechanismState,
    command: Vector,
    external: Vector,
    duration: float,
    tolerance: float,
    events: EventRows,
) -> int:
    k, p, _ = machine
    workspace = state.workspace
    out = RateEvaluation(
        workspace.slopes[0], workspace.w, workspace.lines[st.GUARD], workspace.powers[0]
    )
    parts = max(1, math.ceil(duration / state.pace[3] - 1e-6))
    for _part in range(parts):
        take_inputs(k, p, command, external, state.y, state.drive, workspace.lines[st.INPUTS])
        if (
            field(machine, 0.0, state.y, state.modes, workspace.lines[st.INPUTS], out)
            + switch(machine, state)
            != 0
        ):
            return LAW_FAILED
        status = _through(machine, state, command, external, duration / parts, tolerance, events)
        if status != OK:
            return status
        if keep(machine, state) != 0:
            return LAW_FAILED
    return OK


@kernel
def held_command(
    machine: CompiledMechanism,
    state: MechanismState,
    command: Vector,
    external: Vector,
    duration: float,
    tolerance: float,
    events: EventRows,
) -> int:
    """Advance the state as `advance` does; `advance` calls this kernel by its address."""
    k, y = machine.whole, state.y
    n = k[ly.BLOCKS]
    total = duration
    for i in range(y.shape[0]):
        total += y[i]
    for s in range(k[ly.SOURCES]):
        total += command[s]
    for i in range(n):
        total += external[i]
    if not math.isfinite(total) or duration < 0.0:
        return NOT_FINITE
    if k[ly.TIMED] == 0:
        return _through(machine, state, command, external, duration, tolerance, events)
    return _in_law_steps(machine, state, command, external, duration, tolerance, events)


HELD_COMMAND = ac.function_type(
    ac.INTEGER, ly.MACHINE, st.STATE, ac.VECTOR, ac.VECTOR, ac.FLOAT, ac.FLOAT, EVENTS
)
_held_command = ac.call_by_address(HELD_COMMAND)


@bare_kernel
def advance(
    machine: CompiledMechanism,
    state: MechanismState,
    command: Vector,
    external: Vector,
    duration: float,
    tolerance: float,
    events: EventRows,
) -> int:
    """Advance the state, in place, by `duration` [s] under constant commands and external efforts.

    - command (u,): command of each source [A | V | N | N m]
    - external (n,): efforts on blocks [N | N m]

    Adds the events to `events`. The limit of a winding is computed for the speed at the beginning
    of the call. Returns a status of engine/status_codes.py; if the status is not OK, `state` is the
    state after the last event or step.
    """
    address = machine.laws[machine.laws.shape[0] - 1, ly.ADVANCE]
    status: int = _held_command(
        address, machine, state, command, external, duration, tolerance, events
    )
    return status
