"""Resolution of contacts, sticking and breakaway at one instant, tree by tree (tree_solver.py)."""

from __future__ import annotations

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import state as st
from frictool.engine.mechanism import workspace_rows as rows
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.curves import curve_value
from frictool.engine.mechanism.efforts import all_efforts, coupling_stretch
from frictool.engine.mechanism.law_kernels import EXACT, breakaway, slip_force
from frictool.engine.mechanism.state import MechanismState, RateEvaluation
from frictool.engine.mechanism.tree_solver import solve_tree
from frictool.engine.status_codes import LAW_FAILED, OK
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector


@bare_kernel
def _starting_friction(machine: CompiledMechanism, y: Vector, w: Vector) -> None:
    k, p, laws = machine
    n = k[ly.BLOCKS]
    for i in range(n):
        w[rows.AHEAD, i], w[rows.BEHIND, i] = w[rows.HOLD_HIGH, i], -w[rows.HOLD_LOW, i]
    for f in range(k[ly.FRICTIONS]):
        row = ly.friction_row(k, f)
        block = ly.block(k, row)
        if ly.kind(k, row) != EXACT or y[n + block] != 0.0:
            continue
        values = p[ly.law_values(k, row)]
        level = 1.0 if ly.level(k, row) < 0 else curve_value(k, p, ly.level(k, row), y[block])
        w[rows.AHEAD, block] += level * (
            slip_force(laws[f, 0], 0.0, 1.0, values) - breakaway(laws[f, 1], 1.0, values)
        )
        w[rows.BEHIND, block] -= level * (
            slip_force(laws[f, 0], 0.0, -1.0, values) + breakaway(laws[f, 1], -1.0, values)
        )
    for s in range(k[ly.PRESSINGS]):
        block = ly.pressing_block(k, s)
        row = ly.pressing_row(k, s)
        if y[n + block] == 0.0:
            force = max(0.0, curve_value(k, p, ly.pressing_curve(k, s), y[block]))
            excess = ly.coefficient(p, row) * (ly.breakaway_ratio(p, row) - 1.0) * force
            w[rows.AHEAD, block] -= excess
            w[rows.BEHIND, block] -= excess


@bare_kernel
def _flanks(
    k: IntVector, p: Vector, y: Vector, modes: IntVector, guard: Vector, work: Vector
) -> None:
    """Update the modes of compliant flanks that have met or separated.

    A flank may separate while its spring is still strained. The damper then absorbs the elastic
    energy.
    """
    first = k[ly.BLOCKS] + 2 * k[ly.JOINTS]
    at = k[ly.SOURCES] + k[ly.BLOCKS] + k[ly.JOINTS]
    for c in range(k[ly.COUPLINGS]):
        if guard[first + c] < -1.0:
            e, _ = coupling_stretch(k, p, c, y)
            row = ly.coupling_row(k, c)
            beyond = abs(e) - ly.gap(p, row)
            held = 0.5 * ly.stiffness(p, row) * beyond * beyond if beyond > 0.0 else 0.0
            if modes[first + c] == st.OPEN:
                modes[first + c] = -1 if e < 0.0 else 1
                work[at + c] -= held
            else:
                modes[first + c] = st.OPEN
                work[at + c] += held


@bare_kernel
def _ready(k: IntVector, y: Vector, modes: IntVector, w: Vector) -> None:
    n = k[ly.BLOCKS]
    stops = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]
    for i in range(n):
        v = y[n + i]
        modes[i] = st.STUCK if v == 0.0 else (1 if v > 0.0 else -1)
        w[rows.STOPPED_LOW, i], w[rows.STOPPED_HIGH, i] = 0.0, 0.0
    for s in range(k[ly.STOPS]):
        if modes[stops + s] != st.OPEN:
            block = ly.stop_block(k, s)
            w[rows.STOPPED_LOW if modes[stops + s] < 0 else rows.STOPPED_HIGH, block] = 1.0


@part_kernel
def resolve(
    machine: CompiledMechanism, state: MechanismState, t: float, out: RateEvaluation
) -> int:
    """Determine the modes of contacts, blocks and joints; return a status.

    t [s]: time since the last command.

    The caller must set the modes of flanks that touch without relative speed and of blocks that
    rest at a stop. `out` must contain the guards of the present modes, and is also a workspace. If
    a self-locking link wedges, the last entry of row FOUND (in the workspace's `integers`) is the
    index of the first jammed block in section ORDER.
    """
    k, p, _ = machine
    y = state.y
    modes = state.modes
    workspace = state.workspace
    w = out.w
    n = k[ly.BLOCKS]
    stops = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]
    places = workspace.integers[st.FOUND]
    _flanks(k, p, y, modes, out.guard, state.work)
    _ready(k, y, modes, w)
    if all_efforts(machine, t, y, modes, workspace.lines[st.INPUTS], out) != 0:
        return LAW_FAILED
    _starting_friction(machine, y, w)
    for index in range(n):
        i = ly.block_at(k, index)
        joint = ly.joint_of(k, i)
        if joint >= 0 and modes[n + joint] != st.OPEN:
            continue
        status = solve_tree(k, p, modes, index, places, y, w)
        if status != OK:
            return status
    for s in range(k[ly.STOPS]):
        if modes[stops + s] != st.OPEN and modes[ly.stop_block(k, s)] != st.STUCK:
            modes[stops + s] = st.OPEN
    return OK
