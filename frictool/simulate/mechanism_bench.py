"""Mechanism as a plant on which a bench plays tests of `frictool excite`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictool.engine.closed_loop import RECORD_SIZE
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.bench_experiment import play_ramps, play_reference
from frictool.engine.mechanism.closed_loop import (
    ControlPorts,
    DriftedNumbers,
    MechanismInputs,
    MechanismRecord,
)
from frictool.engine.mechanism.events import EVENT_SIZE
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import MechanismState, rest
from frictool.errors import NoSolutionError
from frictool.simulate.bench_experiment import RampRows
from frictool.simulate.mechanism_inputs import inputs_of
from frictool.simulate.mechanism_plant import MechanismPlant, ports_of
from frictool.simulate.mechanism_rig import block_positions
from frictool.typing import IntVector, Vector


class PreparedBenchRun(NamedTuple):
    """Arguments of the kernels in engine/mechanism/bench_experiment.py, for a start at rest."""

    machine: CompiledMechanism
    state: MechanismState
    ports: ControlPorts
    inputs: MechanismInputs
    drifting: DriftedNumbers
    out: MechanismRecord


class MechanismBenchPlant:
    """Mechanism that implements `BenchPlant` (simulate/bench_experiment.py).

    `follow` and `ramp` raise NoSolutionError if the mechanism cannot be at rest at `start`.
    """

    def __init__(self, plant: MechanismPlant) -> None:
        self.plant = plant
        self.name = plant.name
        self.rig = plant.rig

    def follow(
        self, start: float, servo: Vector, reference: Vector, position: Vector, drive: Vector
    ) -> int:
        at, (period, delay) = (
            self._ready(start, reference.size),
            (self.rig.sample_period_s, self.rig.delay_samples),
        )
        return int(
            play_reference(
                at.machine,
                at.state,
                at.ports,
                servo,
                reference,
                period,
                delay,
                at.inputs,
                at.drifting,
                at.out,
                position,
                drive,
            )
        )

    def ramp(
        self, start: float, ramps: RampRows, position: Vector, drive: Vector, played: IntVector
    ) -> int:
        at = self._ready(start, ramps.rows.size)
        delay = self.rig.delay_samples
        return int(
            play_ramps(
                at.machine,
                at.state,
                at.ports,
                *ramps,
                delay,
                at.inputs,
                at.drifting,
                at.out,
                position,
                drive,
                played,
            )
        )

    def _ready(self, start: float, samples: int) -> PreparedBenchRun:
        plant = self.plant
        try:
            placed = block_positions(
                plant.document, plant.assembled, plant.controlled.sensor_block, start
            )
        except ValueError as error:
            raise NoSolutionError(f"{self.name}: the start position of the test {error}") from None
        packed = plant.assembled.packed
        machine = prepare(packed)
        state = rest(packed, machine, placed)
        nowhere = np.empty(0, dtype=np.int64)
        out = MechanismRecord(
            np.zeros((samples, RECORD_SIZE)),
            np.zeros((samples, 2 * packed.inertia.size + packed.sources.block.size)),
            np.zeros((samples, state.modes.size), dtype=np.int8),
            np.zeros((0, EVENT_SIZE)),
            np.zeros(1, dtype=np.int64),
        )
        return PreparedBenchRun(
            machine,
            state,
            ports_of(plant.controlled.source, plant.controlled, self.rig.resolution, placed),
            inputs_of({}, [], len(plant.assembled.sources), samples, self.rig.sample_period_s),
            DriftedNumbers(NO_CONDITIONS, nowhere, nowhere, np.empty(0), np.inf),
            out,
        )
