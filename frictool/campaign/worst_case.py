"""A worst case as it is kept: the scenario that plays it again, what is said above it, and what a page says of it."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec

from frictool.campaign.trials import Metric
from frictool.campaign.worst import Worst
from frictool.documents.scenario import Scenario
from frictool.documents.writing import to_yaml


@dataclass(frozen=True)
class WorstCase:
    """Of one requirement, campaign/findings.py `Worst`. values: of the factors, by name. scenario: the file's base name.

    command: what plays it again, by base names; typed: the same with the paths of the command line, for a terminal and no document.
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
    searched: Worst


def file_name(metric: Metric) -> str:
    """What the scenario of a metric's worst case is called."""
    return f"worst_{metric.name}.yaml"


def text_of(case: WorstCase, played: Scenario, folder: Path, origin: Path) -> str:
    """The scenario's file in `folder`, with what it is above it; the scenario `origin` is what it was made of."""
    found = case.searched
    name = f"worst {case.requirement.replace('_', ' ')}"
    replay = played.reference
    if replay is not None:  # its path is one from the scenario's folder
        replay = msgspec.structs.replace(replay, log=Path(os.path.relpath(origin.parent / replay.log, folder)).as_posix())
    shown = "never" if math.isinf(case.value) else f"{case.value!r} {case.unit}".rstrip()
    drawn = "never" if math.isinf(found.drawn) else f"{found.drawn:.6g} {case.unit}".rstrip()
    lines = [
        f"{case.requirement}: {shown}, where {case.relation} {case.limit:g} {case.unit}".rstrip()
        + f" is asked; the worst draw has {drawn}",
        f"found among {found.evaluations} plants that a search has tried, made of {origin.name}; worse ones may exist",
        case.command,
    ]
    body = to_yaml(msgspec.structs.replace(played, name=name, reference=replay))
    return "".join(f"# {line}\n" for line in lines) + body
