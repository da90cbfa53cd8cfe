"""Closed loop of engine/closed_loop.py, with a controller compiled by control/machine_code.py.

The record equals the record of `closed_loop.run` bit by bit.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine.axis_motion import advance_axis, is_held, rest_on
from frictool.engine.closed_loop import PARTS, begin_sample, encoder_reading, measure
from frictool.engine.mechanism.address_calls import FLOAT, INTEGER, call_by_address, function_type
from frictool.engine.status_codes import OK
from frictool.plant import axis as ax
from frictool.plant.position_load import with_load
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

control_sample = call_by_address(function_type(FLOAT, INTEGER, FLOAT, FLOAT, FLOAT))


@kernel
def replay_coded(
    controller: Vector,
    code: int,
    reference: Vector,
    position: Vector,
    velocity: Vector,
    returned: Vector,
) -> None:
    """Run a controller's machine code over recorded samples; write its commands to `returned` (n,).

    - controller (v,): values of the controller's program, changed in place
    - code: address of the machine code (machine_code.MachineCode)
    - reference, position, velocity (n,): inputs of the controller
    """
    memory = np.int64(controller.ctypes.data)
    for k in range(reference.shape[0]):
        returned[k] = control_sample(code, memory, reference[k], position[k], velocity[k])


@kernel
def run_coded(
    axis: Vector,
    state: Vector,
    controller: Vector,
    code: int,
    reference: Vector,
    period: float,
    delay_samples: int,
    record: Vector,
    load: Vector | None,
    conditions: Vector,
) -> int:
    """Simulate the loop as `closed_loop.run` does, with the controller's machine code.

    - controller (v,): values of the program (machine_code.started_values), changed in place
    - code: address of the machine code (machine_code.MachineCode)
    """
    if load is not None:
        axis = with_load(axis, load)
    p = axis.copy()
    waiting = np.zeros(delay_samples + 1)
    memory = np.int64(controller.ctypes.data)
    measured = measure(state[ax.POSITION], axis[ax.ENCODER_STEP])
    parts = PARTS if axis[ax.RESISTANCE] > 0.0 else 1
    decay = math.exp(-period / axis[ax.LAG]) if axis[ax.LAG] > 0.0 else 0.0
    held = False  # True if the axis is at rest and stays at rest as long as the drive is `last`
    last = 0.0
    for k in range(reference.shape[0]):
        measured = encoder_reading(axis, state, measured, conditions, k)
        command = control_sample(code, memory, reference[k], measured, state[ax.VELOCITY])
        acting, changed = begin_sample(
            axis, state, p, waiting, k, measured, command, record[k], conditions
        )
        if held and acting == last and not changed:
            rest_on(state, acting, p, period, decay)
            continue
        for _ in range(parts):
            if load is None:
                status = advance_axis(state, acting, p, None, period / parts)
            else:
                status = advance_axis(state, acting, p, p, period / parts)
            if status != OK:
                return status
        held = is_held(state, acting, p)
        last = acting
    return OK
