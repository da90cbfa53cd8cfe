"""Programs as arrays, and the kernels that run one sample in double, float or fixed point.

A program (control/program.py) is the list of operations of a controller or an observer. One array
contains its values: first one element for each node, then one for each state that is updated. Each
row of the array `code` is one operation. `compile_program` (double, float) and
`fixed_point.fixed_machine` (fixed point) choose the number format:

====  ======  =====================================================================
code  number  array of the values
====  ======  =====================================================================
0     DOUBLE  `real`, float64
1     FLOAT   `single`, float32: every operation rounds to float32
2     FIXED   `word`, int64 with 32-bit words: control/fixed_point_kernel.py
====  ======  =====================================================================
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.control import operation_codes as op
from frictool.control.fixed_point_kernel import (
    INVALID,
    from_real,
    run_words,
    shift_rounded,
    to_real,
)
from frictool.control.measurement_guard import FAULT
from frictool.control.program import Program
from frictool.runtime.kernels import bare_kernel
from frictool.typing import IntVector, Vector

Rows = NDArray[np.uint32]  # unsigned: a signed index costs a comparison at each access
Values = NDArray[np.float64] | NDArray[np.float32]

DOUBLE, FLOAT, FIXED = 0, 1, 2
PORTS = ("reference", "position", "velocity")  # a program without this input has index -1
OUTPUT, LEFT, LEFT_NOW, HOLD, USED, GUARD_ROWS = (
    3,
    4,
    5,
    6,
    7,
    10,
)  # indices in `CompiledProgram.ports`, from 3 on


class CompiledProgram(NamedTuple):
    """Controller or observer program as arrays for the kernels.

    A kernel changes `real`, `single` or `word` at every sample. Two axes with the same controller
    therefore need two copies (`copy_program`).

    - code (n, 5), terms (t, 3), formats (n, 6): columns as in control/operation_codes.py
    - writes (w, 2): one row for each updated state: index of the state, index of its next value
    - starts (s,): indices of the states that `start_at` sets to the measured position
    - ports (11,): indices of ten nodes (-1 for a node that the program lacks), and a number:

      - 0 to 2: inputs `PORTS`
      - 3: output
      - 4 to 6: three nodes of the measurement guard (control/measurement_guard.py): the state
        `holds_left`, its next value, and the constant `hold_samples`
      - 7 to 9: inputs after the guard has replaced invalid inputs
      - 10: number of rows of `code` that belong to the guard
    """

    number: int
    code: Rows
    terms: Rows
    writes: Rows
    ports: IntVector
    starts: IntVector
    real: Vector
    single: NDArray[np.float32]
    word: IntVector
    formats: IntVector


def compile_program(program: Program, *, single: bool = False) -> CompiledProgram:
    """Return a program as arrays, started for an axis at rest at position 0.

    single: True for float32, False for float64.
    """
    values = np.zeros(len(program.nodes) + len(program.updates))
    code: list[list[int]] = []
    terms: list[tuple[int, int, int]] = []
    for node in program.nodes:
        values[node.index] = node.value
        if node.op in op.CODES:
            args = [arg.index for arg in node.args]
            if node.op == "dot":
                half = len(args) // 2
                first = len(terms)
                terms += [(c, x, 0) for c, x in zip(args[:half], args[half:], strict=True)]
                args = [first, len(terms), 0]
            code.append([op.CODES[node.op], node.index, *args, *[0] * (3 - len(args))])
    return CompiledProgram(
        FLOAT if single else DOUBLE,
        np.array(code, dtype=np.uint32).reshape(-1, 5),
        np.array(terms, dtype=np.uint32).reshape(-1, 3),
        np.array(
            [(state, source.index) for state, source in program.updates.items()], dtype=np.uint32
        ).reshape(-1, 2),
        ports(program),
        np.array(list(program.starts), dtype=np.int64),
        np.empty(0) if single else values,
        values.astype(np.float32) if single else np.empty(0, dtype=np.float32),
        np.empty(0, dtype=np.int64),
        np.empty((0, 6), dtype=np.int64),
    )


def ports(program: Program) -> IntVector:
    """Return the array `CompiledProgram.ports`; raise ValueError if the program has no output."""
    if program.output is None:
        raise ValueError("the program has no output")
    inputs = [program.inputs[name].index if name in program.inputs else -1 for name in PORTS]
    guard = program.guard
    if guard is None:
        return np.array([*inputs, program.output.index, *[-1] * 6, 0], dtype=np.int64)
    used = [guard.used[name].index if name in guard.used else -1 for name in PORTS]
    rows = sum(node.op in op.CODES for node in program.nodes[: guard.fault.index + 1])
    indices = [
        *inputs,
        program.output.index,
        guard.left.index,
        guard.left_now.index,
        guard.hold.index,
        *used,
        rows,
    ]
    return np.array(indices, dtype=np.int64)


def copy_program(machine: CompiledProgram) -> CompiledProgram:
    """Return a copy of a compiled program with separate values and shared operations."""
    return machine._replace(
        real=machine.real.copy(), single=machine.single.copy(), word=machine.word.copy()
    )


def hold(machine: CompiledProgram, index: int, value: float) -> None:
    """Set the state at `index` to a value [SI] in a program in double or float.

    Use it only for states that the program does not update, such as scheduled parameters. A value
    of NaN or infinity is ignored.
    """
    if math.isfinite(value):
        _values(machine)[index] = value


def start_at(machine: CompiledProgram, position: float) -> None:
    """Set the states of a new program for an axis at rest at `position` [rad | m].

    The prefilter is then settled at this position. If the position is not finite, the controller
    starts in the fault state (control/measurement_guard.py), in which its drive is 0.
    """
    with np.errstate(over="ignore"):
        if not math.isfinite(np.float32(position) if machine.number == FLOAT else position):
            position = 0.0
            if machine.ports[LEFT] >= 0:
                put(machine, machine.ports[LEFT], FAULT)
    if machine.number != FIXED:
        _values(machine)[machine.starts] = position
        return
    measured = machine.formats[machine.ports[1]]
    for index in machine.starts:  # shift the word of the measured position, as the exported C does
        form = machine.formats[index]
        word = shift_rounded(
            from_real(measured, position), measured[op.FRACTION] - form[op.FRACTION]
        )
        machine.word[index] = min(max(word, form[op.LOW]), form[op.HIGH])


def put(machine: CompiledProgram, index: int, value: float) -> None:
    """Set the value [SI] of the program's node at `index`."""
    if machine.number == FIXED:
        machine.word[index] = from_real(machine.formats[index], value)
    else:
        _values(machine)[index] = value


def read(machine: CompiledProgram, index: int) -> float:
    """Return the value [SI] of the node at `index`, for example `program.states[name].index`."""
    if machine.number == FIXED:
        return to_real(machine.formats[index], machine.word[index])
    return float(_values(machine)[index])


def step(machine: CompiledProgram, reference: float, position: float, velocity: float) -> float:
    """Run one sample of a controller in place and return the drive [A | V].

    Unlike `control_step`, this function compiles only the kernels of the program's number format.
    """
    if machine.number == FIXED:
        return control_step(machine, reference, position, velocity)
    arrays = (machine.code, machine.terms, machine.writes, machine.ports)
    return step_values(*arrays, _values(machine), (reference, position, velocity))


def _values(machine: CompiledProgram) -> Values:
    return machine.single if machine.number == FLOAT else machine.real


@bare_kernel
def control_step(
    machine: CompiledProgram, reference: float, position: float, velocity: float
) -> float:
    """Run one sample of a controller in place and return the drive [A | V].

    reference and position [rad | m] and velocity [rad/s | m/s] are the inputs; position and
    velocity are measured. The velocity is used only if the controller has a velocity input. An
    input that is not finite is invalid (control/measurement_guard.py).
    """
    ports = machine.ports
    if machine.number == FIXED:
        valid = True
        for k in range(3):
            if ports[k] >= 0:
                value = reference if k == 0 else (position if k == 1 else velocity)
                word = from_real(machine.formats[ports[k]], value)
                machine.word[ports[k]] = word
                valid = valid and word != INVALID
        first = _first_row(machine.word, ports, valid)
        run_words(machine.code, machine.terms, machine.writes, machine.formats, machine.word, first)
        return to_real(machine.formats[ports[OUTPUT]], machine.word[ports[OUTPUT]])
    arrays = (machine.code, machine.terms, machine.writes, ports)
    inputs = (reference, position, velocity)
    if machine.number == FLOAT:
        return step_values(*arrays, machine.single, inputs)
    return step_values(*arrays, machine.real, inputs)


@bare_kernel
def step_values(
    code: Rows,
    terms: Rows,
    writes: Rows,
    ports: IntVector,
    v: Values,
    inputs: tuple[float, float, float],
) -> float:
    """Run one sample of a program in double or float and return the drive [A | V].

    - v: values of the program (float64 or float32), changed in place
    - inputs: reference, position and velocity
    - code, terms, writes, ports: arrays of the same names in `CompiledProgram`
    """
    first = _first_row(v, ports, _give(v, ports, inputs[0], inputs[1], inputs[2]))
    run_values(code, terms, writes, v, first)
    return float(v[ports[OUTPUT]])


@bare_kernel
def _give(v: Values, ports: IntVector, reference: float, position: float, velocity: float) -> bool:
    valid = True
    if ports[0] >= 0:
        v[ports[0]] = reference
        valid = math.isfinite(v[ports[0]])
    if ports[1] >= 0:
        v[ports[1]] = position
        valid = valid and math.isfinite(v[ports[1]])
    if ports[2] >= 0:
        v[ports[2]] = velocity
        valid = valid and math.isfinite(v[ports[2]])
    return valid


@bare_kernel
def _first_row(v: Values | IntVector, ports: IntVector, valid: bool) -> int:
    """Return the first row of `code` to run: 0, or the first row after the measurement guard.

    If this sample and the previous sample are valid, the guard would only copy the inputs. In this
    case this function copies the inputs, and the guard is skipped.
    """
    if (
        not valid
        or ports[LEFT] < 0
        or v[ports[LEFT]] != v[ports[HOLD]]
        or v[ports[LEFT_NOW]] != v[ports[HOLD]]
    ):
        return 0
    for k in range(3):
        if ports[k] >= 0:
            v[ports[USED + k]] = v[ports[k]]
    return int(ports[GUARD_ROWS])


@bare_kernel
def run_values(code: Rows, terms: Rows, writes: Rows, v: Values, first: int = 0) -> None:
    """Run the operations of one sample on the values v, from row `first` of `code` to the end.

    v is float64 or float32; every operation rounds to the type of v. The states are updated after
    the last operation.
    """
    for k in range(first, code.shape[0]):
        operation = code[k, 0]
        d = code[k, 1]
        a = code[k, 2]
        b = code[k, 3]
        c = code[k, 4]
        if operation == op.DOT:
            total = v[terms[a, 0]] * v[terms[a, 1]]
            for j in range(a + 1, b):
                total += v[terms[j, 0]] * v[terms[j, 1]]
            v[d] = total
        elif operation == op.ADD:
            v[d] = v[a] + v[b]
        elif operation == op.SUB:
            v[d] = v[a] - v[b]
        elif operation == op.MUL:
            v[d] = v[a] * v[b]
        elif operation == op.SELECT:
            v[d] = v[b] if v[a] != 0 else v[c]
        elif operation == op.LT:
            v[d] = 1 if v[a] < v[b] else 0
        elif operation == op.LE:
            v[d] = 1 if v[a] <= v[b] else 0
        elif operation == op.AND:
            v[d] = 1 if v[a] != 0 and v[b] != 0 else 0
        elif operation == op.OR:
            v[d] = 1 if v[a] != 0 or v[b] != 0 else 0
        elif operation == op.NOT:
            v[d] = 1 if v[a] == 0 else 0
        elif operation == op.NEG:
            v[d] = -v[a]
        elif operation == op.ABS:
            v[d] = -v[a] if v[a] < 0 else v[a]
        elif operation == op.MIN:
            v[d] = v[b] if v[b] < v[a] else v[a]
        elif operation == op.MAX:
            v[d] = v[b] if v[b] > v[a] else v[a]
        elif operation == op.SQRT:
            v[d] = math.sqrt(v[a])
        elif operation == op.VALID:
            v[d] = 1 if math.isfinite(v[a]) else 0
    kept = v.shape[0] - writes.shape[0]
    for k in range(writes.shape[0]):
        v[kept + k] = v[writes[k, 1]]
    for k in range(writes.shape[0]):
        v[writes[k, 0]] = v[kept + k]
