"""Whether a model, a controller and a scenario can run together: one rig, one timing."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple, NoReturn

from frictool.documents.controller import Controller
from frictool.documents.lines import line_of
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.errors import DocumentError


class Names(NamedTuple):
    """What messages call the three documents: their paths, where they have any."""

    model: str = "model"
    controller: str = "controller"
    scenario: str = "scenario"


def refuse(name: str, key: str, message: str) -> NoReturn:
    """Raises DocumentError on `key` of the document called `name`, with its line where that is a file."""
    raise DocumentError(name, message, line=line_of(Path(name), key) if Path(name).is_file() else None, key=key)


def check_agreement(model: Model, controller: Controller, scenario: Scenario, names: Names) -> None:
    """Raises DocumentError naming the first thing on which the three do not agree, both values and what to do."""
    bench = model.bench
    for key, ours, theirs in (
        ("axis", controller.axis, model.axis),
        ("drive", controller.drive, bench.actuator.drive),
        ("sample_period_s", controller.sample_period_s, bench.sample_period_s),
        ("delay_samples", controller.delay_samples, bench.delay_samples),
    ):
        if ours != theirs:
            message = f"found {ours}, but the bench of {names.model} has {theirs}; synthesise again for this bench"
            refuse(names.controller, key, message)
    if scenario.axis != model.axis:
        refuse(names.scenario, "axis", f"found {scenario.axis}, but {names.model} has {model.axis}")
    in_drive = any(fault.offset is not None for fault in scenario.sensor_faults)
    if scenario.drive != bench.actuator.drive and (in_drive or scenario.drive != "current"):
        allowed = f"drive: {bench.actuator.drive}, which {names.model} has"
        refuse(names.scenario, "drive", f"found {scenario.drive}; allowed: {allowed}, for quantities of the drive")
    if scenario.variants == "vertices":
        _check_vertices(controller, names)


def _check_vertices(controller: Controller, names: Names) -> None:
    """A vertex's name becomes a word of its stream's topic."""
    seen: set[str] = set()
    for index, vertex in enumerate(controller.verified.vertices):
        if not re.fullmatch(r"[A-Za-z0-9_]+", vertex.name) or vertex.name in seen:
            allowed = "letters, digits and _, each name once"
            refuse(names.controller, f"verified.vertices[{index}].name", f"found {vertex.name!r}; allowed: {allowed}")
        seen.add(vertex.name)
