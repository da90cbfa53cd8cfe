"""A campaign from its documents to what it says: what `frictool campaign` does, on values in memory.

Setting ──varied.py──▶ Space ──sampling.py──▶ Draws ──playing.py, running.py──▶ Trials ──findings.py──▶ Findings
                                                          searching.py ──▶ WorstCase ──────┘
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from frictool.campaign.drawing.sampling import Draws, Method, draws_of
from frictool.campaign.playing.playing import CampaignTrial, Setting, metrics_of, simulated
from frictool.campaign.playing.remarks import remarks_of
from frictool.campaign.playing.running import Share, Tell, run_trials
from frictool.campaign.playing.searching import Progress, worst_cases
from frictool.campaign.playing.store import Store
from frictool.campaign.playing.trials import Trials
from frictool.campaign.playing.varied import check_asks, space_of_setting
from frictool.campaign.playing.worst_case import Commands, WorstCase, commands_of
from frictool.campaign.statistics.binomial import CONFIDENCE
from frictool.campaign.statistics.findings import Findings, find
from frictool.documents.controller import Controller, Number
from frictool.documents.lines import complaint
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.logs.log import Log
from frictool.plant.mechanism.wrong import WrongElement
from frictool.simulate.agreement import Names
from frictool.verify.recheck import recheck
from frictool.workers.share import share

TRIALS = 1000
WORTH_SHARING_S = 3.0  # of work, below which the start of further processes takes longer than they save


@dataclass(frozen=True)
class Campaigned:
    """findings: what the trials say. worst: of each requirement the worst case that was searched, with the scenario that plays it."""

    findings: Findings
    worst: tuple[WorstCase, ...]


@contextmanager
def _silent(label: str) -> Iterator[Tell]:
    yield lambda part: None


def campaign(
    plant: Model | Mechanism,
    controller: Controller,
    scenario: Scenario,
    spec: Spec,
    *,
    trials: int | None = None,
    method: Method = "random",
    seed: int | None = None,
    at_least: float | None = None,
    confidence: float = CONFIDENCE,
    evaluations: int = 0,
    number: Number = "double",
    recorded: Log | None = None,
    cores: int | None = 1,
    cluster: str | None = None,
    progress: Progress = _silent,
) -> Campaigned:
    """The scenario played to many plants, each run judged by the specification: how many pass, how sure that is, what fails and why.

    trials: how many draws, 1000 where None, of vertices all, at most 4096. seed: of draws and noise, the scenario's where None. at_least:
    the pass rate, 0..1, that has to be shown; None: every trial passes. evaluations: how many plants the search for the worst case of each
    requirement may try; 0: none is searched. recorded: the log that a scenario replays. cores: processes, as many as are worth their start
    where None; more than one needs a script whose work stands below `if __name__ == "__main__":`. cluster: address of a Dask scheduler,
    whose workers do the work. progress: of a label, a context that gives what is told the part that is done. Nothing is kept while it runs:
    what is to outlive a kill is the command's.
    Raises DocumentError where the documents do not fit together or nothing varies, NoSolutionError where the nominal plant decides nothing,
    ClusterError where the cluster cannot be used, FrictoolError where an argument is none that is allowed.
    """
    _check(method, trials, seed, at_least, confidence, evaluations, cores)
    setting, count = Setting(plant, controller, scenario, spec, recorded, Names(), number), trials
    check_asks(spec, "spec")
    try:
        recheck(controller)
        trial = CampaignTrial(setting, space_of_setting(setting), scenario.seed if seed is None else seed)
    except WrongElement as wrong:
        raise complaint(setting.names.model, wrong.key, str(wrong)) from None
    if count is None and method != "vertices":
        count = TRIALS
    draws = draws_of(method, count, trial.space.size, trial.seed)
    played, worst = conduct(trial, draws, Store(None, {}), evaluations, sharing(cores, cluster), commands_of(number), progress)
    return Campaigned(find(played, method, worst, at_least, confidence, remarks_of(setting, trial.space)), tuple(worst))


def conduct(
    trial: CampaignTrial,
    draws: Draws,
    store: Store,
    evaluations: int,
    shared: Callable[[float], Share],
    commands: Commands,
    progress: Progress,
) -> tuple[Trials, list[WorstCase]]:
    """All trials, and the worst cases, where `evaluations` is not 0; what `store` has is not played again.

    shared: of about how long the work takes [s], how it is shared. commands: what plays a worst case's scenario again.
    Raises NoSolutionError where the nominal plant decides nothing.
    """
    nominal = simulated(trial.nominal(), trial.setting.names)
    begun = time.perf_counter()
    trial.nominal()  # compiled by now: how long a trial takes
    each = time.perf_counter() - begun
    metrics, left = metrics_of(nominal), draws.units.shape[0] - len(store.trials)
    with progress("campaign") as tell:
        trials = run_trials(trial, trial.space, metrics, draws.units, store, shared(left * each), tell, each)
    if not evaluations:
        return trials, []
    return trials, worst_cases(trial, trials, store, shared(len(metrics) * evaluations * each), evaluations, commands, progress)


def sharing(cores: int | None, cluster: str | None) -> Callable[[float], Share]:
    """Of about how long work takes [s], how it is shared: where `cores` is None, among processes only where these are worth their start."""

    def of(seconds: float) -> Share:
        processes = 1 if cores is None and seconds < WORTH_SHARING_S else cores

        def shared(function: Any, jobs: Any, batch: int, instead: Any) -> Any:
            return share(function, jobs, cores=processes, cluster=cluster, batch=batch, instead=instead)

        return shared

    return of


def _check(
    method: str, trials: int | None, seed: int | None, at_least: float | None, confidence: float, evaluations: int, cores: int | None
) -> None:
    """Raises FrictoolError with the first that is not allowed."""
    for name, found, fits, allowed in (
        ("method", method, method in ("random", "latin", "vertices"), "random, latin, vertices"),
        ("trials", trials, trials is None or trials >= 1, "1 or more"),
        ("seed", seed, seed is None or seed >= 0, "0 or more"),
        ("at_least", at_least, at_least is None or 0.0 < at_least <= 1.0, "above 0, at most 1"),
        ("confidence", confidence, 0.0 < confidence < 1.0, "between 0 and 1"),
        ("evaluations", evaluations, evaluations >= 0, "0 or more"),
        ("cores", cores, cores is None or cores >= 1, "1 or more"),
    ):
        if not fits:
            raise FrictoolError(f"{name}: found {found!r}; allowed: {allowed}")
