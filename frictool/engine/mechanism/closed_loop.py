"""Mechanism in closed loop with a sampled controller, or with sources that follow signals.

    sample k:  sensor's block --[encoder]--> y[k] --[controller]--> u[k] --[delay_samples]-->
    controlled source, constant until k + 1

engine/closed_loop.py describes the loop. A sample period is divided into parts with constant inputs
(`MechanismInputs`). The drive limit of a winding changes with speed; each part is then divided into
PARTS intervals with constant limits. Drifts change parameters of the mechanism from sample to
sample (`DriftedNumbers`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.control.compiled_program import CompiledProgram as Controller
from frictool.control.compiled_program import control_step
from frictool.engine.closed_loop import (
    COMMAND,
    LOAD,
    MEASURED,
    PARTS,
    TRUE_DRIVE,
    TRUE_MODE,
    TRUE_POSITION,
    TRUE_VELOCITY,
    measure,
)
from frictool.engine.disturbances_and_faults import faulty, true_command
from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.event_driven_motion import TOLERANCE, advance
from frictool.engine.mechanism.events import EventRows
from frictool.engine.mechanism.sources import source_limits
from frictool.engine.mechanism.state import MechanismState
from frictool.engine.status_codes import OK
from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Vector

Modes = NDArray[np.int8]

NOBODY = -1  # value of `source` if no source is controlled


class ControlPorts(NamedTuple):
    """Indices of the controlled source, of the sensor's block and of the load's block.

    - source: index of the controlled source, NOBODY if there is none
    - step: encoder resolution [rad | m]

    The load's position q is recorded in the coordinate of the sensor: sensor_start +
    (q - load_start)/load_ratio.
    """

    source: int
    sensor: int
    load: int
    step: float
    sensor_start: float
    load_start: float
    load_ratio: float


class MechanismInputs(NamedTuple):
    """Inputs of a mechanism; they are constant in each part of a sample period.

    - first (n + 1,): index of the first part of each of the n samples; the last entry is the number
      m of all parts
    - durations (m,) [s]: durations of the parts
    - drives (m, u): commands of the u sources [A | V | N m | N], or (0, u) if all commands are zero
    - blocks (d,): indices of the blocks on which `efforts` act
    - efforts (m, d): efforts [N m | N], or (0, d) if all are zero
    """

    first: IntVector
    durations: Vector
    drives: Vector
    blocks: IntVector
    efforts: Vector


class DriftedNumbers(NamedTuple):
    """Conditions at each sample, and the mechanism's parameters that the conditions multiply.

    - conditions (n, 8): rows of engine/disturbances_and_faults.py; (0, 8) without conditions
    - limit: limit of the controlled drive, as measured by the sensor of the drive

    At sample k, machine.numbers[indices[i]] is values[i] times conditions[k, columns[i]].
    """

    conditions: Vector
    indices: IntVector
    columns: IntVector
    values: Vector
    limit: float


class MechanismRecord(NamedTuple):
    """Arrays that are filled at every sample.

    - record (n, 7): columns of engine/closed_loop.py
    - motion (n, 2 b + u): positions and speeds of the b blocks, drives of the u sources
    - modes (n, m): the m modes of engine/mechanism/state.py
    - events (e, 4): rows of engine/mechanism/events.py
    - happened (1,): number of events
    """

    record: Vector
    motion: Vector
    modes: Modes
    events: Vector
    happened: IntVector


@kernel
def flowing(
    machine: CompiledMechanism, state: MechanismState, source: int, command: float
) -> float:
    """Return the present drive of a source; without a lag, this is the limited `command`."""
    k, p = machine.whole, machine.numbers
    low, high = source_limits(k, p, source, state.y)
    return float(
        min(
            max(state.drive[source] if ly.lag(p, ly.source_row(k, source)) > 0.0 else command, low),
            high,
        )
    )


@kernel
def encoder_reading(
    ports: ControlPorts, state: MechanismState, last: float, conditions: Vector, k: int
) -> float:
    """Return the encoder's reading [rad | m] at sample k; a stuck encoder repeats `last`."""
    reported = measure(state.y[ports.sensor], ports.step)
    return (
        faulty(reported, ports.step, last, conditions[k]) if conditions.shape[0] > 0 else reported
    )


@kernel
def _write(
    machine: CompiledMechanism,
    state: MechanismState,
    ports: ControlPorts,
    k: int,
    drives: Vector,
    out: MechanismRecord,
) -> None:
    n, u = machine.whole[ly.BLOCKS], machine.whole[ly.SOURCES]
    for i in range(2 * n):
        out.motion[k, i] = state.y[i]
    for s in range(u):
        out.motion[k, 2 * n + s] = flowing(machine, state, s, drives[s])
    for i in range(state.modes.shape[0]):
        out.modes[k, i] = state.modes[i]
    row = out.record[k]
    row[TRUE_POSITION] = state.y[ports.sensor]
    row[TRUE_VELOCITY] = state.y[n + ports.sensor]
    row[LOAD] = ports.sensor_start + (state.y[ports.load] - ports.load_start) / ports.load_ratio
    row[TRUE_MODE] = state.modes[ports.sensor]


@kernel
def advance_sample(
    machine: CompiledMechanism,
    state: MechanismState,
    ports: ControlPorts,
    k: int,
    closed: bool,
    acting: float,
    inputs: MechanismInputs,
    drifting: DriftedNumbers,
    out: MechanismRecord,
) -> int:
    """Record sample k in `out` and advance to sample k + 1; return a status code.

    closed: True if `acting` is the command of the controlled source, False if the sources follow
    `inputs` only.
    """
    n, u = machine.whole[ly.BLOCKS], machine.whole[ly.SOURCES]
    drives = np.zeros(u)
    external = np.zeros(n)
    cuts = 1
    for s in range(u):
        if ly.resistance(machine.numbers, ly.source_row(machine.whole, s)) > 0.0:
            cuts = PARTS
    if drifting.conditions.shape[0] > 0:
        for i in range(drifting.indices.shape[0]):
            machine.numbers[drifting.indices[i]] = (
                drifting.values[i] * drifting.conditions[k, drifting.columns[i]]
            )
    for part in range(inputs.first[k], inputs.first[k + 1]):
        for s in range(u if inputs.drives.shape[0] > 0 else 0):
            drives[s] = inputs.drives[part, s]
        if closed:
            drives[ports.source] = acting
        if ports.source != NOBODY and drifting.conditions.shape[0] > 0:
            drives[ports.source] = true_command(
                drives[ports.source], drifting.limit, drifting.conditions[k]
            )
        for d in range(inputs.blocks.shape[0]):
            external[inputs.blocks[d]] = inputs.efforts[part, d]
        if part == inputs.first[k]:
            _write(machine, state, ports, k, drives, out)
        for _ in range(cuts):
            status = advance(
                machine,
                state,
                drives,
                external,
                inputs.durations[part] / cuts,
                TOLERANCE,
                EventRows(out.events, out.happened),
            )
            if status != OK:
                return int(status)
    return OK


@kernel
def advance_controlled_sample(
    machine: CompiledMechanism,
    state: MechanismState,
    ports: ControlPorts,
    waiting: Vector,
    k: int,
    measured: float,
    command: float,
    inputs: MechanismInputs,
    drifting: DriftedNumbers,
    out: MechanismRecord,
) -> int:
    """Apply the command of sample k, fill the rows of `out`, and advance to sample k + 1.

    waiting (delay_samples + 1,): commands that do not act yet, updated. Returns a status of
    engine/status_codes.py.
    """
    slots = waiting.shape[0]
    waiting[k % slots] = command
    acting = waiting[(k + 1) % slots]
    out.record[k, MEASURED], out.record[k, COMMAND] = measured, command
    status = advance_sample(machine, state, ports, k, True, acting, inputs, drifting, out)
    out.record[k, TRUE_DRIVE] = out.motion[k, 2 * machine.whole[ly.BLOCKS] + ports.source]
    return int(status)


@kernel
def run(
    machine: CompiledMechanism,
    state: MechanismState,
    controller: Controller,
    ports: ControlPorts,
    reference: Vector,
    begin: int,
    end: int,
    waiting: Vector,
    shown: Vector,
    inputs: MechanismInputs,
    drifting: DriftedNumbers,
    out: MechanismRecord,
) -> tuple[int, int]:
    """Simulate samples begin .. end - 1 of the loop over `reference` (n,), and fill `out`.

    Changed in place: machine, state, controller (control/compiled_program.py, initialised at the
    measured position), waiting (delay_samples + 1,), and shown (1,), the last reading of the
    encoder. Returns a status of engine/status_codes.py, and the sample reached.
    """
    for k in range(begin, end):
        shown[0] = encoder_reading(ports, state, shown[0], drifting.conditions, k)
        command = control_step(
            controller, reference[k], shown[0], state.y[machine.whole[ly.BLOCKS] + ports.sensor]
        )
        status = advance_controlled_sample(
            machine, state, ports, waiting, k, shown[0], command, inputs, drifting, out
        )
        if status != OK:
            return int(status), k
    return OK, end


@kernel
def follow(
    machine: CompiledMechanism,
    state: MechanismState,
    ports: ControlPorts,
    begin: int,
    end: int,
    shown: Vector,
    inputs: MechanismInputs,
    drifting: DriftedNumbers,
    out: MechanismRecord,
) -> tuple[int, int]:
    """Simulate as `run` does, but without a controller; the sources follow `inputs`."""
    for k in range(begin, end):
        shown[0] = encoder_reading(ports, state, shown[0], drifting.conditions, k)
        out.record[k, MEASURED] = shown[0]
        status = advance_sample(machine, state, ports, k, False, 0.0, inputs, drifting, out)
        if ports.source != NOBODY:
            out.record[k, COMMAND] = (
                inputs.drives[inputs.first[k], ports.source] if inputs.drives.shape[0] > 0 else 0.0
            )
            out.record[k, TRUE_DRIVE] = out.motion[k, 2 * machine.whole[ly.BLOCKS] + ports.source]
        if status != OK:
            return int(status), k
    return OK, end
