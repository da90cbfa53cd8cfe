"""A program along measured samples: its inputs from arrays, what it finds at named places into
arrays. In double, as a log is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.control.compiled_program import CompiledProgram, control_step, read, run_values
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]


@kernel
def record_along(
    machine: CompiledProgram,
    inputs: Places,
    given: Vector,
    states: Places,
    others: Places,
    found: Vector,
) -> None:
    """Runs a machine of double precision, in place, over given (n, i), a column for each of the
    places `inputs` (i,).

    Fills found (n, s + o): the columns of the states (s,), which a sample moves, are as they are at
    that sample; then the other places (o,), as the sample makes them.
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
    """Fills found (n,) with the value at `place` [SI] of a controller in any number format, along
    what it is given (n,) at each sample."""
    for k in range(reference.shape[0]):
        control_step(machine, reference[k], position[k], velocity[k])
        found[k] = read(machine, place)
