"""`frictool simulate` of a mechanism.yaml, with or without a controller."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from frictool.cli.output_files import command_line, refuse_inputs, save_text

if TYPE_CHECKING:
    from frictool.cli.position_loop_options import ServoGains
    from frictool.engine.bench_position_loop import PositionServo
    from frictool.logs.log import Log
    from frictool.simulate.mechanism_bench import MechanismBenchPlant
    from frictool.simulate.mechanism_events import EventCsv
    from frictool.simulate.mechanism_plant import MechanismPlant
    from frictool.simulate.mechanism_runs import MechanismOutcome


def is_mechanism(path: Path) -> bool:
    """Return True if the document at `path` is a mechanism.

    Raises InputFileError if the file is not a document.
    """
    from frictool.documents.document_text import is_format

    return is_format(path, "mechanism")


class EventsOutput:
    """Output of --events: path of the file (None without --events), and table of the events."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._table: EventCsv | None = None

    def add(self, moved: MechanismOutcome) -> None:
        """Add the events of one simulated variant."""
        if self.path is None:
            return
        from frictool.simulate.mechanism_events import EventCsv

        self._table = self._table or EventCsv()
        self._table.add(moved)

    def save(self, inputs: list[Path]) -> None:
        """Write the table of events to the file of --events, if this option is used."""
        if self.path is not None and self._table is not None:
            save_text(self.path, self._table.text, inputs)


def mechanism_plant(path: Path, events: EventsOutput) -> MechanismPlant:
    """Load the mechanism at `path` as the plant of a controller.

    Raises DocumentError if a controller cannot drive the mechanism.
    """
    from frictool.cli.mechanism_file import load_mechanism, mechanism_error, print_notes
    from frictool.plant.mechanism.element_error import ElementError
    from frictool.simulate.mechanism_plant import MechanismPlant

    document, assembled = load_mechanism(path)
    print_notes(path, assembled)
    try:
        return MechanismPlant(document, assembled, events.add)
    except ElementError as wrong:
        raise mechanism_error(path, wrong) from None


def on_bench(path: Path, gains: ServoGains) -> tuple[MechanismBenchPlant, PositionServo]:
    """Load the mechanism at `path`; return the plant of a bench test, and a position controller."""
    import math

    from frictool.simulate.mechanism_bench import MechanismBenchPlant

    plant = mechanism_plant(path, EventsOutput(None))
    limit = plant.document.sources[plant.assembled.sources[plant.controlled.source]].limit
    return MechanismBenchPlant(plant), gains.on_drive(
        plant.rig.constant, math.inf if limit is None else limit.value
    )


def open_log(
    path: Path,
    scenario: Path,
    output: Path,
    progress: Callable[[int, int], None],
    events: EventsOutput,
) -> tuple[Log, list[Path]]:
    """Simulate a scenario without a controller; return the log and the paths of the input files."""
    from frictool.cli.mechanism_file import load_mechanism, mechanism_error, print_notes
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.documents.scenario import Scenario
    from frictool.plant.mechanism.element_error import ElementError
    from frictool.simulate.document_agreement import DocumentNames
    from frictool.simulate.open_loop import simulate_open_loop

    (document, assembled), played = load_mechanism(path), load(scenario, Scenario)
    print_notes(path, assembled)
    inputs = [path, scenario]
    refuse_inputs(output, inputs)
    provenance = provenance_of_command(
        command_line("simulate", {"model": path, "--scenario": scenario}), inputs
    )
    names = DocumentNames(model=str(path), scenario=str(scenario))
    try:
        return simulate_open_loop(
            document, assembled, played, provenance, names, progress, events.add
        ), inputs
    except ElementError as wrong:
        raise mechanism_error(path, wrong) from None
