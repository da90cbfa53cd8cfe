"""Simulation of a bench test on a mechanism; engine/bench_experiment.py describes the tests."""

from __future__ import annotations

import numpy as np

from frictool.engine.bench_experiment import RampProgress, ServoMemory, next_progress, servo_effort
from frictool.engine.closed_loop import MEASURED, TRUE_DRIVE, measure
from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.closed_loop import (
    ControlPorts,
    DriftedNumbers,
    MechanismInputs,
    MechanismRecord,
    advance_controlled_sample,
)
from frictool.engine.mechanism.state import MechanismState
from frictool.engine.status_codes import OK
from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Vector


@kernel
def play_reference(
    machine: CompiledMechanism,
    state: MechanismState,
    ports: ControlPorts,
    servo: Vector,
    reference: Vector,
    period: float,
    delay: int,
    inputs: MechanismInputs,
    drifting: DriftedNumbers,
    out: MechanismRecord,
    position: Vector,
    drive: Vector,
) -> int:
    """Simulate a mechanism under the bench's position loop with the `reference` (n,).

    - servo (5,): array of a `PositionServo`
    - ports, inputs, drifting, out: records of engine/mechanism/closed_loop.py; `inputs` must
      contain no signals, and `drifting` no drifts

    `position` and `drive` (n,) are filled. Returns a status of engine/status_codes.py.
    """
    constant = ly.constant(machine.numbers, ly.source_row(machine.whole, ports.source))
    waiting = np.zeros(delay + 1)
    memory = ServoMemory(measure(state.y[ports.sensor], ports.step), reference[0], 0.0)
    for k in range(reference.shape[0]):
        measured = measure(state.y[ports.sensor], ports.step)
        effort, memory = servo_effort(servo, memory, reference[k], measured, period)
        status = advance_controlled_sample(
            machine, state, ports, waiting, k, measured, effort / constant, inputs, drifting, out
        )
        position[k], drive[k] = out.record[k, MEASURED], out.record[k, TRUE_DRIVE]
        if status != OK:
            return int(status)
    return OK


@kernel
def play_ramps(
    machine: CompiledMechanism,
    state: MechanismState,
    ports: ControlPorts,
    rows: Vector,
    segment: Vector,
    following: IntVector,
    turning: IntVector,
    rules: Vector,
    delay: int,
    inputs: MechanismInputs,
    drifting: DriftedNumbers,
    out: MechanismRecord,
    position: Vector,
    drive: Vector,
    played: IntVector,
) -> int:
    """Apply the drive values `rows` (n,) of a ramp test to a mechanism.

    segment, following, turning, rules, delay: as in `play_ramps` of engine/bench_experiment.py.
    `play_reference` describes the other arguments. `position` and `drive` (n,) are filled; played
    (1,) is set to the number of applied values. Returns a status of engine/status_codes.py.
    """
    waiting = np.zeros(delay + 1)
    progress = RampProgress(0, segment[0], measure(state.y[ports.sensor], ports.step))
    for k in range(rows.shape[0]):
        measured = measure(state.y[ports.sensor], ports.step)
        progress = next_progress(
            progress, rows.shape[0], segment, following, turning, rules, measured
        )
        if progress.row == rows.shape[0]:
            return OK
        status = advance_controlled_sample(
            machine, state, ports, waiting, k, measured, rows[progress.row], inputs, drifting, out
        )
        position[k], drive[k] = out.record[k, MEASURED], out.record[k, TRUE_DRIVE]
        played[0] = k + 1
        progress = RampProgress(progress.row + 1, progress.segment, progress.start)
        if status != OK:
            return int(status)
        if progress.row == rows.shape[0]:
            return OK
    return OK
