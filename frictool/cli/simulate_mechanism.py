"""`frictool simulate` of a mechanism.yaml: which file is one, under a controller, and without."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from frictool.cli.output import command_line, refuse_inputs, save_text

if TYPE_CHECKING:
    from frictool.cli.bench_servo import Gains
    from frictool.engine.servo import Servo
    from frictool.logs.log import Log
    from frictool.simulate.mechanism_events import EventTable
    from frictool.simulate.mechanism_on_bench import MechanismOnBench
    from frictool.simulate.mechanism_plant import MechanismPlant
    from frictool.simulate.mechanism_playing import Moved


def is_mechanism(path: Path) -> bool:
    """Whether the document at `path` says that it is a mechanism. Raises InputFileError where it is no document."""
    import yaml

    from frictool.documents.reading import compose, read_text

    node = compose(read_text(path), path)
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    return any(key.value == "format" and str(value.value).startswith("mechanism/") for key, value in pairs)


class Events:
    """What --events asks for: where to, and the table once it is known that it can be."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._table: EventTable | None = None

    def add(self, moved: Moved) -> None:
        """Of one run."""
        if self.path is None:
            return
        from frictool.simulate.mechanism_events import EventTable

        self._table = self._table or EventTable()
        self._table.add(moved)

    def save(self, inputs: list[Path]) -> None:
        """The file, if there is to be one."""
        if self.path is not None and self._table is not None:
            save_text(self.path, self._table.text, inputs)


def mechanism_plant(path: Path, events: Events) -> MechanismPlant:
    """The mechanism at `path` as a controller's plant. Raises DocumentError where it is none."""
    from frictool.cli.mechanism_file import load_mechanism, tell_notes, wrong_in_file
    from frictool.plant.mechanism.wrong import WrongElement
    from frictool.simulate.mechanism_plant import MechanismPlant

    document, assembled = load_mechanism(path)
    tell_notes(path, assembled)
    try:
        return MechanismPlant(document, assembled, events.add)
    except WrongElement as wrong:
        raise wrong_in_file(path, wrong) from None


def on_bench(path: Path, gains: Gains) -> tuple[MechanismOnBench, Servo]:
    """The mechanism at `path` on its bench, and the bench's own loop around it."""
    import math

    from frictool.simulate.mechanism_on_bench import MechanismOnBench

    plant = mechanism_plant(path, Events(None))
    limit = plant.document.sources[plant.assembled.sources[plant.controlled.source]].limit
    return MechanismOnBench(plant), gains.on_drive(plant.rig.constant, math.inf if limit is None else limit.value)


def open_log(path: Path, scenario: Path, output: Path, progress: Callable[[int, int], None], events: Events) -> tuple[Log, list[Path]]:
    """The log of a scenario without a controller, and its inputs."""
    from frictool.cli.mechanism_file import load_mechanism, tell_notes, wrong_in_file
    from frictool.documents.provenance import record
    from frictool.documents.registry import load
    from frictool.documents.scenario import Scenario
    from frictool.plant.mechanism.wrong import WrongElement
    from frictool.simulate.agreement import Names
    from frictool.simulate.open_test import open_test

    (document, assembled), played = load_mechanism(path), load(scenario, Scenario)
    tell_notes(path, assembled)
    inputs = [path, scenario]
    refuse_inputs(output, inputs)
    provenance = record(command_line("simulate", {"model": path, "--scenario": scenario}), inputs)
    names = Names(model=str(path), scenario=str(scenario))
    try:
        return open_test(document, assembled, played, provenance, names, progress, events.add), inputs
    except WrongElement as wrong:
        raise wrong_in_file(path, wrong) from None
