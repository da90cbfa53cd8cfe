"""Simulation of a test on the rig: a reference for the position loop, or ramps up to breakaway.

An effort or drive value of sample k acts from sample k + `delay` on. Before sample `delay`, the
drive is 0. The results are the measured `position` (n,) and the `drive` (n,) at the samples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.engine.axis_motion import advance, drive_from_now
from frictool.engine.bench_position_loop import DERIVATIVE, INTEGRAL, PROPORTIONAL, REFERENCE_RATE
from frictool.engine.closed_loop import measure
from frictool.engine.status_codes import OK
from frictool.plant.axis import CONSTANT, ENCODER_STEP, POSITION, VELOCITY
from frictool.plant.position_load import with_load
from frictool.runtime.kernels import inner_kernel, kernel
from frictool.typing import IntVector, Vector


class ServoMemory(NamedTuple):
    """State of the bench's position loop.

    Its fields are the last measured position, the last reference and the effort of the integral
    term.
    """

    measured: float
    reference: float
    integral: float


@inner_kernel
def servo_effort(
    servo: Vector, memory: ServoMemory, reference: float, measured: float, period: float
) -> tuple[float, ServoMemory]:
    """Return the effort [N m | N] of the bench's position loop, and the loop's next state."""
    rate = (
        servo[REFERENCE_RATE] * (reference - memory.reference) - (measured - memory.measured)
    ) / period
    error = reference - measured
    integral = memory.integral + servo[INTEGRAL] * error * period
    return servo[PROPORTIONAL] * error + servo[DERIVATIVE] * rate + integral, ServoMemory(
        measured, reference, integral
    )


class RampProgress(NamedTuple):
    """Progress of a ramp test.

    - row: index of the next drive value
    - segment: number of the present segment (ramp), with the sign of its direction
    - start: encoder reading [rad | m] at the start of the segment
    """

    row: int
    segment: float
    start: float


@inner_kernel
def next_progress(
    progress: RampProgress,
    rows: int,
    segment: Vector,
    following: IntVector,
    turning: IntVector,
    rules: Vector,
    measured: float,
) -> RampProgress:
    """Return the progress after a sample; at the end of the test, the field `row` equals `rows`.

    - rows: number of drive values
    - measured: encoder reading at the sample

    `play_ramps` describes the other arguments.
    """
    row = progress.row
    if measured > rules[2] if progress.segment > 0.0 else measured < rules[1]:
        row = turning[max(row - 1, 0)]
    elif abs(measured - progress.start) >= rules[0] and segment[row] == progress.segment:
        row = following[row]
    if row < rows and segment[row] != progress.segment:
        return RampProgress(row, segment[row], measured)
    return RampProgress(row, progress.segment, progress.start)


@kernel
def play_reference(
    axis: Vector,
    load: Vector,
    state: Vector,
    servo: Vector,
    reference: Vector,
    period: float,
    delay: int,
    position: Vector,
    drive: Vector,
) -> int:
    """Simulate the axis under its position loop with the `reference` (n,); return a status.

    - axis: parameters (plant/axis.py)
    - load: array of the load (plant/position_load.py)
    - servo (5,): array of a `PositionServo`; the field `limit` is ignored, because the drive of the
      axis limits the effort

    `state` (7,) is changed in place, `position` and `drive` (n,) are filled. engine/status_codes.py
    lists the statuses.
    """
    p = with_load(axis, load)
    waiting = np.zeros(delay + 1)
    memory = ServoMemory(measure(state[POSITION], axis[ENCODER_STEP]), reference[0], 0.0)
    for k in range(reference.shape[0]):
        measured = measure(state[POSITION], axis[ENCODER_STEP])
        effort, memory = servo_effort(servo, memory, reference[k], measured, period)
        waiting[k % (delay + 1)] = effort / axis[CONSTANT]
        acting = waiting[(k + 1) % (delay + 1)]
        position[k] = measured
        drive[k] = drive_from_now(state, acting, axis)
        status = advance(state, acting, p, period)
        if status != OK:
            return status
    return OK


@kernel
def play_one_ramp(
    axis: Vector,
    state: Vector,
    direction: float,
    slope: float,
    top: float,
    pause: int,
    samples: int,
    period: float,
    turn: float,
    advance_on: float,
    extremes: Vector,
) -> tuple[bool, int]:
    """Simulate the axis under one ramp of the drive [A | V] in `direction` (1, -1).

    The drive is 0 for `pause` samples and then rises by `slope` per second up to `top`. The ramp
    ends after `samples` samples. With a finite `advance_on` [rad | m], the ramp ends earlier: when
    the axis has moved by `advance_on`, or has passed the position `direction` * `turn` [rad | m].
    `state` (7,) is changed in place. extremes (3,): lowest position, highest position and largest
    speed so far, updated. Returns True if the final position is beyond `direction` * `turn`, and a
    status of engine/status_codes.py.
    """
    start = state[POSITION]
    is_beyond = False
    for k in range(samples):
        command = direction * min(max(0, k - pause + 1) * slope * period, top)
        status = advance(state, command, axis, period)
        if status != OK:
            return False, status
        extremes[0] = min(extremes[0], state[POSITION])
        extremes[1] = max(extremes[1], state[POSITION])
        extremes[2] = max(extremes[2], abs(state[VELOCITY]))
        is_beyond = direction * state[POSITION] > turn
        if advance_on < math.inf and (is_beyond or abs(state[POSITION] - start) >= advance_on):
            break
    return is_beyond, OK


@kernel
def play_ramps(
    axis: Vector,
    load: Vector,
    state: Vector,
    rows: Vector,
    segment: Vector,
    following: IntVector,
    turning: IntVector,
    rules: Vector,
    period: float,
    delay: int,
    position: Vector,
    drive: Vector,
    played: IntVector,
) -> int:
    """Apply the drive values `rows` (n,) of a ramp test; fill `position` and `drive` (n,).

    - segment (n,): number of the segment of each value; its sign is the direction
    - following (n,): index of the first value of the next segment
    - turning (n,): index of the first value of the next segment in the opposite direction
    - rules (3,) [rad | m]: displacement after which a segment ends; lower and upper position at
      which the direction changes
    - played (1,): set to the number of values applied

    An index is n if there is no such segment. Returns a status of engine/status_codes.py.
    """
    p = with_load(axis, load)
    waiting = np.zeros(delay + 1)
    progress = RampProgress(0, segment[0], measure(state[POSITION], axis[ENCODER_STEP]))
    for k in range(rows.shape[0]):
        measured = measure(state[POSITION], axis[ENCODER_STEP])
        progress = next_progress(
            progress, rows.shape[0], segment, following, turning, rules, measured
        )
        if progress.row == rows.shape[0]:
            return OK
        waiting[k % (delay + 1)] = rows[progress.row]
        acting = waiting[(k + 1) % (delay + 1)]
        position[k] = measured
        drive[k] = drive_from_now(state, acting, axis)
        played[0] = k + 1
        progress = RampProgress(progress.row + 1, progress.segment, progress.start)
        status = advance(state, acting, p, period)
        if status != OK:
            return status
        if progress.row == rows.shape[0]:
            return OK
    return OK
