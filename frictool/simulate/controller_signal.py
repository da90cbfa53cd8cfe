"""Value of a controller at each sample of a run, from a second run of its program.

The first run does not record inner values, because this would slow down every loop. A program is
deterministic. The second run has the same number format, references and positions as the first,
also for exported code, so that both have the same values bit by bit.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from frictool.control.compiled_program import CompiledProgram, copy_program, hold, read, start_at
from frictool.control.program import ProgramNode
from frictool.control.program_replay import value_along
from frictool.engine.closed_loop import MEASURED, TRUE_POSITION, TRUE_VELOCITY, measure
from frictool.typing import Vector


def controller_signal(
    running: CompiledProgram,
    node: ProgramNode,
    reference: Vector,
    record: Vector,
    step: float,
    known: Mapping[int, float],
) -> Vector:
    """Return the value [SI] (n,) of a node of a controller's program at each sample of a run.

    A state has the value that it has before the sample updates it. `reference` (n,), `record` (n,
    7): reference and record of the run. `step`: encoder step [rad | m]. `known`: scheduled
    parameters by state index.
    """
    again = copy_program(running)
    for parameter, value in known.items():
        hold(again, parameter, value)
    values = np.empty(reference.size)
    if reference.size:
        start_at(again, measure(float(record[0, TRUE_POSITION]), step))
        position, velocity = (
            np.ascontiguousarray(record[:, column]) for column in (MEASURED, TRUE_VELOCITY)
        )
        first = read(again, node.index)
        value_along(again, node.index, reference, position, velocity, values)
        if node.op == "state":
            values[1:] = values[:-1].copy()
            values[0] = first
    return values
