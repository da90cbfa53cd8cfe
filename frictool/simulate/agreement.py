"""Whether a model, a controller and a scenario can run together: one rig, one timing, a path within the travel."""

from __future__ import annotations

import re
from typing import NamedTuple

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.errors import InputFileError

MAX_SAMPLES = 10_000_000  # of all variants together: about 1 GB in memory


class Names(NamedTuple):
    """What messages call the three documents: their paths, where they have any."""

    model: str = "model"
    controller: str = "controller"
    scenario: str = "scenario"


def check_agreement(model: Model, controller: Controller, scenario: Scenario, names: Names) -> None:
    """Raises InputFileError naming the first thing on which the three do not agree, both values and what to do."""
    bench = model.bench
    for key, ours, theirs in (
        ("axis", controller.axis, model.axis),
        ("drive", controller.drive, bench.actuator.drive),
        ("sample_period_s", controller.sample_period_s, bench.sample_period_s),
        ("delay_samples", controller.delay_samples, bench.delay_samples),
    ):
        if ours != theirs:
            message = f"{key}: found {ours}, but the bench of {names.model} has {theirs}; synthesise again for this bench"
            raise InputFileError(names.controller, message)
    if scenario.axis != model.axis:
        raise InputFileError(names.scenario, f"axis: found {scenario.axis}, but {names.model} has {model.axis}")
    if scenario.variants == "vertices":
        _check_vertices(controller, names)
    _check_path(model, scenario, names)
    _check_length(controller, scenario, names)


def _check_vertices(controller: Controller, names: Names) -> None:
    """A vertex's name becomes a word of its stream's topic."""
    seen: set[str] = set()
    for index, vertex in enumerate(controller.verified.vertices):
        if not re.fullmatch(r"[A-Za-z0-9_]+", vertex.name) or vertex.name in seen:
            allowed = "letters, digits and _, each name once"
            raise InputFileError(names.controller, f"verified.vertices[{index}].name: found {vertex.name!r}; allowed: {allowed}")
        seen.add(vertex.name)


def _check_path(model: Model, scenario: Scenario, names: Names) -> None:
    travel = model.bench.mechanics.travel
    if travel is None:
        return
    places = [("start", scenario.start.value)]
    places += [(f"steps[{index}].reference", step.reference.value) for index, step in enumerate(scenario.steps)]
    for key, value in places:
        if not travel.low <= value <= travel.high:
            allowed = f"the travel of the bench, {travel.low:g} to {travel.high:g} {travel.unit}"
            raise InputFileError(names.scenario, f"{key}: found {value:g} {travel.unit}; allowed: {allowed}")


def _check_length(controller: Controller, scenario: Scenario, names: Names) -> None:
    period = controller.sample_period_s
    for index, step in enumerate(scenario.steps):
        if step.duration_s < 0.5 * period:
            found = f"steps[{index}].duration_s: found {step.duration_s:g}"
            raise InputFileError(names.scenario, f"{found}; allowed: one sample, {period:g} s, or more")
    runs = 1 + (len(controller.verified.vertices) if scenario.variants == "vertices" else 0)
    samples = sum(step.duration_s for step in scenario.steps) / period * runs
    if samples > MAX_SAMPLES:
        raise InputFileError(names.scenario, f"asks for {samples:.3g} samples in {runs} run(s); allowed: {MAX_SAMPLES:.0e} in all")
