"""Speed that a controller used at each sample of a run, from a second run of its program.

The first run does not record the speed, because this would slow down every loop. A program is
deterministic. The second run has the same number format, references and positions as the first,
also for exported code, so that both have the same speeds bit by bit.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from frictool.control.compiled_program import CompiledProgram, copy_program, hold, start_at
from frictool.control.program_replay import value_along
from frictool.engine.closed_loop import MEASURED, TRUE_POSITION, TRUE_VELOCITY, measure
from frictool.typing import Vector


def controller_speed(
    running: CompiledProgram,
    index: int,
    reference: Vector,
    record: Vector,
    step: float,
    known: Mapping[int, float],
) -> Vector:
    """Return the speed [rad/s | m/s] (n,) that a controller used in a run.

    `index`: index of the speed in the program. `reference` (n,), `record` (n, 7): reference and
    record of the run. `step`: encoder step [rad | m]. `known`: scheduled parameters by state index.
    """
    again = copy_program(running)
    for parameter, value in known.items():
        hold(again, parameter, value)
    speed = np.empty(reference.size)
    if reference.size:
        start_at(again, measure(float(record[0, TRUE_POSITION]), step))
        position, velocity = (
            np.ascontiguousarray(record[:, column]) for column in (MEASURED, TRUE_VELOCITY)
        )
        value_along(again, index, reference, position, velocity, speed)
    return speed
