"""Samples of a controller while the axis rests and the encoder reading is constant."""

from __future__ import annotations

from frictool.control.compiled_program import CompiledProgram, control_step
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def still_samples(
    machine: CompiledProgram,
    reference: Vector,
    first: int,
    position: float,
    bounds: Vector,
    commands: Vector,
) -> int:
    """Run the controller from sample `first` on, as long as its command cannot move the axis.

    `position` is the constant encoder reading. `bounds` (2,) are the lowest and the highest drive
    at which the axis stays at rest. The commands are written to `commands` (n,), including the
    first command outside the bounds. Return the index of the first command outside the bounds, or n
    if there is none.
    """
    for k in range(first, reference.shape[0]):
        commands[k] = control_step(machine, reference[k], position, 0.0)
        if not (bounds[0] < commands[k] < bounds[1]):
            return k
    return int(reference.shape[0])
