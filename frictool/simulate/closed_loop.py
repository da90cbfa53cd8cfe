"""Simulation of a scenario with a controller and each plant variant; the result is a log.

    scenario -> reference, conditions -> closed loop of each variant (simulate/simulated_plant.py)
    -> record -> sensors -> stream

The logged position is the encoder's reading. The drive is measured with white noise of standard
deviation `drive_noise`. The noise of each variant is drawn from the random generator PCG64 with the
seed (`seed` of the scenario, index of the variant). The log also contains true signals, which a
bench cannot measure (simulate/axis_channels.py).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, NamedTuple, get_args

import msgspec
import numpy as np
from msgspec.structs import replace

from frictool.adapters.controller_composition import controller_program, uses_speed
from frictool.adapters.temperature_factors import KEY as TEMPERATURE
from frictool.adapters.temperature_factors import temperature_words
from frictool.control.compiled_program import CompiledProgram
from frictool.control.fixed_point import FixedPointOverflow
from frictool.control.machine_code import MachineCode, machine_code
from frictool.control.number_format import machine_in
from frictool.control.program import Program
from frictool.documents import bench_values
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.logged_positions import KEY as LOGGED
from frictool.documents.logged_positions import extrapolated_words, to_text
from frictool.documents.missing_effects import KEY as MISSING
from frictool.documents.missing_effects import UNDECIDED, intolerable_lag
from frictool.documents.model import Model
from frictool.documents.presliding import KEY as PRESLIDING
from frictool.documents.presliding import presliding_words
from frictool.documents.provenance import Provenance
from frictool.documents.scenario import Scenario
from frictool.documents.valid_side import KEY as SIDE
from frictool.errors import FrictoolError, NoSolutionError
from frictool.logs.log import Log, Stream
from frictool.logs.provenance import with_provenance
from frictool.logs.quality.overspeed import overspeed_of_streams
from frictool.simulate.axis_channels import AxisChannels, ControllerSignals, fault_warning
from frictool.simulate.axis_plant import AxisPlant
from frictool.simulate.compiled_target import CompiledTarget
from frictool.simulate.controller_signal import RecordedRun, controller_signal, fault_signal
from frictool.simulate.document_agreement import DOCUMENTS, DocumentNames, check_agreement, refuse
from frictool.simulate.logged_reference import gaps_of, reference_from_log
from frictool.simulate.reference import parts_of
from frictool.simulate.scenario_conditions import command_samples, conditions_of, loop_conditions
from frictool.simulate.scenario_limits import check_instants, check_length, check_path, check_steps
from frictool.simulate.scenario_temperature import (
    friction_factors,
    leaves_law,
    simulated_temperature,
)
from frictool.simulate.simulated_plant import SimulatedLoop, SimulatedPlant, V
from frictool.typing import Vector
from frictool.verify.certified_intervals import differences, outside_message
from frictool.verify.logged_plant import INTERVALS, LoggedPlant, intervals_to_text
from frictool.verify.logged_plant import RECORD as PLAYED
from frictool.verify.rig_facts import RECORD as FACTS
from frictool.verify.rig_facts import facts_to_text

Progress = Callable[[int, int], None]


def no_progress(done: int, total: int) -> None:
    """Ignore the progress; this function is the default of the argument `progress`."""


@dataclass(frozen=True)
class SimulationRequest:
    """Options of a simulation with a controller.

    Attributes
    ----------
    recorded : Log or None
        Log from which the scenario takes its reference; None if the scenario has steps.
    number : ProgramNumber
        Number format of the controller's arithmetic; ignored with `target`.
    target : CompiledTarget or None
        Compiled code that runs instead of the simulated controller.
    """

    recorded: Log | None = None
    number: ProgramNumber = "double"
    target: CompiledTarget | None = None


PLAIN = SimulationRequest()


def simulate_closed_loop(
    plant: Model | SimulatedPlant[V],
    controller: Controller,
    scenario: Scenario,
    provenance: Provenance,
    names: DocumentNames = DOCUMENTS,
    progress: Progress = no_progress,
    request: SimulationRequest = PLAIN,
) -> Log:
    """Simulate a scenario with a controller and each plant variant; return the log.

    The log has a stream for each variant, metadata and warnings. `progress(done, total)` counts
    variants, or samples if a mechanism has a single variant. `names` are the names of the documents
    in messages. Raises InputFileError if the documents do not fit together, LogError if the log
    cannot be replayed, NoSolutionError if a variant cannot be simulated.
    """
    if isinstance(plant, Model):
        axis = AxisPlant(plant)
        return simulate_closed_loop(
            axis, controller, scenario, provenance, names, progress, request
        )
    test = StepTest(plant, controller, names, request.number, request.target)
    return test.log(scenario, provenance, progress, request.recorded)


class PreparedScenario(NamedTuple, Generic[V]):
    """Scenario that is ready for the simulation, with the plant variants.

    `conditions` (n, 8): disturbances, drifts and sensor faults (engine/disturbances_and_faults.py),
    including faults that affect only the log. `sensors` builds the streams of the log. `loop` is
    common to all variants.
    """

    variants: Sequence[V]
    conditions: Vector
    sensors: AxisChannels
    loop: SimulatedLoop


class _KeptReference(NamedTuple):
    key: tuple[object, ...]
    recorded: Log | None
    reference: Vector


class SimulatedRun(NamedTuple, Generic[V]):
    """Simulated signals of one plant variant, from which a log stream is built.

    - number: number of the variant, from 0
    - record: signals (n, 7) with the columns of engine/closed_loop.py
    - plant: linear plant for the stability margins; None for a mechanism
    """

    prepared: PreparedScenario[V]
    number: int
    variant: V
    record: Vector
    plant: LoggedPlant | None


class StepTest(Generic[V]):
    """Closed loop of one plant and one controller, with which several scenarios are simulated.

    `simulate_closed_loop` and SimulationRequest explain the arguments.
    """

    def __init__(
        self,
        plant: SimulatedPlant[V],
        controller: Controller,
        names: DocumentNames = DOCUMENTS,
        number: ProgramNumber = "double",
        target: CompiledTarget | None = None,
    ) -> None:
        self.plant = plant
        self.controller = controller
        self.names = names
        self.target = target
        self._kept: _KeptReference | None = None
        self._number: ProgramNumber = number if target is None else target.number
        if self._number not in get_args(ProgramNumber):
            allowed = ", ".join(get_args(ProgramNumber))
            raise FrictoolError(f"number: found {number!r}; allowed: {allowed}")

    def log(
        self,
        scenario: Scenario,
        provenance: Provenance | None = None,
        progress: Progress = no_progress,
        recorded: Log | None = None,
        with_speed: bool = True,
    ) -> Log:
        """Simulate a scenario; return the log that `simulate_closed_loop` returns.

        If `with_speed` is False, the log has no `velocity_estimated`; this saves time.
        """
        plant = self.plant
        controller = self.controller
        rig = self.plant.rig
        prepared = self._prepared(scenario, recorded, progress)
        variants = prepared.variants
        loop = prepared.loop
        streams = []
        warnings = _of_log(scenario, recorded)
        metadata = dict[str, dict[str, str]]()
        for index, (variant, run) in enumerate(plant.play(variants, loop)):
            known = loop.scheduled[index] if loop.scheduled else {}
            values = self._signals(loop, run.record, known, with_speed)
            made = prepared.sensors.stream(variant.topic, index, run.record, values)
            streams += [made, *run.streams]
            warnings += [*run.warnings, *fault_warning(made, controller.measurement_hold_samples)]
            metadata |= run.metadata
        about = {
            "kind": "simulated",
            "scenario": scenario.name,
            "model": plant.name,
            "controller": controller.name,
        }
        if controller.velocity.observer is not None:
            about["speed_from"] = f"{controller.velocity.observer.kind} observer"
        if rig.bench_values_only:
            about[bench_values.KEY] = rig.bench_values_only
        if played := simulated_temperature(scenario, rig.temperature):
            about[TEMPERATURE] = played
        if leaves_law(scenario, rig.temperature):
            warnings.append(temperature_words(self.names.model, played))
        if rig.presliding:
            about[PRESLIDING] = rig.presliding
            warnings.append(presliding_words(self.names.model, rig.presliding))
        if rig.missing:
            about[MISSING] = "\n".join(rig.missing)
        if rig.valid_side is not None:
            about[SIDE] = msgspec.json.encode(rig.valid_side).decode()
        if rig.logged_positions is not None:
            about[LOGGED] = to_text(rig.logged_positions)
        warnings += self._extrapolated(loop)
        if doubt := self._doubt():
            about[UNDECIDED] = doubt
        plants = {variant.topic: plant.described(variant) for variant in variants if variant.values}
        kept = {"bench": self.plant.rig.examples, "scenario": scenario.examples}
        examples = {name: ", ".join(keys) for name, keys in kept.items() if keys}
        records = {"plants": plants, "examples": examples} | self._linear(variants, prepared)
        metadata = {
            "log": about,
            **{name: record for name, record in records.items() if record},
            **metadata,
        }
        warnings += self._outside(scenario)
        log = Log(tuple(streams), metadata, scenario.name)
        if fast := overspeed_of_streams({one.topic: one for one in log.axes}, controller.bench):
            warnings.append(fast)
        log = dataclasses.replace(log, warnings=tuple(warnings))
        return log if provenance is None else with_provenance(log, provenance)

    def _extrapolated(self, loop: SimulatedLoop) -> list[str]:
        """Return a warning if the reference is far outside the positions in the model's logs."""
        low = min(loop.start, float(loop.reference.min()))
        high = max(loop.start, float(loop.reference.max()))
        words = extrapolated_words(self.plant.rig.logged_positions, low, high, "steps")
        return [f"{self.names.model}: {words}"] if words else []

    def _doubt(self) -> str:
        """Return why the axis may fail although the simulation passes; "" if there is no reason."""
        if reason := intolerable_lag(self.plant.rig.late_position, self.controller):
            return reason
        if self.controller.ringing is None:
            return ""
        from frictool.verify.ringing_loop import ringing_doubt  # few controllers need it

        return ringing_doubt(self.controller)

    def runs(self, scenario: Scenario, recorded: Log | None = None) -> Iterator[SimulatedRun[V]]:
        """Simulate a scenario; yield the signals of each variant."""
        prepared = self._prepared(scenario, recorded, no_progress)
        played = self.plant.play(prepared.variants, prepared.loop)
        for number, (variant, run) in enumerate(played):
            plant = self.plant.linear(variant, prepared.conditions)
            yield SimulatedRun(prepared, number, variant, run.record, plant)

    def stream(self, run: SimulatedRun[V]) -> Stream:
        """Return the log stream of a simulated variant, with only the signals that metrics read."""
        loop, number = run.prepared.loop, run.number
        known = loop.scheduled[number] if loop.scheduled else {}
        values = self._signals(loop, run.record, known, with_speed=False)
        topic = run.variant.topic
        return run.prepared.sensors.stream(topic, number, run.record, values, judged=True)

    def rig_records(self, scenario: Scenario) -> dict[str, dict[str, str]]:
        """Return metadata for the log: data of the rig, and intervals of the plant's parameters."""
        known = intervals_to_text(self.plant.intervals(scenario))
        return {INTERVALS: known, FACTS: facts_to_text(self.plant.rig.facts)}

    def _prepared(
        self, scenario: Scenario, recorded: Log | None, progress: Progress
    ) -> PreparedScenario[V]:
        controller, rig = self.controller, self.plant.rig
        reference, start = self.reference(scenario, recorded)
        variants = self.plant.variants(controller, scenario, self.names.model)
        factors = friction_factors(scenario, rig.temperature)
        conditions = conditions_of(scenario, reference.size, rig.sample_period_s, factors)
        sensors = AxisChannels(
            rig,
            scenario,
            reference.size,
            reference,
            conditions,
            controller.velocity.source == "measured",
            controller.measurement_hold_samples,
        )
        known = _known_values(self.plant, variants, self._scheduled)
        loop = SimulatedLoop(
            controller,
            scenario,
            self._program,
            self._running,
            self._code if self.target is None else None,
            self.target,
            start,
            reference,
            loop_conditions(conditions, rig),
            known,
            progress,
        )
        return PreparedScenario(variants, conditions, sensors, loop)

    def reference(self, scenario: Scenario, recorded: Log | None = None) -> tuple[Vector, float]:
        """Return the reference (n,) and the initial position at rest [rad | m].

        Raises InputFileError if plant, controller and scenario do not fit together.
        """
        self.plant.check(
            self.controller, replace(scenario, spread=None), self.names
        )  # only a campaign uses the spread
        check_agreement(self.plant.rig, self.controller, scenario, self.names)
        reference, start = self._checked_reference(scenario, recorded)
        period = self.plant.rig.sample_period_s
        check_instants(scenario, reference.size * period, period, self.names.scenario)
        return reference, start

    def _checked_reference(self, scenario: Scenario, recorded: Log | None) -> tuple[Vector, float]:
        first = scenario.steps[0] if scenario.steps else None
        begins = scenario.start if first is not None and first.reference is None else None
        runs = self.plant.count(self.controller, scenario)
        key = (scenario.steps, scenario.reference, begins, runs)
        kept = self._kept
        if kept is None or kept.recorded is not recorded or kept.key != key:
            reference, start = _reference(self.plant, runs, scenario, self.names, recorded)
            self._kept = _KeptReference(key, recorded, reference)
            return reference, start
        start = _start(scenario, kept.reference)
        check_path({"start": np.array([start])}, self.plant.rig.travel, self.names.scenario)
        return kept.reference, start

    def _linear(
        self, variants: Sequence[V], prepared: PreparedScenario[V]
    ) -> dict[str, dict[str, str]]:
        linear = {
            variant.topic: system.to_text()
            for variant in variants
            if (system := self.plant.linear(variant, prepared.conditions)) is not None
        }
        return {PLAYED: linear, **self.rig_records(prepared.loop.scenario)}

    def _outside(self, scenario: Scenario) -> list[str]:
        known = self.plant.intervals(scenario)
        deviations = differences(self.controller, self.plant.rig.facts, known)
        return (
            [f"{self.names.model} {outside_message(self.names.controller, deviations)}"]
            if deviations
            else []
        )

    @cached_property
    def _program(self) -> Program:
        return controller_program(self.controller)

    @cached_property
    def _scheduled(self) -> dict[str, int]:
        return scheduled(self.controller, self._program)

    @cached_property
    def _running(self) -> CompiledProgram:
        try:
            return machine_in(self._program, self._number)
        except FixedPointOverflow as error:
            raise NoSolutionError(
                f"{self.controller.name}: cannot be scaled to {self._number}: {error}; give the "
                "bounds of the measured signals in the bench, or use float"
            ) from None

    @cached_property
    def _code(self) -> MachineCode | None:
        return machine_code(self._running)

    def _signals(
        self, loop: SimulatedLoop, record: Vector, known: Mapping[int, float], with_speed: bool
    ) -> ControllerSignals:
        controller, program = self.controller, self._program
        period = controller.sample_period_s
        run = RecordedRun(
            program,
            self._running,
            loop.reference,
            record,
            self.plant.rig.resolution,
            known,
            command_samples(loop.scenario.commands, period),
        )
        uses = controller.velocity.source != "measured" and uses_speed(controller) and with_speed
        return ControllerSignals(
            None if program.speed is None or not uses else controller_signal(run, program.speed),
            None if program.profile is None else controller_signal(run, program.profile),
            fault_signal(run) if loop.scenario.commands else None,
        )


def _known_values(
    plant: SimulatedPlant[V], variants: Sequence[V], states: Mapping[str, int]
) -> list[dict[int, float]]:
    known = [plant.known(variant) for variant in variants] if states else []
    values = [{index: of[name] for name, index in states.items() if name in of} for of in known]
    return values if any(values) else []


def scheduled(controller: Controller, program: Program) -> dict[str, int]:
    """Return {name of a scheduled parameter: node index}, empty without a gain schedule."""
    names = controller.schedule.parameters if controller.schedule is not None else ()
    return {str(name): program.states[name].index for name in names if name in program.states}


def _reference(
    plant: SimulatedPlant[V],
    runs: int,
    scenario: Scenario,
    names: DocumentNames,
    recorded: Log | None,
) -> tuple[Vector, float]:
    rig = plant.rig
    period = rig.sample_period_s
    if scenario.reference is not None:
        if recorded is None:
            refuse(
                names.scenario,
                "reference.log",
                "names a log to replay; pass this log as `recorded`",
            )
        reference = reference_from_log(scenario.reference, recorded, rig.axis, period)
        check_length(reference.size, runs, "reference", names.scenario, plant.width)
        paths = {"reference": reference}
    else:
        check_steps(scenario, period, runs, names.scenario, plant.width)
        parts = parts_of(scenario, period)
        reference = np.concatenate(parts)
        paths = {
            f"steps[{index}].{step.kind}": part
            for index, (step, part) in enumerate(zip(scenario.steps, parts, strict=True))
        }
    start = _start(scenario, reference)
    check_path({"start": np.array([start]), **paths}, rig.travel, names.scenario)
    return reference, start


def _start(scenario: Scenario, reference: Vector) -> float:
    return float(reference[0]) if scenario.start is None else scenario.start.value


def _of_log(scenario: Scenario, recorded: Log | None) -> list[str]:
    return (
        []
        if scenario.reference is None or recorded is None
        else gaps_of(scenario.reference, recorded)
    )
