"""Replay of a program over recorded samples: inputs from arrays, values into arrays."""

from __future__ import annotations

from frictool.control.compiled_program import CompiledProgram, control_step, read, run_values
from frictool.runtime.kernels import kernel
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
    """Run a program in double, in place, over `samples` (n, i), one column per index in `inputs`.

    The results go to `values` (n, s + o). The columns of the states (s,) hold their values before
    the sample updates them; the columns of the other indices (o,) hold the values that the sample
    computes.
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
    """Write one value of a controller at each sample to `values` (n,) [SI].

    index: index of the value in the program, which may have any number format. reference, position,
    velocity (n,): inputs of the controller.
    """
    for k in range(reference.shape[0]):
        control_step(machine, reference[k], position[k], velocity[k])
        values[k] = read(machine, index)
