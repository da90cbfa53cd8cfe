"""The worst case of each requirement: searched, played once more, and kept as a scenario."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from frictool.campaign.drawn import scenario_of
from frictool.campaign.running import Share, run_searches, starts_of
from frictool.campaign.store import Store
from frictool.campaign.trials import BROKEN, MET, Trials
from frictool.campaign.worst import Worst
from frictool.campaign.worst_case import WorstCase, file_name, text_of
from frictool.cli.campaign_setting import Paths
from frictool.cli.campaign_trial import CampaignTrial, SearchTask, WorstSearch
from frictool.cli.progress import progress

if TYPE_CHECKING:
    from frictool.documents.controller import Number

STARTS = 5  # worst draws that a search begins with
OF_THE_CONTROLLER = "modulus_margin"  # the same for every plant


class Asked(Protocol):
    """Of the command line."""

    @property
    def worst(self) -> Path | None: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def number(self) -> Number: ...


def worst_cases(
    trial: CampaignTrial, trials: Trials, store: Store, share: Share, paths: Paths, asked: Asked
) -> list[tuple[WorstCase, str]]:
    """Of each requirement that any draw decides: the worst case that a search finds, and the text of its scenario."""
    jobs = [job for index in range(len(trials.metrics)) if (job := _task(trial, trials, index, asked.evaluations)) is not None]
    with progress("worst cases") as tell:
        found = run_searches(WorstSearch(trial), jobs, store, share, tell)
    return [_kept(trial, trials, job.metric, worst, paths, asked) for job, worst in zip(jobs, found, strict=True)]


def _task(trial: CampaignTrial, trials: Trials, index: int, evaluations: int) -> SearchTask | None:
    metric, draws = trials.metrics[index], starts_of(trials, index, STARTS)
    if metric.key == OF_THE_CONTROLLER or not draws.size:
        return None
    first = int(draws[0])
    drawn = float(trials.found[first, index])
    return SearchTask(metric.name, index, metric.relation, drawn, first, trials.units[draws], evaluations, trials.count, trial.seed)


def _kept(trial: CampaignTrial, trials: Trials, index: int, worst: Worst, paths: Paths, asked: Asked) -> tuple[WorstCase, str]:
    """Played once more, so that what is said of it is what its scenario gives."""
    assert asked.worst is not None
    metric, unit = trials.metrics[index], np.array(worst.unit)
    again = trial.played(unit, worst.noise)
    met = {MET: True, BROKEN: False}.get(again.met[index] if again.met else -1)
    values = trial.space.values(unit[None, :])[0]
    case = WorstCase(
        requirement=metric.name,
        value=again.found[index],
        limit=metric.limit,
        unit=metric.unit,
        relation=metric.relation,
        met=met,
        values=dict(zip(trial.space.names, map(float, values), strict=True)),
        scenario=file_name(metric),
        command=_command(Path(file_name(metric)), paths, asked.number, lambda path: path.name),
        typed=_command(asked.worst / file_name(metric), paths, asked.number, lambda path: shlex.quote(str(path))),
        searched=worst,
    )
    step = trial.test.plant.rig.resolution
    played = scenario_of(trial.setting.scenario, trial.space, values, (trial.seed, worst.noise), step)
    return case, text_of(case, played, asked.worst, paths.scenario)


def _command(scenario: Path, paths: Paths, number: Number, shown: Callable[[Path], str]) -> str:
    """What plays it again, each path as `shown`."""
    words = ["frictool simulate", shown(paths.model), "--controller", shown(paths.controller), "--scenario", shown(scenario)]
    words += ["--observer", shown(paths.observer)] if paths.observer is not None else []
    words += ["--number", number] if number != "double" else []
    return " ".join([*words, "-o", shown(scenario.with_suffix(".mcap"))])
