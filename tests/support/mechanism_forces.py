"""Forces in a mechanism at one instant: of joints on their ends b, of friction on blocks.

In motion they follow from the motion. At rest, friction in several elements leaves them
undetermined; the result is one possible choice, always the same. Each element takes the smallest
force that it can. A remainder goes to frictions before links, from the root outward.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import state as st
from frictool.engine.mechanism import workspace_rows as rows
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.articulated_body import field
from frictool.engine.mechanism.dormand_prince8 import AFTER
from frictool.engine.mechanism.state import MechanismState, RateEvaluation, counts
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import IntVector, Vector

# rows of the work array that are free while no contact is being resolved
LEAST, REST, GIVEN, HELD = range(11, 15)


class RestForces(NamedTuple):
    """Forces of joints and of friction.

    links (j,): lambda of each joint, on its end b. holds (n,): force of friction on each block at
    rest, 0 on moving blocks.
    """

    links: Vector
    holds: Vector


@bare_kernel
def _range_of(k: IntVector, p: Vector, i: int, contact: int, w: Vector) -> tuple[float, float]:
    """Return the range of lambda of the joint between a block at rest and its parent.

    It leaves out what the joint's own friction could add.
    """
    ratio = ly.ratio(p, ly.joint_row(k, ly.joint_of(k, i)))
    low, high = w[rows.NEED, i], w[rows.NEED_HIGH, i]
    if ly.outward(k, i) == 0:
        low, high = -high / ratio, -low / ratio
        if ratio < 0.0:
            low, high = high, low
    if contact == -1:
        low, high = max(0.0, low), max(0.0, high)
    elif contact == 1:
        low, high = min(0.0, low), min(0.0, high)
    return low, high


@kernel
def _at_rest(
    k: IntVector, p: Vector, modes: IntVector, w: Vector, links: Vector, holds: Vector
) -> None:
    """Fill links and holds of all blocks at rest."""
    n = k[ly.BLOCKS]
    for i in range(n):
        w[REST, i], w[HELD, i], w[GIVEN, i] = 0.0, 0.0, 0.0
        holds[i] = 0.0
    for place in range(n - 1, -1, -1):
        i = ly.block_at(k, place)
        joint = ly.joint_of(k, i)
        if modes[i] == st.STUCK and joint >= 0 and modes[n + joint] != st.OPEN:
            low, high = _range_of(k, p, i, modes[n + joint], w)
            w[LEAST, i] = min(max(0.0, low), high)
            w[REST, ly.parent_of(k, i)] -= w[LEAST, i] * (
                ly.ratio(p, ly.joint_row(k, joint)) if ly.outward(k, i) == 1 else -1.0
            )
    for place in range(n):
        i = ly.block_at(k, place)
        joint = ly.joint_of(k, i)
        if modes[i] != st.STUCK:
            continue
        if joint >= 0 and modes[n + joint] != st.OPEN:
            parent, ratio = ly.parent_of(k, i), ly.ratio(p, ly.joint_row(k, joint))
            low, high = _range_of(k, p, i, modes[n + joint], w)
            share = ratio if ly.outward(k, i) == 1 else -1.0
            link = min(max(w[LEAST, i] + w[REST, parent] / share, low), high)
            w[REST, parent] -= (link - w[LEAST, i]) * share
            links[joint] = link
            w[GIVEN, i] = link if ly.outward(k, i) == 1 else -ratio * link
        w[REST, i] += w[GIVEN, i] + w[rows.FORCE, i]
        holds[i] = min(max(w[REST, i], w[rows.HOLD_LOW, i]), w[rows.HOLD_HIGH, i])
        w[REST, i] -= holds[i]


@kernel
def _now(machine: CompiledMechanism, state: MechanismState, links: Vector, holds: Vector) -> None:
    """Fill links and holds for the current state."""
    k, p, _ = machine
    workspace = state.workspace
    out = RateEvaluation(
        workspace.slopes[AFTER], workspace.w, workspace.lines[st.TRIAL], workspace.powers[AFTER]
    )
    field(machine, state.pace[2], state.y, state.modes, workspace.lines[st.INPUTS], out)
    for joint in range(k[ly.JOINTS]):
        links[joint] = workspace.w[rows.LAMBDA, joint]
    _at_rest(k, p, state.modes, workspace.w, links, holds)


def forces(machine: CompiledMechanism, state: MechanismState) -> RestForces:
    """Return the forces at the end of the last call of `advance`."""
    c = counts(machine)
    links, holds = np.zeros(c["joints"]), np.zeros(c["blocks"])
    _now(machine, state, links, holds)
    return RestForces(links, holds)
