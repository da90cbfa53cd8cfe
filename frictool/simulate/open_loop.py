"""Simulation of a mechanism without a controller: the sources follow the scenario's signals.

The log contains all blocks. If the mechanism has one source and one sensor, or its `control` names
a source and a sensor, the log also contains `/axis`, like the log of a bench.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec.structs import replace

from frictool.documents.mechanism import Mechanism
from frictool.documents.provenance import Provenance
from frictool.documents.scenario import Scenario
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.mechanism.closed_loop import NOBODY, ControlPorts
from frictool.logs.log import Log
from frictool.logs.provenance import with_provenance
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.element_error import ElementError
from frictool.simulate.axis_channels import AxisChannels
from frictool.simulate.document_agreement import (
    DocumentNames,
    check_drive,
    check_efforts,
    check_temperature,
    refuse,
)
from frictool.simulate.mechanism_channels import MechanismChannels
from frictool.simulate.mechanism_inputs import mean_efforts
from frictool.simulate.mechanism_plant import (
    check_mechanism_scenario,
    ports_of,
    run_of,
    scenario_inputs,
    width_of,
)
from frictool.simulate.mechanism_rig import ControlledAxis, block_positions, rig_of_mechanism
from frictool.simulate.mechanism_runs import MechanismOutcome, MechanismTask, play_all
from frictool.simulate.mechanism_variants import MechanismVariant, mechanism_variants
from frictool.simulate.reference import samples_of
from frictool.simulate.rig import Rig
from frictool.simulate.scenario_conditions import conditions_of, loop_conditions
from frictool.simulate.scenario_limits import check_instants, check_length
from frictool.typing import Vector


def simulate_open_loop(
    document: Mechanism,
    assembled: AssembledMechanism,
    scenario: Scenario,
    provenance: Provenance,
    names: DocumentNames,
    progress: Callable[[int, int], None] = lambda done, total: None,
    watch: Callable[[MechanismOutcome], None] = lambda outcome: None,
) -> Log:
    """Simulate a mechanism without a controller; return the log with warnings.

    The log has streams for each variant. `progress(done, total)` counts variants, or samples if
    there is a single variant. `watch(outcome)` is called after each variant. `names` are the names
    of the documents in messages. Raises DocumentError if the scenario does not fit the mechanism,
    NoSolutionError if a variant cannot be simulated.
    """
    seen = _controlled(document, assembled)
    _check(document, assembled, scenario, names, seen)
    period = document.sample_period_s
    samples = samples_of(scenario.seconds, period)
    variants = mechanism_variants(document, assembled, scenario, names.model)
    conditions = (
        conditions_of(scenario, samples, period)
        if seen is not None or scenario.drifts is not None
        else NO_CONDITIONS
    )
    inputs = scenario_inputs(
        assembled, scenario, samples, period, None if seen is None else seen[1].source_block
    )
    named = {assembled.blocks.index(one.on) for one in scenario.disturbances if one.on is not None}
    channels = MechanismChannels(
        np.arange(samples, dtype=np.float64) * period,
        {block: mean for block, mean in mean_efforts(inputs).items() if block in named},
    )
    sensors = None if seen is None else AxisChannels(seen[0], scenario, samples, None, conditions)
    tasks = [
        _task(
            variant,
            scenario,
            samples,
            seen,
            (inputs, conditions if seen is None else loop_conditions(conditions, seen[0])),
        )
        for variant in variants
    ]
    streams = []
    warnings = list[str]()
    metadata = dict[str, dict[str, str]]()
    for index, outcome in enumerate(play_all(variants, tasks, progress)):
        watch(outcome)
        run = run_of(outcome, channels, [])
        streams += [
            *(
                []
                if sensors is None
                else [sensors.stream(outcome.variant.topic, index, run.record)]
            ),
            *run.streams,
        ]
        warnings += run.warnings
        metadata |= run.metadata
    about = {"kind": "simulated", "scenario": scenario.name, "model": document.name}
    plants = {variant.topic: variant.described() for variant in variants if variant.values}
    metadata = {"log": about, **({"plants": plants} if plants else {}), **metadata}
    return with_provenance(
        Log(tuple(streams), metadata, scenario.name, tuple(warnings)), provenance
    )


def _controlled(
    document: Mechanism, assembled: AssembledMechanism
) -> tuple[Rig, ControlledAxis] | None:
    try:
        return rig_of_mechanism(document, assembled)
    except ElementError:
        if document.control is not None:
            raise
        return None


def _task(
    variant: MechanismVariant,
    scenario: Scenario,
    samples: int,
    seen: tuple[Rig, ControlledAxis] | None,
    inputs: tuple[Any, Vector],
) -> tuple[MechanismTask, Vector]:
    if seen is None:
        start = variant.assembled.start
        ports = ControlPorts(NOBODY, 0, 0, 0.0, 0.0, 0.0, 1.0)
    else:
        rig, controlled = rig_of_mechanism(variant.document, variant.assembled)
        sensor = controlled.sensor_block
        start = (
            variant.assembled.start
            if scenario.start is None
            else block_positions(variant.document, variant.assembled, sensor, scenario.start.value)
        )
        ports = ports_of(controlled.source, controlled, rig.resolution, start)
    return MechanismTask(samples, ports, *inputs, None, 0, None, None), start


def _check(
    document: Mechanism,
    assembled: AssembledMechanism,
    scenario: Scenario,
    names: DocumentNames,
    seen: tuple[Rig, ControlledAxis] | None,
) -> None:
    period = document.sample_period_s
    if not scenario.is_open:
        key = "steps" if scenario.steps else "reference"
        refuse(
            names.scenario,
            key,
            "is for a test with a controller: give --controller, or write duration_s and sources",
        )
    samples = samples_of(scenario.seconds, period)
    if samples < 1:
        refuse(
            names.scenario,
            "duration_s",
            f"found {scenario.seconds:g}; allowed: at least one sample ({period:g} s)",
        )
    check_length(
        samples, 1 + (scenario.plants or 0), "duration_s", names.scenario, width_of(assembled)
    )
    check_mechanism_scenario(document, assembled, replace(scenario, spread=None), names, None)
    check_instants(scenario, scenario.seconds, period, names.scenario)
    check_temperature(scenario, None, names)
    if seen is None:
        _check_undetermined(scenario, names)
        return
    rig, controlled = seen
    if scenario.axis != rig.axis:
        refuse(
            names.scenario,
            "axis",
            f"found {scenario.axis}, but the sensor's block of {names.model} is {rig.axis}",
        )
    check_drive(scenario, rig, names)
    check_efforts(scenario, rig, names)
    if scenario.start is not None:
        try:
            block_positions(document, assembled, controlled.sensor_block, scenario.start.value)
        except ValueError as error:
            refuse(names.scenario, "start", str(error))


def _check_undetermined(scenario: Scenario, names: DocumentNames) -> None:
    reason = (
        f"{names.model} does not state the source and the sensor of a controller (control: "
        "{source: .., sensor: ..})"
    )
    for key in ("start", "sensor_faults", "commands", "drive_noise"):
        if getattr(scenario, key):
            refuse(names.scenario, key, f"belongs to the controlled axis, but {reason}")
    if scenario.drifts is not None and scenario.drifts.constant:
        refuse(names.scenario, "drifts.constant", f"belongs to the controlled source, but {reason}")
    for index, disturbance in enumerate(scenario.disturbances):
        if disturbance.on is None:
            refuse(
                names.scenario,
                f"disturbances[{index}]",
                f"names no block; write on: BLOCK, because {reason}",
            )
