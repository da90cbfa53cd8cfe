"""Layout of a compiled mechanism, and access to its entries.

A compiled mechanism consists of two arrays and the addresses of the friction laws' kernels. The
arrays are integers (`whole`, in kernels `k`) and floats (`numbers`, in kernels `p`). Both arrays
are divided into sections. `whole` begins with HEADER entries: the numbers of blocks, joints and
other elements, and the index at which each section begins. A section X has WIDTH columns; the entry
in row r and column c has the index whole[X] + r * WIDTH + c.

Joints form trees. Section ORDER lists the blocks in preorder: a parent precedes its children. A
group is a set of blocks that rigid joints connect.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, cast

from llvmlite import ir
from numba.extending import intrinsic

from frictool.engine.mechanism import address_calls as ac
from frictool.runtime.kernels import bare_kernel
from frictool.typing import IntVector, Vector

# indices of the numbers of elements
BLOCKS, JOINTS, COUPLINGS, FRICTIONS, PRESSINGS, PUSHES, STOPS, SOURCES, INNER = range(9)
TIMED = 38  # index of the number of frictions whose law has a fixed step
STIFF = 39  # index of the number of couplings that require implicit steps
# sections of integers
(
    JOINT_ENDS,
    COUPLING_ENDS,
    FRICTION_INDICES,
    PRESSING_INDICES,
    PUSH_INDICES,
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
# columns of FRICTION_INDICES
BLOCK, LAW, KIND, VALUES, VALUES_END, LEVEL, FIRST_INNER, INNER_END, STRAIGHT, FRICTION_WIDTH = (
    range(10)
)
COEFFICIENT, BREAKAWAY_RATIO = 0, 1
LOW, HIGH, THROW_BACK, STOP_WIDTH = 0, 1, 2, 3
CONSTANT, LIMIT, LAG, RESISTANCE, SUPPLY, SOURCE_WIDTH = range(6)


# columns of the last row of `laws`, the addresses of the engine's kernels
ADVANCE, FIELD, STEP_STAGES, SETTLE, STIFF_STEP = range(5)


class CompiledMechanism(NamedTuple):
    """Mechanism as arrays for the kernels; `prepare` computes them from a `PackedMechanism`.

    - whole, numbers: integers and floats of all sections
    - laws: addresses of the friction laws' kernels
    """

    whole: IntVector
    numbers: Vector
    laws: IntVector  # (frictions + 1, 6): a row for each friction's law, then one for the engine


MACHINE = ac.record_type(CompiledMechanism, ac.INDICES, ac.VECTOR, ac.INDEX_ROWS)


def _load(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.load(builder.gep(data, [index]))


def _integer(value: int) -> Any:
    return ir.Constant(ir.IntType(64), value)


def _first(section: int, width: int, column: int = 0) -> Callable[..., Any]:
    def code(context: Any, builder: Any, k: Any, row: Any) -> Any:
        start = _load(context, builder, ac.INDICES, k, _integer(section))
        start = builder.add(start, builder.mul(row, _integer(width)))
        return builder.add(start, _integer(column))

    return code


def _row(section: int, width: int) -> Callable[[IntVector, int], int]:
    first = _first(section, width)

    @intrinsic
    def row_of(_: Any, k: Any, row: Any) -> Any:
        return ac.INTEGER(ac.INDICES, ac.INTEGER), lambda context, builder, _, a: first(
            context, builder, *a
        )

    return cast(Callable[[IntVector, int], int], row_of)


def _entry(section: int, width: int = 1, column: int = 0) -> Callable[[IntVector, int], int]:
    first = _first(section, width, column)

    def code(context: Any, builder: Any, _: Any, a: Any) -> Any:
        return _load(context, builder, ac.INDICES, a[0], first(context, builder, *a))

    @intrinsic
    def entry(_: Any, k: Any, row: Any) -> Any:
        return ac.INTEGER(ac.INDICES, ac.INTEGER), code

    return cast(Callable[[IntVector, int], int], entry)


def _number(section: int) -> Callable[[IntVector, Vector, int], float]:
    first = _first(section, 1)

    def code(context: Any, builder: Any, _: Any, a: Any) -> Any:
        return _load(context, builder, ac.VECTOR, a[1], first(context, builder, a[0], a[2]))

    @intrinsic
    def entry(_: Any, k: Any, p: Any, row: Any) -> Any:
        return ac.FLOAT(ac.INDICES, ac.VECTOR, ac.INTEGER), code

    return cast(Callable[[IntVector, Vector, int], float], entry)


def _column(column: int, kind: Any, result: Any) -> Callable[..., Any]:
    def code(context: Any, builder: Any, _: Any, a: Any) -> Any:
        return _load(context, builder, kind, a[0], builder.add(a[1], _integer(column)))

    @intrinsic
    def entry(_: Any, array: Any, row: Any) -> Any:
        return result(kind, ac.INTEGER), code

    return cast(Callable[..., Any], entry)


def _parameter(column: int) -> Callable[[Vector, int], float]:
    return _column(column, ac.VECTOR, ac.FLOAT)


def _place(column: int) -> Callable[[IntVector, int], int]:
    return _column(column, ac.INDICES, ac.INTEGER)


# Accessors for kernels.
block_at = _entry(ORDER)  # block at a position in the order
parent_of = _entry(PARENT)  # parent of a block, -1 for a root
joint_of = _entry(PARENT_JOINT)  # joint from a block to its parent, -1 for a root
outward = _entry(OUTWARD)  # 1 if end a of the joint to the parent is at the parent
can_stick = _entry(DRY)  # 1 if a block can stick by its own elements
span_of = _entry(SPAN)  # number of blocks in a block's subtree, contiguous in the order
group_of, stop_block, source_block = _entry(GROUP), _entry(STOP_BLOCKS), _entry(SOURCE_BLOCKS)
joint_a, joint_b = _entry(JOINT_ENDS, 2, 0), _entry(JOINT_ENDS, 2, 1)
coupling_a, coupling_b = _entry(COUPLING_ENDS, 3, 0), _entry(COUPLING_ENDS, 3, 1)
coupling_curve = _entry(COUPLING_ENDS, 3, 2)
push_block, push_curve = _entry(PUSH_INDICES, 2, 0), _entry(PUSH_INDICES, 2, 1)
pressing_block, pressing_curve = _entry(PRESSING_INDICES, 2, 0), _entry(PRESSING_INDICES, 2, 1)
mass_of = _number(MASS)  # kg | kg m2
speed_scale = _number(SPEED)  # typical speed of a block [m/s | rad/s]
group_ratio = _number(GROUP_RATIO)  # speed of a block relative to the first block of its group
group_mass, push_of, inner_size = _number(GROUP_MASS), _number(PUSH), _number(INNER_SIZE)
joint_row, coupling_row = _row(JOINT, JOINT_WIDTH), _row(COUPLING, COUPLING_WIDTH)  # in p
source_row, stop_row = _row(SOURCE, SOURCE_WIDTH), _row(STOP, STOP_WIDTH)  # in p
# in p; in k
pressing_row = _row(PRESSING, 2)
friction_row = _row(FRICTION_INDICES, FRICTION_WIDTH)
ratio, offset, gap, restitution = map(_parameter, (RATIO, OFFSET, GAP, RESTITUTION))
drive_loss, back_loss, thread = map(_parameter, (DRIVE_LOSS, BACK_LOSS, THREAD))
thesis_screw, stiffness, damping = map(_parameter, (THESIS_SCREW, STIFFNESS, DAMPING))
coefficient, breakaway_ratio = map(_parameter, (COEFFICIENT, BREAKAWAY_RATIO))
low, high, throw_back = map(_parameter, (LOW, HIGH, THROW_BACK))
constant, limit, lag = map(_parameter, (CONSTANT, LIMIT, LAG))
resistance, supply = map(_parameter, (RESISTANCE, SUPPLY))
block, kind, level, straight = map(_place, (BLOCK, KIND, LEVEL, STRAIGHT))


@bare_kernel
def law_values(k: IntVector, row: int) -> slice:
    """Return the indices of a friction law's parameters in p (`numbers`).

    row: result of `friction_row`.
    """
    return slice(k[LAW_VALUES] + k[row + VALUES], k[LAW_VALUES] + k[row + VALUES_END])


@bare_kernel
def inner_states(k: IntVector, row: int) -> slice:
    """Return the indices of a friction law's internal states in the state y.

    row: result of `friction_row`.
    """
    return slice(2 * k[BLOCKS] + k[row + FIRST_INNER], 2 * k[BLOCKS] + k[row + INNER_END])
