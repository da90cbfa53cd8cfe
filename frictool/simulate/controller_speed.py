"""What a controller took for the speed at each sample of a run: its program once more, along what
it was given.

A machine is deterministic, so that on the same references and positions it goes through the same
values; reading one of them while the loop runs would cost every loop for it. The format is that of
the run, the exported code's where that ran: its values are the same bit by bit.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from frictool.control.compiled_program import CompiledProgram, copy_program, hold, start_at
from frictool.control.program_recording import value_along
from frictool.engine.closed_loop import MEASURED, TRUE_POSITION, TRUE_VELOCITY, measure

Vector = NDArray[np.float64]


def controller_speed(
    running: CompiledProgram,
    place: int,
    reference: Vector,
    record: Vector,
    step: float,
    told: Mapping[int, float],
) -> Vector:
    """The value at `place` (n,) [rad/s | m/s] along `reference` (n,) and a run's record (n, 7).

    step: the encoder's [rad | m]. told: the scheduled parameters' values, by their places.
    """
    again = copy_program(running)
    for parameter, value in told.items():
        hold(again, parameter, value)
    found = np.empty(reference.size)
    if reference.size:
        start_at(again, measure(float(record[0, TRUE_POSITION]), step))
        position, velocity = (
            np.ascontiguousarray(record[:, column]) for column in (MEASURED, TRUE_VELOCITY)
        )
        value_along(again, place, reference, position, velocity, found)
    return found
