"""Compilation of a program to straight-line machine code for one sample.

    CompiledProgram ──structure: operations and indices──▶ LLVM ──▶ function pointer
                    ──coefficients and states: `real`────────────▶ memory of each call

The results equal those of `run_values` bit by bit. Programs that differ only in their coefficients
share one code. Compilation saves time if the program runs in more than about a hundred simulations
of a thousand samples.
"""

from __future__ import annotations

import functools
import itertools
import math
from functools import lru_cache
from typing import Any, NamedTuple

from llvmlite import ir
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from frictool.control import operation_codes as op
from frictool.control.compiled_program import DOUBLE, OUTPUT, PORTS, CompiledProgram
from frictool.runtime.kernels import settings
from frictool.typing import Vector

MOST_KEPT = 64  # number of structures whose code is kept; each code takes some kilobytes
NAME = "control_sample"
REAL = ir.DoubleType()
ZERO, INFINITE = REAL(0.0), REAL(math.inf)
# number of operands of each operation other than a dot
OPERANDS = {
    **dict.fromkeys((op.NEG, op.ABS, op.SQRT, op.NOT, op.VALID), 1),
    **dict.fromkeys((op.ADD, op.SUB, op.MUL, op.MIN, op.MAX, op.LT, op.LE, op.AND, op.OR), 2),
    op.SELECT: 3,
}
_serial = itertools.count()


class MachineCode(NamedTuple):
    """Compiled function that runs one sample of a program.

    - address: address of the function f(address of the program's array `real`, reference, position,
      velocity), which returns one value of the program, by default the drive
    - library: the compiled code, which is freed with this object
    """

    address: int
    library: Any


class ProgramStructure(NamedTuple):
    """Operations and indices of a program, without coefficients.

    - code, terms, writes: rows with the columns that CompiledProgram describes
    - inputs: index of each input of PORTS, or -1 if the program does not have the input
    - output: index of the value that the compiled function returns
    """

    code: tuple[tuple[int, ...], ...]
    terms: tuple[tuple[int, ...], ...]
    writes: tuple[tuple[int, ...], ...]
    inputs: tuple[int, ...]
    output: int


def machine_code(program: CompiledProgram, output: int | None = None) -> MachineCode | None:
    """Return the machine code of a program in double arithmetic.

    The result is None if the program is in another number format or if Numba's compiler is switched
    off.

    - output: index of the value that the code returns, by default the drive; if the value is a
      state, the code returns the state before its update
    """
    if program.number != DOUBLE or settings.DISABLE_JIT:
        return None
    code, terms, writes = (
        tuple(map(tuple, rows.tolist())) for rows in (program.code, program.terms, program.writes)
    )
    inputs = tuple(program.ports[: len(PORTS)].tolist())
    returned = int(program.ports[OUTPUT]) if output is None else output
    return compiled(ProgramStructure(code, terms, writes, inputs, returned))


def started_values(program: CompiledProgram, position: float) -> Vector:
    """Return the values (v,) of a program that starts at rest at a finite `position` [rad | m]."""
    values = program.real.copy()
    values[program.starts] = position
    return values


@lru_cache(MOST_KEPT)
def compiled(structure: ProgramStructure) -> MachineCode:
    """Return the machine code of a program's structure; equal structures share one code."""
    name = f"{NAME}_{next(_serial)}"
    with global_compiler_lock:
        library = cpu_target.target_context.codegen().create_library(name)
        library.add_ir_module(_module(structure, name))
        library.finalize()
    return MachineCode(int(library.get_pointer_to_function(name)), library)


def _module(structure: ProgramStructure, name: str) -> ir.Module:
    address = ir.IntType(64)
    module = ir.Module(name)
    function = ir.Function(module, ir.FunctionType(REAL, [address, *[REAL] * len(PORTS)]), name)
    builder = ir.IRBuilder(function.append_basic_block())
    memory = builder.inttoptr(function.args[0], REAL.as_pointer())
    values = {
        index: given
        for index, given in zip(structure.inputs, function.args[1:], strict=True)
        if index >= 0
    }

    def at(index: int) -> ir.Value:
        if index not in values:
            values[index] = builder.load(_place(builder, memory, index))
        return values[index]

    for state, _ in structure.writes:  # load the states before any of them is written
        at(state)
    for operation, result, *operands in structure.code:
        if operation == op.DOT:
            products = [
                builder.fmul(at(c), at(x)) for c, x, _ in structure.terms[slice(*operands[:2])]
            ]
            values[result] = functools.reduce(builder.fadd, products)
        else:
            count = OPERANDS[operation]
            values[result] = _result(builder, operation, [at(index) for index in operands[:count]])
    nexts = [at(source) for _, source in structure.writes]
    for (state, _), value in zip(structure.writes, nexts, strict=True):
        builder.store(value, _place(builder, memory, state))
    builder.ret(at(structure.output))
    return module


def _place(builder: ir.IRBuilder, memory: ir.Value, index: int) -> ir.Value:
    return builder.gep(memory, [ir.IntType(64)(index)])


def _result(builder: ir.IRBuilder, operation: int, operands: list[ir.Value]) -> ir.Value:
    a = operands[0]
    b = operands[-1]
    if operation in (op.ADD, op.SUB, op.MUL):
        return {op.ADD: builder.fadd, op.SUB: builder.fsub, op.MUL: builder.fmul}[operation](a, b)
    if operation == op.NEG:
        return builder.fneg(a)
    if operation == op.ABS:
        return builder.select(builder.fcmp_ordered("<", a, ZERO), builder.fneg(a), a)
    if operation == op.MIN:
        return builder.select(builder.fcmp_ordered("<", b, a), b, a)
    if operation == op.MAX:
        return builder.select(builder.fcmp_ordered(">", b, a), b, a)
    if operation == op.SQRT:
        return _intrinsic(builder, "llvm.sqrt", a)
    if operation == op.SELECT:
        return builder.select(_is_true(builder, a), operands[1], operands[2])
    holds = {
        op.LT: lambda: builder.fcmp_ordered("<", a, b),
        op.LE: lambda: builder.fcmp_ordered("<=", a, b),
        op.AND: lambda: builder.and_(_is_true(builder, a), _is_true(builder, b)),
        op.OR: lambda: builder.or_(_is_true(builder, a), _is_true(builder, b)),
        op.NOT: lambda: builder.fcmp_ordered("==", a, ZERO),
        op.VALID: lambda: builder.fcmp_ordered("<", _intrinsic(builder, "llvm.fabs", a), INFINITE),
    }[operation]()
    return builder.uitofp(holds, REAL)


def _is_true(builder: ir.IRBuilder, value: ir.Value) -> ir.Value:
    return builder.fcmp_unordered("!=", value, ZERO)


def _intrinsic(builder: ir.IRBuilder, name: str, value: ir.Value) -> ir.Value:
    return builder.call(builder.module.declare_intrinsic(name, [REAL]), [value])
