"""Programs run along measured samples: inputs from arrays, values into arrays."""

from __future__ import annotations

from frictool.control.compiled_program import CompiledProgram, control_step, read, run_values
from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Vector


@kernel
def record_along(
    machine: CompiledProgram,
    inputs: IntVector,
    given: Vector,
    states: IntVector,
    others: IntVector,
    found: Vector,
) -> None:
    """Run a program in double, in place, over given (n, i), one column per index in `inputs`.

    The results go to found (n, s + o). The columns of the states (s,) hold their values before the
    sample updates them; the columns of the other indices (o,) hold the values that the sample
    computes.
    """
    for k in range(given.shape[0]):
        for column in range(inputs.shape[0]):
            machine.real[inputs[column]] = given[k, column]
        for column in range(states.shape[0]):
            found[k, column] = machine.real[states[column]]
        run_values(machine.code, machine.terms, machine.writes, machine.real)
        for column in range(others.shape[0]):
            found[k, states.shape[0] + column] = machine.real[others[column]]


@kernel
def value_along(
    machine: CompiledProgram,
    place: int,
    reference: Vector,
    position: Vector,
    velocity: Vector,
    found: Vector,
) -> None:
    """Write the value at index `place` [SI] of a controller, in any number format, to found (n,).

    `reference`, `position` and `velocity` (n,) are its inputs at each sample.
    """
    for k in range(reference.shape[0]):
        control_step(machine, reference[k], position[k], velocity[k])
        found[k] = read(machine, place)
