"""Iteration of the modes at one instant until they are consistent with the forces."""

from __future__ import annotations

from frictool.engine.mechanism import address_calls as ac
from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import state as st
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.articulated_body import field
from frictool.engine.mechanism.contact_resolution import resolve
from frictool.engine.mechanism.events import EVENTS, JAMS, EventRows, write
from frictool.engine.mechanism.mode_guards import forces_hold
from frictool.engine.mechanism.state import MechanismState, RateEvaluation
from frictool.engine.status_codes import JAMMED, LAW_FAILED, OK, UNRESOLVED
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import IntVector, Vector

ATTEMPTS = 50  # largest number of iterations


@bare_kernel
def stop_tree(k: IntVector, index: int, p: Vector, y: Vector, modes: IntVector) -> float:
    """Stop the tree with its root at `index` of section ORDER; return the lost energy [J]."""
    n = k[ly.BLOCKS]
    energy = 0.0
    at = index
    end = index + ly.span_of(k, ly.block_at(k, index))
    while at < end:
        i = ly.block_at(k, at)
        if at > index and modes[n + ly.joint_of(k, i)] == st.OPEN:
            at += ly.span_of(k, i)
            continue
        energy += 0.5 * ly.mass_of(k, p, i) * y[n + i] * y[n + i]
        y[n + i] = 0.0
        at += 1
    return energy


@bare_kernel
def align(k: IntVector, p: Vector, y: Vector, modes: IntVector) -> None:
    """Make the speeds of connected blocks consistent; set the speed of blocks at end stops to 0.

    Without this correction, rounding errors would accumulate in the relative speeds of these
    blocks.
    """
    n = k[ly.BLOCKS]
    stops = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]
    for s in range(k[ly.STOPS]):
        if modes[stops + s] != st.OPEN:
            i = ly.stop_block(k, s)
            while ly.joint_of(k, i) >= 0 and modes[n + ly.joint_of(k, i)] != st.OPEN:
                i = ly.parent_of(k, i)
            y[n + i] = 0.0
    for index in range(n):
        i = ly.block_at(k, index)
        joint = ly.joint_of(k, i)
        if joint >= 0 and modes[n + joint] != st.OPEN:
            ratio = ly.ratio(p, ly.joint_row(k, joint))
            y[n + i] = y[n + ly.parent_of(k, i)] * (ratio if ly.outward(k, i) == 1 else 1.0 / ratio)


@bare_kernel
def _jam(
    k: IntVector, p: Vector, index: int, state: MechanismState, now: float, events: EventRows
) -> bool:
    """Stop a jammed tree of blocks immediately; blocks that only touch the tree move on.

    Returns False if the jammed tree is already at rest.
    """
    n = k[ly.BLOCKS]
    root = ly.block_at(k, index)
    speed = state.y[n + root]
    energy = stop_tree(k, index, p, state.y, state.modes)
    if energy == 0.0:
        return False
    # the lost energy is added to the joint of the root's first child
    first = ly.joint_of(k, ly.block_at(k, index + 1))
    state.work[
        k[ly.SOURCES]
        + n
        + k[ly.JOINTS]
        + k[ly.COUPLINGS]
        + k[ly.FRICTIONS]
        + k[ly.PRESSINGS]
        + first
    ] += energy
    write(events, now, JAMS, root, speed)
    return True


@kernel
def modes_at_instant(
    machine: CompiledMechanism, state: MechanismState, t: float, events: EventRows
) -> int:
    """Determine the modes as `settle` does, with the same arguments."""
    k, p, workspace = machine.whole, machine.numbers, state.workspace
    out = RateEvaluation(
        workspace.slopes[0], workspace.w, workspace.lines[st.GUARD], workspace.powers[0]
    )
    for _ in range(ATTEMPTS):
        status = resolve(machine, state, t, out)
        if status == JAMMED:
            if not _jam(k, p, workspace.integers[st.FOUND, -1], state, state.pace[1] + t, events):
                return JAMMED
            continue
        if status != OK:
            return status
        if field(machine, t, state.y, state.modes, workspace.lines[st.INPUTS], out) != 0:
            return LAW_FAILED
        if forces_hold(k, state.modes, out.guard):
            return OK
    return UNRESOLVED


MODES_AT_INSTANT = ac.function_type(ac.INTEGER, ly.MACHINE, st.STATE, ac.FLOAT, EVENTS)
_modes_at_instant = ac.call_by_address(MODES_AT_INSTANT)


@bare_kernel
def settle(machine: CompiledMechanism, state: MechanismState, t: float, events: EventRows) -> int:
    """Determine the modes, t [s] after the last command; return a status code.

    The rates and powers for these modes are written to row 0 of the workspace's `slopes` and
    `powers`, the guards to row GUARD of its `lines`.
    """
    address = machine.laws[machine.laws.shape[0] - 1, ly.SETTLE]
    status: int = _modes_at_instant(address, machine, state, t, events)
    return status
