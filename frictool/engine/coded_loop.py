"""Closed loop of engine/closed_loop.py whose controller is machine code (control/machine_code.py).

The record is that of `closed_loop.run`, bit by bit; a sample of the controller takes a sixth of the
time of the interpreted program.
"""

from __future__ import annotations

import numpy as np

from frictool.control.compiled_program import CompiledProgram
from frictool.engine.closed_loop import advance_sample, encoder_reading, measure
from frictool.engine.mechanism.address_calls import FLOAT, INTEGER, call_by_address, function_type
from frictool.engine.status_codes import OK
from frictool.plant import axis as ax
from frictool.plant.position_load import with_load
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

control_sample = call_by_address(function_type(FLOAT, INTEGER, FLOAT, FLOAT, FLOAT))


@kernel
def run_coded(
    axis: Vector,
    state: Vector,
    controller: CompiledProgram,
    code: int,
    reference: Vector,
    period: float,
    delay_samples: int,
    record: Vector,
    load: Vector,
    conditions: Vector,
) -> int:
    """Simulate the loop as `closed_loop.run` does, with the controller's machine code.

    code: address of the code of `controller` (machine_code.MachineCode), which reads and writes the
    values of `controller` in place.
    """
    axis = with_load(axis, load)
    p = axis.copy()
    waiting = np.zeros(delay_samples + 1)
    memory = np.int64(controller.real.ctypes.data)
    measured = measure(state[ax.POSITION], axis[ax.ENCODER_STEP])
    for k in range(reference.shape[0]):
        measured = encoder_reading(axis, state, measured, conditions, k)
        command = control_sample(code, memory, reference[k], measured, state[ax.VELOCITY])
        status = advance_sample(
            axis, state, p, waiting, k, measured, command, period, record[k], conditions
        )
        if status != OK:
            return status
    return OK
