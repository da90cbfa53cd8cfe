"""Sampled controller and axis in closed loop: controller at every sample, axis motion in between.

    sample k:  position --[encoder: floor(x/step) step]--> y[k] --[controller]--> u[k]
    --[delay_samples]--> constant until k+1

The reading of an incremental encoder is the position, rounded down to a multiple of its step. The
command of sample k acts from sample k + delay_samples on. Before the first command acts, the drive
is zero. The controller limits the command, and the axis limits the drive. A drive without lag jumps
at a sample; the record contains the drive after the jump.

A load that depends on position (plant/position_load.py) is part of the integrated equations. At
rest neither position nor load changes, so that the position of an axis at rest is exactly constant.
The current limit of a winding (plant/axis.py) is updated PARTS times per period, with the present
speed. Each sample has one row of disturbances, drifts and faults
(engine/disturbances_and_faults.py). A speed sensor, if the controller uses one, measures the true
speed at the sample.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.control.compiled_program import CompiledProgram, control_step
from frictool.engine.axis_friction import is_straight
from frictool.engine.axis_motion import advance_axis, drive_from_now
from frictool.engine.disturbances_and_faults import (
    changes_parameters,
    faulty,
    impose,
    true_command,
)
from frictool.engine.status_codes import OK
from frictool.plant import axis as ax
from frictool.plant.position_load import with_load
from frictool.runtime.kernels import inner_kernel, kernel
from frictool.typing import Vector

# columns of the record; each row contains the values at one sample
MEASURED, TRUE_POSITION, TRUE_VELOCITY, LOAD, COMMAND, TRUE_DRIVE, TRUE_MODE = 0, 1, 2, 3, 4, 5, 6
RECORD_SIZE = 7

PARTS = 4  # parts of a period for an axis with a winding


@kernel
def measure(position: float, step: float) -> float:
    """Return the encoder's reading [rad | m] of a position; step 0 means no quantisation."""
    return math.floor(position / step) * step if step > 0.0 else position


def load_of_run(axis: Vector, load: Vector) -> Vector | None:
    """Return the load to pass to `run` for an axis with parameters (a,) and a load (l,).

    The result is None if every slip has a closed form; `run` is then compiled without the
    integrators.
    """
    return None if is_straight(axis, load) else load


@kernel
def run(
    axis: Vector,
    state: Vector,
    controller: CompiledProgram,
    reference: Vector,
    period: float,
    delay_samples: int,
    record: Vector,
    load: Vector | None,
    conditions: Vector,
) -> int:
    """Simulate the loop over `reference` (n,), one value per `period` [s]; fill `record` (n, 7).

    - axis (a,), state (7,): parameters and state of the axis (plant/axis.py)
    - controller: array of control/compiled_program.py, initialised at the measured position
    - load: array of plant/position_load.py; None if every slip has a closed form (`load_of_run`)
    - conditions (n, 8): rows of engine/disturbances_and_faults.py; (0, 8) without conditions

    State and controller are changed in place.

    Returns a status of engine/status_codes.py. If the status is not OK, the record is filled up to
    the failing sample.
    """
    if load is not None:
        axis = with_load(axis, load)
    p = axis.copy()
    waiting = np.zeros(delay_samples + 1)
    measured = measure(state[ax.POSITION], axis[ax.ENCODER_STEP])
    for k in range(reference.shape[0]):
        measured = encoder_reading(axis, state, measured, conditions, k)
        command = control_step(controller, reference[k], measured, state[ax.VELOCITY])
        status = advance_sample(
            axis, state, p, waiting, k, measured, command, period, record[k], load, conditions
        )
        if status != OK:
            return status
    return OK


@inner_kernel
def encoder_reading(axis: Vector, state: Vector, last: float, conditions: Vector, k: int) -> float:
    """Return the encoder's reading [rad | m] at sample k; a stuck encoder repeats `last`."""
    reported = measure(state[ax.POSITION], axis[ax.ENCODER_STEP])
    return (
        faulty(reported, axis[ax.ENCODER_STEP], last, conditions[k])
        if conditions.shape[0] > 0
        else reported
    )


@inner_kernel
def advance_sample(
    axis: Vector,
    state: Vector,
    p: Vector,
    waiting: Vector,
    k: int,
    measured: float,
    command: float,
    period: float,
    row: Vector,
    load: Vector | None,
    conditions: Vector,
) -> int:
    """Apply the command of sample k, fill the record's row (7,), and advance to sample k + 1.

    - axis (a,): parameters without drifts, followed by the load (plant/position_load.py
      `with_load`)
    - p (a,): parameters with the drifts of sample k - 1, updated to sample k
    - waiting (delay_samples + 1,): commands that do not act yet, updated
    - load: None if every slip has a closed form

    Returns a status of engine/status_codes.py.
    """
    acting, _ = begin_sample(axis, state, p, waiting, k, measured, command, row, conditions)
    parts = PARTS if axis[ax.RESISTANCE] > 0.0 else 1
    part = period / parts
    for _ in range(parts):
        if load is None:
            status = advance_axis(state, acting, p, None, part)
        else:
            status = advance_axis(state, acting, p, p, part)
        if status != OK:
            return status
    return OK


@inner_kernel
def begin_sample(
    axis: Vector,
    state: Vector,
    p: Vector,
    waiting: Vector,
    k: int,
    measured: float,
    command: float,
    row: Vector,
    conditions: Vector,
) -> tuple[float, bool]:
    """Fill the record's row (7,) of sample k; return the acting command, and True if `p` changed.

    `advance_sample` describes the arguments.
    """
    slots = waiting.shape[0]
    waiting[k % slots] = command
    acting = waiting[(k + 1) % slots]
    changed = False
    if conditions.shape[0] > 0:
        changed = k == 0 or changes_parameters(conditions[k - 1], conditions[k])
        if changed:
            impose(axis, p, conditions[k])
        acting = true_command(acting, axis[ax.DRIVE_LIMIT], conditions[k])
    row[MEASURED] = measured
    row[TRUE_POSITION] = state[ax.POSITION]
    row[TRUE_VELOCITY] = state[ax.VELOCITY]
    row[LOAD] = state[ax.LOAD_POSITION]
    row[COMMAND] = command
    row[TRUE_DRIVE] = drive_from_now(state, acting, p)
    row[TRUE_MODE] = state[ax.MODE]
    return acting, changed
