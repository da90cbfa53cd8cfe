"""Plays a scenario to a model under its controller, once for each variant, and returns what a bench would have logged.

    scenario --> reference, conditions --> engine.closed_loop.run(axis of the variant, controller) --> record --> sensors --> stream

Position is what the encoder reports; the drive is measured with noise of standard deviation `drive_noise`, independent from sample
to sample and drawn for each variant from PCG64 seeded with (seed, the variant's index). What only a simulation knows is there too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from frictool.control.composition import controller_program, uses_speed
from frictool.control.fixed_point import DoesNotFit
from frictool.control.machine import Machine
from frictool.control.number_format import machine_in
from frictool.control.program import Program
from frictool.documents.controller import Controller, Number
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import si_unit
from frictool.documents.scenario import Scenario
from frictool.engine import closed_loop
from frictool.engine.conditions import SENSOR_GAIN, SENSOR_OFFSET
from frictool.errors import NoSolutionError
from frictool.logs.log import Log
from frictool.logs.provenance import with_provenance
from frictool.plant.axis_model import load_of
from frictool.simulate.agreement import Names, check_agreement
from frictool.simulate.limits import check_instants, check_length, check_path, check_steps
from frictool.simulate.playing import play
from frictool.simulate.playing_target import play_target
from frictool.simulate.reference import parts_of
from frictool.simulate.replay import gaps_of, replayed
from frictool.simulate.streams import Sensors
from frictool.simulate.target import Target
from frictool.simulate.timeline import conditions_of
from frictool.simulate.used_speed import used_speed
from frictool.simulate.variants import Variant, count, known, variants_of

Vector = NDArray[np.float64]
DOCUMENTS = Names()


def step_test(
    model: Model,
    controller: Controller,
    scenario: Scenario,
    provenance: Provenance,
    names: Names = DOCUMENTS,
    progress: Callable[[int, int], None] = lambda done, total: None,
    recorded: Log | None = None,
    number: Number = "double",
    target: Target | None = None,
) -> Log:
    """The log of the scenario, one stream a variant, with warnings for people.

    `progress(done, total)` is told before the first variants and after each batch of them; `names` are what messages call the documents;
    `recorded` is the log of a scenario that replays one; `number` is the format in which the controller runs; `target` runs in its place.
    Raises InputFileError where the documents do not fit together, LogError where the log cannot be replayed, NoSolutionError where a
    variant cannot be simulated.
    """
    check_agreement(model, controller, scenario, names)
    reference, start = _reference(model, controller, scenario, names, recorded)
    period = controller.sample_period_s
    check_instants(scenario, reference.size * period, period, names.scenario)
    variants, conditions = variants_of(model, controller, scenario, names.model), conditions_of(scenario, reference.size, period)
    sensors = Sensors(model, controller, scenario, reference, conditions)
    acting, streams, warnings = _acting(conditions, controller), [], _of_log(scenario, recorded)
    program = controller_program(controller)
    places = scheduled(controller, program)
    told = [{place: known(model, variant)[name] for name, place in places.items()} for variant in variants] if places else []
    given = controller, start, reference, load_of(model), acting, progress, told
    running = _machine(controller, program, number if target is None else target.number)
    played = play(variants, running, *given) if target is None else play_target(variants, target, *given)
    for index, (variant, record) in enumerate(played):
        used = _used(controller, program, running, reference, record, variant, told[index] if told else {})
        streams.append(sensors.stream(variant.topic, index, record, used))
        warnings += _against_stops(model, variant, record)
    about = {"kind": "simulated", "scenario": scenario.name, "model": model.name, "controller": controller.name}
    if controller.velocity.observer is not None:
        about["speed_from"] = f"{controller.velocity.observer.kind} observer"
    metadata = {"log": about, **_plants(model, variants)}
    return with_provenance(Log(tuple(streams), metadata, scenario.name, tuple(warnings)), provenance)


def scheduled(controller: Controller, program: Program) -> dict[str, int]:
    """The places of the parameters that a scheduled controller is told, by their names; none where it has no schedule."""
    names = controller.schedule.parameters if controller.schedule is not None else ()
    return {str(name): program.states[name].index for name in names if name in program.states}


def _used(
    controller: Controller,
    program: Program,
    running: Machine,
    reference: Vector,
    record: Vector,
    variant: Variant,
    told: Mapping[int, float],
) -> Vector | None:
    """What the controller took for the speed; None where it asks for none, or a sensor of its own tells it."""
    if program.speed is None or controller.velocity.source == "measured" or not uses_speed(controller):
        return None
    return used_speed(running, program.speed.index, reference, record, variant.axis.encoder_step, told)


def _machine(controller: Controller, program: Program, number: Number) -> Machine:
    """The controller as the simulation runs it in a number format."""
    try:
        return machine_in(program, number)
    except DoesNotFit as error:
        raise NoSolutionError(
            f"{controller.name}: {number} cannot be scaled: {error}; bound what is measured in the bench, or use float"
        ) from None


def _reference(model: Model, controller: Controller, scenario: Scenario, names: Names, recorded: Log | None) -> tuple[Vector, float]:
    """The reference (n,) within the travel, and where the axis rests at first [rad | m]."""
    period, travel, runs = controller.sample_period_s, model.bench.mechanics.travel, count(controller, scenario)
    if scenario.reference is not None:
        if recorded is None:
            raise ValueError("a scenario that replays a log needs it: `recorded`")
        reference = replayed(scenario.reference, recorded, model.axis, period)
        check_length(reference.size, runs, "reference", names.scenario)
        places = {"reference": reference}
    else:
        check_steps(scenario, period, runs, names.scenario)
        parts = parts_of(scenario, period)
        reference = np.concatenate(parts)
        places = {f"steps[{index}].{step.kind}": part for index, (step, part) in enumerate(zip(scenario.steps, parts, strict=True))}
    start = float(reference[0]) if scenario.start is None else scenario.start.value
    check_path({"start": np.array([start]), **places}, travel, names.scenario)
    return reference, start


def _of_log(scenario: Scenario, recorded: Log | None) -> list[str]:
    """What there is to be told of the log that is replayed."""
    return [] if scenario.reference is None or recorded is None else gaps_of(scenario.reference, recorded)


def _acting(conditions: Vector, controller: Controller) -> Vector:
    """The conditions as the loop feels them: a voltage is not fed back, so that a wrong sensor of it only shows in the log."""
    if controller.drive == "current" or not conditions.size:
        return conditions
    felt = conditions.copy()
    felt[:, SENSOR_OFFSET], felt[:, SENSOR_GAIN] = 0.0, 1.0
    return felt


def _plants(model: Model, variants: list[Variant]) -> dict[str, dict[str, str]]:
    """The metadata record of what each variant's plant is, by its topic."""
    of_constant = "effort per ampere" if model.bench.actuator.drive == "current" else "effort per volt"
    dimensions = {"inertia": "inertia", "viscous": "viscous", "coulomb": "effort", "constant": of_constant}
    units = {name: si_unit(dimension, model.axis) for name, dimension in dimensions.items()}
    found = {
        variant.topic: ", ".join(f"{name} {value:.6g} {units[name]}" for name, value in variant.values.items())
        for variant in variants
        if variant.values
    }
    return {"plants": found} if found else {}


def _against_stops(model: Model, variant: Variant, record: Vector) -> list[str]:
    """A warning where the axis runs against an end stop of its travel: no rig should."""
    travel = model.bench.mechanics.travel
    if travel is None:
        return []
    position = record[:, closed_loop.TRUE_POSITION]
    found = []
    for wall, against in ((travel.low, position <= travel.low), (travel.high, position >= travel.high)):
        arrivals = np.flatnonzero(against[1:] & ~against[:-1])
        if arrivals.size:
            first = (arrivals[0] + 1) * model.bench.sample_period_s
            found.append(f"{variant.topic} runs against its end stop at {wall:g} {travel.unit}, first at {first:.3f} s")
    return found
