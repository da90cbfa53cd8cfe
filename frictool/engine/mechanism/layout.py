"""Layout of a compiled mechanism, and access to its entries.

A mechanism is one array of integers (`whole`, in kernels `k`), one of floats (`numbers`, in kernels
`p`), both in sections, and the addresses of the laws' kernels. A kernel with `PackedMechanism`'s
fifty arrays as arguments would be slow to compile and to call. `whole` begins with HEADER entries:
the counts of blocks, joints and so on, and the index at which each section begins. In section X
with WIDTH columns, row r, column c is at whole[X] + r * WIDTH + c.

Joints form no loop, so that they form trees. Each tree has one root; blocks are in preorder
(`ORDER`), a block's parent before it. Blocks that rigid joints connect form a group.
"""

from __future__ import annotations

from typing import NamedTuple

from frictool.engine.mechanism.address_calls import INDEX_ROWS, INDICES, VECTOR, record_type
from frictool.runtime.kernels import inset_kernel
from frictool.typing import IntVector, Vector

# indices of the counts
BLOCKS, JOINTS, COUPLINGS, FRICTIONS, PRESSINGS, PUSHES, STOPS, SOURCES, INNER = range(9)
TIMED = 38  # index of the number of frictions whose law has its own step
# sections of integers
(
    JOINT_ENDS,
    COUPLING_ENDS,
    FRICTION_PLACES,
    PRESSING_PLACES,
    PUSH_PLACES,
    STOP_BLOCKS,
    SOURCE_BLOCKS,
    CURVE_START,
) = range(9, 17)
ORDER, PARENT, PARENT_JOINT, OUTWARD, GROUP, DRY, SPAN = range(17, 24)
# sections of floats
(
    MASS,
    SPEED,
    JOINT,
    COUPLING,
    LAW_VALUES,
    PRESSING,
    PUSH,
    STOP,
    SOURCE,
    BREAKS,
    CUBIC,
    GROUP_RATIO,
    GROUP_MASS,
    INNER_SIZE,
) = range(24, 38)
HEADER = 40

# columns of JOINT and of COUPLING
RATIO, OFFSET, GAP, RESTITUTION, DRIVE_LOSS, BACK_LOSS, THREAD, THESIS_SCREW, JOINT_WIDTH = range(9)
STIFFNESS, DAMPING, COUPLING_WIDTH = 6, 7, 8
# columns of FRICTION_PLACES
BLOCK, LAW, KIND, VALUES, VALUES_END, LEVEL, FIRST_INNER, INNER_END, STRAIGHT, FRICTION_WIDTH = (
    range(10)
)
COEFFICIENT, BREAKAWAY_RATIO = 0, 1
LOW, HIGH, THROW_BACK, STOP_WIDTH = 0, 1, 2, 3
CONSTANT, LIMIT, LAG, RESISTANCE, SUPPLY, SOURCE_WIDTH = range(6)


# columns of the last row of `laws`: kernels of the engine
ADVANCE, FIELD, STEP_STAGES, SETTLE = range(4)


class CompiledMechanism(NamedTuple):
    """Input of `advance`, made from a `PackedMechanism` by engine/mechanism/preparation.py."""

    whole: IntVector
    numbers: Vector
    laws: IntVector  # (frictions + 1, 6): addresses of kernels; the last row: the engine's


MACHINE = record_type(CompiledMechanism, INDICES, VECTOR, INDEX_ROWS)


@inset_kernel
def block_at(k: IntVector, place: int) -> int:
    """Return the block at a position in the order."""
    return int(k[k[ORDER] + place])


@inset_kernel
def parent_of(k: IntVector, block: int) -> int:
    """Return the parent of a block, -1 for a root."""
    return int(k[k[PARENT] + block])


@inset_kernel
def joint_of(k: IntVector, block: int) -> int:
    """Return the joint from a block to its parent, -1 for a root."""
    return int(k[k[PARENT_JOINT] + block])


@inset_kernel
def leads_out(k: IntVector, block: int) -> bool:
    """Return True if the joint to a block's parent leads from its end a at the parent to b."""
    return bool(k[k[OUTWARD] + block] == 1)


@inset_kernel
def can_stick(k: IntVector, block: int) -> bool:
    """Return True if a block can stick by its own elements."""
    return bool(k[k[DRY] + block] == 1)


@inset_kernel
def span_of(k: IntVector, block: int) -> int:
    """Return the number of blocks in a block's subtree, which are contiguous in the order."""
    return int(k[k[SPAN] + block])


@inset_kernel
def group_of(k: IntVector, block: int) -> int:
    """Return the group of a block."""
    return int(k[k[GROUP] + block])


@inset_kernel
def group_ratio(k: IntVector, p: Vector, block: int) -> float:
    """Return the speed of a block per unit of that of its group's first block."""
    return float(p[k[GROUP_RATIO] + block])


@inset_kernel
def mass_of(k: IntVector, p: Vector, block: int) -> float:
    """Return the inertia of a block [kg | kg m2]."""
    return float(p[k[MASS] + block])


@inset_kernel
def speed_scale(k: IntVector, p: Vector, block: int) -> float:
    """Return the typical speed of a block [m/s | rad/s]."""
    return float(p[k[SPEED] + block])


@inset_kernel
def joint_ends(k: IntVector, joint: int) -> tuple[int, int]:
    """Return the blocks a and b of a joint."""
    return k[k[JOINT_ENDS] + 2 * joint], k[k[JOINT_ENDS] + 2 * joint + 1]


@inset_kernel
def joint_row(k: IntVector, joint: int) -> int:
    """Return the index in p of a joint's first parameter."""
    return int(k[JOINT] + joint * JOINT_WIDTH)


@inset_kernel
def coupling_row(k: IntVector, coupling: int) -> int:
    """Return the index in p of a coupling's first parameter."""
    return int(k[COUPLING] + coupling * COUPLING_WIDTH)


@inset_kernel
def friction_row(k: IntVector, friction: int) -> int:
    """Return the index in k of a friction's first entry."""
    return int(k[FRICTION_PLACES] + friction * FRICTION_WIDTH)


@inset_kernel
def law_values(k: IntVector, row: int) -> slice:
    """Return the indices in p of the parameters of a friction's law; row: `friction_row`."""
    return slice(k[LAW_VALUES] + k[row + VALUES], k[LAW_VALUES] + k[row + VALUES_END])


@inset_kernel
def inner_states(k: IntVector, row: int) -> slice:
    """Return the indices in y of the inner states of a friction's law."""
    return slice(2 * k[BLOCKS] + k[row + FIRST_INNER], 2 * k[BLOCKS] + k[row + INNER_END])


@inset_kernel
def source_row(k: IntVector, source: int) -> int:
    """Return the index in p of a source's first parameter."""
    return int(k[SOURCE] + source * SOURCE_WIDTH)


@inset_kernel
def stop_block(k: IntVector, stop: int) -> int:
    """Return the block of an end stop."""
    return int(k[k[STOP_BLOCKS] + stop])


@inset_kernel
def stop_row(k: IntVector, stop: int) -> int:
    """Return the index in p of an end stop's first parameter."""
    return int(k[STOP] + stop * STOP_WIDTH)
