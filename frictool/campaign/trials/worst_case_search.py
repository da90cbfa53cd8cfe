"""Searches for the worst case of each requirement, and the scenarios of the worst cases."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import NamedTuple

import numpy as np

from frictool.campaign.draws.drawn_scenario import scenario_of
from frictool.campaign.trials.differential_evolution import SearchResult, search_worst
from frictool.campaign.trials.trial_player import TrialPlayer
from frictool.campaign.trials.trial_sharing import JobSharing, ProgressCallback
from frictool.campaign.trials.trial_store import SearchKey, TrialStore
from frictool.campaign.trials.trials import BROKEN, MET, Trials
from frictool.campaign.trials.worst_case import Commands, WorstCase, file_name
from frictool.typing import IntVector, Vector

STARTS = 5  # number of worst draws from which a search starts
ProgressContext = Callable[[str], AbstractContextManager[ProgressCallback]]


class SearchTask(NamedTuple):
    """Task of a search for the worst case of one metric.

    `name`, `metric`: name and index of the metric.
    `drawn`: value of the metric for the worst draw.
    `noise`: index of the worst draw; every run of the search has the noise of this draw.
    `starts` (k, d): values of the d factors, 0 to 1, in the k worst draws.
    `evaluations`: largest number of plants to try.
    """

    name: str
    metric: int
    relation: str
    drawn: float
    noise: int
    starts: Vector
    evaluations: int
    draws: int
    seed: int

    @property
    def key(self) -> SearchKey:
        """Return the key of the search in `TrialStore.worst`."""
        return self.name, self.evaluations, self.draws


class WorstSearch:
    """Callable that runs a SearchTask in a worker process."""

    def __init__(self, trial: TrialPlayer) -> None:
        self.trial = trial

    def __call__(self, task: SearchTask) -> SearchResult:
        """Run the search; every plant has the noise of the worst draw."""
        sign = 1.0 if task.relation == "<=" else -1.0
        unplayed = 0

        def badness(unit: Vector) -> float:
            nonlocal unplayed
            trial = self.trial.played(unit, task.noise)
            unplayed += bool(trial.failed)
            value = math.nan if trial.failed else trial.metric_values[task.metric]
            return -math.inf if math.isnan(value) else sign * value

        state = search_worst(badness, task.starts, task.evaluations, task.seed)
        where = tuple(map(float, state.at))
        return SearchResult(
            task.name, sign * state.worst, task.drawn, where, task.noise, state.tried, unplayed
        )


def worst_cases(
    trial: TrialPlayer,
    trials: Trials,
    store: TrialStore,
    share: JobSharing,
    evaluations: int,
    commands: Commands,
    progress: ProgressContext,
) -> list[WorstCase]:
    """Return the worst case of each requirement that at least one draw decides.

    `evaluations`: largest number of plants to try for each requirement.
    `commands`: maps the name of a scenario file to the commands that simulate the file.
    `progress`: `progress(label)` returns a context manager that yields a callback taking the
        completed fraction, 0 to 1.
    """
    jobs = [
        job
        for index in range(len(trials.metrics))
        if (job := _task(trial, trials, index, evaluations)) is not None
    ]
    with progress("worst cases") as tick:
        results = _search(WorstSearch(trial), jobs, store, share, tick)
    return [
        _kept(trial, trials, job.metric, worst, commands)
        for job, worst in zip(jobs, results, strict=True)
    ]


def _search(
    search: WorstSearch,
    tasks: Sequence[SearchTask],
    store: TrialStore,
    share: JobSharing,
    tick: ProgressCallback,
) -> list[SearchResult]:
    left = [task for task in tasks if task.key not in store.worst]
    for done, (index, worst) in enumerate(share(search, left, 1, None), start=1):
        store.add_worst(left[index].key, worst)
        tick(done / len(left))
    return [store.worst[task.key] for task in tasks]


def _worst_draws(trials: Trials, metric: int) -> IntVector:
    sign = 1.0 if trials.metrics[metric].relation == "<=" else -1.0
    badness = np.where(
        np.isnan(trials.metric_values[:, metric]), -np.inf, sign * trials.metric_values[:, metric]
    )
    order = np.argsort(-badness, kind="stable")[:STARTS]
    return np.asarray(order[badness[order] > -np.inf], dtype=np.int64)


def _task(trial: TrialPlayer, trials: Trials, index: int, evaluations: int) -> SearchTask | None:
    metric = trials.metrics[index]
    draws = _worst_draws(trials, index)
    if not draws.size:
        return None
    first = int(draws[0])
    drawn = float(trials.metric_values[first, index])
    return SearchTask(
        metric.name,
        index,
        metric.relation,
        drawn,
        first,
        trials.units[draws],
        evaluations,
        trials.count,
        trial.seed,
    )


def _kept(
    trial: TrialPlayer, trials: Trials, index: int, worst: SearchResult, commands: Commands
) -> WorstCase:
    metric = trials.metrics[index]
    unit = np.array(worst.unit)
    again = trial.played(unit, worst.noise)
    values = trial.space.values(unit[None, :])[0]
    step = trial.test.plant.rig.resolution
    command, typed = commands(file_name(metric))
    return WorstCase(
        requirement=metric.name,
        value=again.metric_values[index],
        limit=metric.limit,
        unit=metric.unit,
        relation=metric.relation,
        met={MET: True, BROKEN: False}.get(again.met[index] if again.met else -1),
        values=dict(zip(trial.space.names, map(float, values), strict=True)),
        scenario=file_name(metric),
        command=command,
        typed=typed,
        played=scenario_of(
            trial.setting.scenario, trial.space, values, (trial.seed, worst.noise), step
        ),
        searched=worst,
    )
