"""`frictool simulate` of a mechanism.yaml: which file is one, under a controller, and without."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from frictool.cli.output import command_line, refuse_inputs

if TYPE_CHECKING:
    from frictool.logs.log import Log
    from frictool.simulate.mechanism_plant import MechanismPlant


def is_mechanism(path: Path) -> bool:
    """Whether the document at `path` says that it is a mechanism. Raises InputFileError where it is no document."""
    import yaml

    from frictool.documents.reading import compose, read_text

    node = compose(read_text(path), path)
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    return any(key.value == "format" and str(value.value).startswith("mechanism/") for key, value in pairs)


def mechanism_plant(path: Path) -> MechanismPlant:
    """The mechanism at `path` as a controller's plant. Raises DocumentError where it is none."""
    from frictool.cli.mechanism_file import load_mechanism, wrong_in_file
    from frictool.plant.mechanism.wrong import WrongElement
    from frictool.simulate.mechanism_plant import MechanismPlant

    document, assembled = load_mechanism(path)
    try:
        return MechanismPlant(document, assembled)
    except WrongElement as wrong:
        raise wrong_in_file(path, wrong) from None


def open_log(path: Path, scenario: Path, output: Path, progress: Callable[[int, int], None]) -> tuple[Log, list[Path]]:
    """The log of a scenario without a controller, and its inputs."""
    from frictool.cli.mechanism_file import load_mechanism, wrong_in_file
    from frictool.documents.provenance import record
    from frictool.documents.registry import load
    from frictool.documents.scenario import Scenario
    from frictool.plant.mechanism.wrong import WrongElement
    from frictool.simulate.agreement import Names
    from frictool.simulate.open_test import open_test

    (document, assembled), played = load_mechanism(path), load(scenario, Scenario)
    inputs = [path, scenario]
    refuse_inputs(output, inputs)
    provenance = record(command_line("simulate", {"model": path, "--scenario": scenario}), inputs)
    names = Names(model=str(path), scenario=str(scenario))
    try:
        return open_test(document, assembled, played, provenance, names, progress), inputs
    except WrongElement as wrong:
        raise wrong_in_file(path, wrong) from None
