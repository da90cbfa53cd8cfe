"""Worst case of a requirement, with a scenario file and the command that simulates it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec

from frictool.campaign.trials.differential_evolution import SearchResult
from frictool.campaign.trials.trials import MetricLimit
from frictool.documents.controller import ProgramNumber
from frictool.documents.scenario import Scenario
from frictool.documents.writing import to_yaml

# file name of a scenario -> `command` and `typed` of a WorstCase
Commands = Callable[[str], tuple[str, str]]


@dataclass(frozen=True)
class WorstCase:
    """Worst case of one requirement.

    `value`: worst value, in `unit`.
    `limit`: limit of the requirement, in `unit`.
    `values`: value of each factor in SI, by name.
    `scenario`: name of the scenario file, without folder.
    `command`: command that simulates the scenario, with file names without folders.
    `typed`: the same command with the paths of the user's command line, for the terminal only.
    `played`: content of the scenario file.
    """

    requirement: str
    value: float
    limit: float
    unit: str
    relation: str
    met: bool | None
    values: Mapping[str, float]
    scenario: str
    command: str
    typed: str
    played: Scenario
    searched: SearchResult


def file_name(metric: MetricLimit) -> str:
    """Return the name of the scenario file for the worst case of a metric."""
    return f"worst_{metric.name}.yaml"


def commands_of(number: ProgramNumber) -> Commands:
    """Return a function that computes `command` and `typed` of a WorstCase.

    The argument of this function is the name of the scenario file.
    """

    def of(scenario: str) -> tuple[str, str]:
        words = replay_command(
            "model.yaml",
            "controller.yaml",
            scenario,
            None,
            number,
            Path(scenario).with_suffix(".mcap").name,
        )
        return words, words

    return of


def replay_command(
    model: str,
    controller: str,
    scenario: str,
    observer: str | None,
    number: ProgramNumber,
    output: str,
) -> str:
    """Return the shell command that simulates a scenario."""
    words = ["frictool simulate", model, "--controller", controller, "--scenario", scenario]
    words += ["--observer", observer] if observer is not None else []
    words += ["--number", number] if number != "double" else []
    return " ".join([*words, "-o", output])


def text_of(case: WorstCase, folder: Path, origin: Path) -> str:
    """Return the text of the scenario file, which begins with a comment on the worst case.

    `folder`: folder of the file.
    `origin`: path of the campaign's scenario.
    """
    searched, played = case.searched, case.played
    name = f"worst {case.requirement.replace('_', ' ')}"
    replay = played.reference
    if replay is not None:  # the log's path is relative to the scenario's folder
        replay = msgspec.structs.replace(
            replay, log=Path(os.path.relpath(origin.parent / replay.log, folder)).as_posix()
        )
    shown = "never" if math.isinf(case.value) else f"{case.value!r} {case.unit}".rstrip()
    drawn = "never" if math.isinf(searched.drawn) else f"{searched.drawn:.6g} {case.unit}".rstrip()
    lines = [
        f"{case.requirement}: {shown}, where {case.relation} {case.limit:g} {case.unit}".rstrip()
        + f" is required; the worst draw has {drawn}",
        f"worst of {searched.evaluations} plants in a search that started from {origin.name}; "
        "worse plants may exist",
        case.command,
    ]
    body = to_yaml(msgspec.structs.replace(played, name=name, reference=replay))
    return "".join(f"# {line}\n" for line in lines) + body
