"""Plays a scenario to a model under its controller, once for each variant, and returns what a bench would have logged.

    scenario --> reference[k] --> engine.closed_loop.run(axis of the variant, controller) --> record --> sensors --> stream

Position is what the encoder reports; the drive is measured with noise of standard deviation `drive_noise`, independent from sample
to sample and drawn for each variant from PCG64 seeded with (seed, the variant's index). What only a simulation knows is there too.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from frictool.control.composition import controller_program
from frictool.control.machine import machine, start_at
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import CHANNEL_DIMENSIONS, drive_dimension, si_unit
from frictool.documents.scenario import Scenario
from frictool.engine import closed_loop
from frictool.engine.conditions import NO_CONDITIONS
from frictool.engine.status import MESSAGES, OK
from frictool.errors import NoSolutionError
from frictool.logs.log import Log, Stream
from frictool.logs.provenance import with_provenance
from frictool.plant.axis import rest
from frictool.plant.axis_model import load_of
from frictool.plant.load import Load
from frictool.simulate.agreement import Names, check_agreement
from frictool.simulate.variants import Variant, variants_of

Vector = NDArray[np.float64]
DOCUMENTS = Names()


def step_test(
    model: Model,
    controller: Controller,
    scenario: Scenario,
    provenance: Provenance,
    names: Names = DOCUMENTS,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Log:
    """The log of the scenario, one stream a variant, with warnings for people.

    `progress(done, total)` is called before the first variant and after each; `names` are what messages call the documents.
    Raises InputFileError where the documents do not fit together, NoSolutionError where a variant cannot be simulated.
    """
    check_agreement(model, controller, scenario, names)
    variants = variants_of(model, controller, scenario, names.model)
    reference, load = _reference(scenario, controller.sample_period_s), load_of(model)
    streams, warnings = [], []
    progress(0, len(variants))
    for index, variant in enumerate(variants):
        record = _run(variant, load, controller, scenario.start.value, reference)
        noise = np.random.Generator(np.random.PCG64([scenario.seed, index])).normal(0.0, scenario.drive_noise, reference.size)
        streams.append(_stream(model, controller, variant, reference, record, noise))
        warnings += _against_stops(model, variant, record)
        progress(index + 1, len(variants))
    played = {"kind": "simulated", "scenario": scenario.name, "model": model.name, "controller": controller.name}
    return with_provenance(Log(tuple(streams), {"log": played}, scenario.name, tuple(warnings)), provenance)


def _reference(scenario: Scenario, period: float) -> Vector:
    """The reference at each sample; a step's duration is rounded to whole samples."""
    return np.concatenate([np.full(round(step.duration_s / period), step.reference.value) for step in scenario.steps])


def _run(variant: Variant, load: Load, controller: Controller, start: float, reference: Vector) -> Vector:
    """The record (n, 7) of one variant under the model's load.

    From rest at `start`, the backlash in its middle, the prefilter settled at what is measured.
    """
    axis, running = variant.axis.as_array(), machine(controller_program(controller))
    measured = closed_loop.measure(start, variant.axis.encoder_step)
    start_at(running, measured)
    record = np.zeros((reference.size, closed_loop.RECORD_SIZE))
    status = closed_loop.run(
        axis,
        rest(start),
        running,
        reference,
        controller.sample_period_s,
        controller.delay_samples,
        record,
        load.as_array(),
        NO_CONDITIONS,
    )
    if status != OK:
        raise NoSolutionError(f"{variant.topic}: {MESSAGES[status]}; check the model's parameters")
    return record


def _stream(model: Model, controller: Controller, variant: Variant, reference: Vector, record: Vector, noise: Vector) -> Stream:
    drive = controller.drive
    measured_drive: Vector = record[:, closed_loop.TRUE_DRIVE] + noise
    time: Vector = np.arange(reference.size, dtype=np.float64) * controller.sample_period_s
    columns = {
        "position": (record[:, closed_loop.MEASURED], "position"),
        "reference": (reference, "position"),
        drive: (measured_drive, CHANNEL_DIMENSIONS[drive]),
        "effort": (model.bench.actuator.constant.value * measured_drive, "effort"),  # as a bench computes it, whatever the variant
        "command": (record[:, closed_loop.COMMAND], drive_dimension(drive, constant=False)),
        "velocity": (record[:, closed_loop.TRUE_VELOCITY], "velocity"),
        "position_true": (record[:, closed_loop.TRUE_POSITION], "position"),
        "load_position": (record[:, closed_loop.LOAD], "position"),
    }
    signals = {name: np.ascontiguousarray(values, dtype=np.float64) for name, (values, _) in columns.items()}
    units = {name: si_unit(dimension, model.axis) for name, (_, dimension) in columns.items()}
    return Stream(variant.topic, time, signals, units)


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
