"""State of a mechanism: motion, drives, modes of contacts and friction laws, and work done so far.

    y       positions (n,), speeds (n,), internal states of friction laws (z,)
    drive   drive of each source (u,): A, V, or an effort
    modes   integers, in the sections below
    work    J, in the sections below

=======  =========  =============================================================================
section  length     modes
=======  =========  =============================================================================
motion   n          STUCK; +1, -1: slips in that direction, also at speed 0; FREE: moves, and
                    no block that it is connected to can stick
contact  joints     OPEN; -1: touches at e = -gap, lambda >= 0; +1: touches at e = gap,
                    lambda <= 0; RIGID
branch   joints     side of a lossy joint's kink: +1 if lambda was last above the kink, -1 if it
                    was below; 0: self-locking, not loaded yet
flank    couplings  OPEN; -1, +1: pressed at that flank
stop     stops      OPEN; -1, +1: rests at the low or the high end stop
law      frictions  mode of a hybrid law or a law with a rest band
=======  =========  =============================================================================

Here e is the position difference of a joint's flanks (guard_tolerances.py `joint_gap`), and lambda
the force at the joint's load end b. The kink is the lambda at which the slope of the joint's loss
changes (joint_losses.py).

==========  =========  ==========================================================================
section     length     work
==========  =========  ==========================================================================
sources     u          done by each source on its block
external    n          done by the external efforts on blocks
joints      joints     lost in each joint by its efficiency
couplings   couplings  lost by damping and efficiency
frictions   f          taken by each friction, minus the stored energy that a dynamic law returns
pressings   p          taken by each pressing (cam friction)
impacts     joints     lost in impacts of flanks and in jams
stops       stops      lost at end stops
==========  =========  ==========================================================================
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from frictool.engine.mechanism import address_calls as ac
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.dormand_prince8 import SLOPES
from frictool.engine.mechanism.law_kernels import rest_of
from frictool.engine.mechanism.weighted_sums import BUMPS
from frictool.engine.mechanism.workspace_rows import WORK_ROWS
from frictool.friction.law_registry import ROWS
from frictool.plant.mechanism.packed_mechanism import PackedMechanism
from frictool.typing import IntVector, Vector

STUCK, FREE = 0, 2
OPEN, RIGID = 0, 2
LAW_STEP = 1e-5  # s, default step of hybrid laws and laws with a rest band

# rows of Workspace.slopes and Workspace.powers: the SLOPES slopes of a step (dormand_prince8.py),
# then the coefficients of the dense output, from row PATH on
PATH = SLOPES
# rows of Workspace.lines
INPUTS = 0  # (2 u + n,): commands, drives at the beginning, external efforts on blocks
POINT, END = 1, 2  # (y,): point of a stage; end of a step
Y_LOW, RATES_LOW, Y_HIGH, RATES_HIGH = 3, 4, 5, 6  # states and rates at both ends of a search
# (modes,): guards at a step's beginning, at its end, at both ends of a search
GUARD, TRIAL, AT_LOW, AT_HIGH = 7, 8, 9, 10
SPENT = 11  # (work,): J, in a step
SPEEDS = 12  # (n,): speeds before an event
ERRORS, THIRD = 13, 14  # (y,): errors of a step
LINES = 15
SWINGS = 4  # index in `pace` of the first coupling
# rows of Workspace.integers
# (modes,) before an event; blocks as indices in ORDER; indices of the guards that stages check
BEFORE, FOUND, WATCHED = 0, 1, 2
INTEGER_ROWS = 3


class Workspace(NamedTuple):
    """Work arrays of the kernels; their content is valid within one call only.

    - w: work array with the rows of workspace_rows.py
    - slopes, powers: one row per stage of a step
    - lines, integers: rows with the names that this module defines. Rows may be longer than needed
    """

    w: Vector  # (WORK_ROWS, blocks or joints): workspace_rows.py
    slopes: Vector  # (SLOPES + BUMPS, y)
    powers: Vector  # (SLOPES + BUMPS, work)
    lines: Vector  # (LINES, longest)
    integers: IntVector  # (INTEGER_ROWS, longest)


class RateEvaluation(NamedTuple):
    """Output arrays of an evaluation of the rates y'."""

    rates: Vector  # (y,): y'
    w: Vector  # (WORK_ROWS, blocks or joints)
    guard: Vector  # (modes,) or longer: engine/mechanism/articulated_body.py
    power: Vector  # (work,): W, done or taken by each element


class MechanismState(NamedTuple):
    """State of a mechanism; all arrays are changed in place.

    The module docstring describes y, drive, modes and work. pace (4 + couplings,): next step
    length [s], time since the start of the run [s], time since the last command [s], step of the
    fixed-step laws [s]; for each coupling, the sum of the absolute changes of the spring effort [N
    | N m]. Only implicit steps compute these sums.
    """

    y: Vector
    drive: Vector
    modes: IntVector
    work: Vector
    pace: Vector
    workspace: Workspace


WORKSPACE = ac.record_type(Workspace, ac.MATRIX, ac.MATRIX, ac.MATRIX, ac.MATRIX, ac.INDEX_ROWS)
EVALUATION = ac.record_type(RateEvaluation, ac.VECTOR, ac.MATRIX, ac.VECTOR, ac.VECTOR)
STATE = ac.record_type(
    MechanismState, ac.VECTOR, ac.VECTOR, ac.INDICES, ac.VECTOR, ac.VECTOR, WORKSPACE
)


class WorkByElement(NamedTuple):
    """Work done and lost so far [J], by element."""

    sources: Vector
    external: Vector
    joints: Vector
    couplings: Vector
    frictions: Vector
    pressings: Vector
    impacts: Vector
    stops: Vector


def counts(machine: CompiledMechanism) -> dict[str, int]:
    """Return the number of elements of each kind."""
    names = (
        "blocks",
        "joints",
        "couplings",
        "frictions",
        "pressings",
        "pushes",
        "stops",
        "sources",
        "inner",
    )
    return dict(zip(names, machine.whole[: len(names)].tolist(), strict=True))


def rest(
    packed: PackedMechanism,
    machine: CompiledMechanism,
    start: ArrayLike,
    law_step: float = LAW_STEP,
) -> MechanismState:
    """Return the state at rest at the positions `start` (n,) [rad | m], with all drives zero.

    law_step [s]: step T_e of hybrid laws and laws with a rest band
    (engine/mechanism/fixed_step_laws.py). Raises ValueError if the shape of `start` is wrong, or
    `law_step` is not above 0.
    """
    if not law_step > 0.0:
        raise ValueError(f"law_step is {law_step} s; allowed: above 0 s")
    c = counts(machine)
    where = np.asarray(start, dtype=np.float64)
    if where.shape != (c["blocks"],):
        raise ValueError(
            f"start has shape {where.shape}; allowed: ({c['blocks']},), one position for each block"
        )
    n = c["blocks"]
    f = packed.frictions
    y = np.zeros(2 * n + c["inner"])
    y[:n] = where
    at = 2 * n
    for i, row in enumerate(f.law.tolist()):
        z = rest_of(ROWS[row], f.law_values[f.law_start[i] : f.law_start[i + 1]])
        y[at : at + z.size] = z
        at += z.size
    modes = np.zeros(
        n + 2 * c["joints"] + c["couplings"] + c["stops"] + c["frictions"], dtype=np.int64
    )
    modes[n : n + c["joints"]] = np.where(packed.joints.gap == 0.0, RIGID, OPEN)
    locking = np.maximum(packed.joints.back_loss, packed.joints.thread) > np.abs(
        packed.joints.ratio
    )
    modes[n + c["joints"] : n + 2 * c["joints"]] = np.where(locking, 0, 1)
    size = (
        c["sources"]
        + n
        + 2 * c["joints"]
        + c["couplings"]
        + c["frictions"]
        + c["pressings"]
        + c["stops"]
    )
    return MechanismState(
        y,
        np.zeros(c["sources"]),
        modes,
        np.zeros(size),
        np.array([0.0, 0.0, 0.0, law_step] + c["couplings"] * [0.0]),
        _workspace(c, y.size, modes.size, size),
    )


def _workspace(c: dict[str, int], size: int, modes: int, work: int) -> Workspace:
    n = c["blocks"]
    longest = max(size, modes, work, 2 * c["sources"] + n, n + 1)
    return Workspace(
        np.zeros((WORK_ROWS, max(n, c["joints"]))),
        np.zeros((SLOPES + BUMPS, size)),
        np.zeros((SLOPES + BUMPS, work)),
        np.zeros((LINES, longest)),
        np.zeros((INTEGER_ROWS, longest), dtype=np.int64),
    )


def work_by_element(machine: CompiledMechanism, state: MechanismState) -> WorkByElement:
    """Return the work done and lost so far [J], for each element."""
    c = counts(machine)
    lengths = [
        c[k]
        for k in (
            "sources",
            "blocks",
            "joints",
            "couplings",
            "frictions",
            "pressings",
            "joints",
            "stops",
        )
    ]
    return WorkByElement(*np.split(state.work, np.cumsum(lengths)[:-1]))
