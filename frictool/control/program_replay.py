"""Replay of a program over recorded samples, with a record of values of its nodes."""

from __future__ import annotations

from frictool.control.compiled_program import (
    FIXED,
    FLOAT,
    CompiledProgram,
    control_step,
    run_values,
)
from frictool.control.fixed_point_kernel import to_real
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import IntVector, Vector


@kernel
def record_along(
    machine: CompiledProgram,
    inputs: IntVector,
    samples: Vector,
    states: IntVector,
    others: IntVector,
    values: Vector,
) -> None:
    """Run a program in double arithmetic over n samples, and record values of its nodes.

    - machine: program, changed in place
    - inputs (i,): indices of the input nodes
    - samples (n, i): values of the inputs
    - states (s,), others (o,): indices of the nodes to record
    - values (n, s + o): filled with the nodes `states` before each sample in the first s columns,
      and with the nodes `others` after the sample in the other columns
    """
    for k in range(samples.shape[0]):
        for column in range(inputs.shape[0]):
            machine.real[inputs[column]] = samples[k, column]
        for column in range(states.shape[0]):
            values[k, column] = machine.real[states[column]]
        run_values(machine.code, machine.terms, machine.writes, machine.real)
        for column in range(others.shape[0]):
            values[k, states.shape[0] + column] = machine.real[others[column]]


@kernel
def value_along(
    machine: CompiledProgram,
    index: int,
    reference: Vector,
    position: Vector,
    velocity: Vector,
    values: Vector,
) -> None:
    """Run a controller over n samples, and record the value [SI] of one node in `values` (n,).

    - machine: program in any number format, changed in place
    - index: index of the node
    - reference, position, velocity (n,): inputs of the controller
    """
    for k in range(reference.shape[0]):
        control_step(machine, reference[k], position[k], velocity[k])
        values[k] = _value(machine, index)


@bare_kernel
def _value(machine: CompiledProgram, index: int) -> float:
    if machine.number == FIXED:
        return to_real(machine.formats[index], machine.word[index])
    if machine.number == FLOAT:
        return float(machine.single[index])
    return float(machine.real[index])
