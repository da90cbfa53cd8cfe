"""A campaign from its documents to what it says: what `frictool campaign` does, on values in
memory.

Setting ──varied_space.py──▶ Space ──sampling.py──▶ Draws ──playing.py, trial_sharing.py──▶ Trials
──findings.py──▶ Findings
                                                          worst_case_search.py ──▶ WorstCase ──────┘
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from frictool.campaign.draws.sampling import Method, UnitDraws, draws_of
from frictool.campaign.statistics.clopper_pearson import CONFIDENCE
from frictool.campaign.statistics.findings import Findings, find
from frictool.campaign.trials.campaign_warnings import remarks_of
from frictool.campaign.trials.trial_player import (
    CampaignSetting,
    TrialPlayer,
    check_nominal,
    metrics_of,
)
from frictool.campaign.trials.trial_sharing import JobSharing, ProgressCallback, run_trials
from frictool.campaign.trials.trial_store import TrialStore
from frictool.campaign.trials.trials import Trials
from frictool.campaign.trials.varied_space import check_requirements, space_of_setting
from frictool.campaign.trials.worst_case import Commands, WorstCase, commands_of
from frictool.campaign.trials.worst_case_search import ProgressContext, worst_cases
from frictool.documents.controller import Controller, Number
from frictool.documents.key_lines import document_error
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.logs.log import Log
from frictool.plant.mechanism.element_error import ElementError
from frictool.simulate.document_agreement import DocumentNames
from frictool.verify.recheck import recheck
from frictool.workers.share import share

TRIALS = 1000
WORTH_SHARING_S = (
    3.0  # of work, below which the start of further processes takes longer than they save
)


@dataclass(frozen=True)
class CampaignResult:
    """findings: what the trials say. worst: of each requirement the worst case that was searched,
    with the scenario that plays it."""

    findings: Findings
    worst: tuple[WorstCase, ...]


@contextmanager
def _silent(label: str) -> Iterator[ProgressCallback]:
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
    progress: ProgressContext = _silent,
) -> CampaignResult:
    """The scenario played to many plants, each run judged by the specification: how many pass, how
    sure that is, what fails and why.

    trials: how many draws, 1000 where None, of vertices all, at most 4096. seed: of draws and
    noise, the scenario's where None. at_least: the pass rate, 0..1, that has to be shown; None:
    every trial passes. evaluations: how many plants the search for the worst case of each
    requirement may try; 0: none is searched. recorded: the log that a scenario replays. cores:
    processes, as many as are worth their start where None; more than one needs a script whose work
    stands below `if __name__ == "__main__":`. cluster: address of a Dask scheduler, whose workers
    do the work. progress: of a label, a context that gives what is told the part that is done.
    Nothing is kept while it runs: what is to outlive a kill is the command's. Raises DocumentError
    where the documents do not fit together or nothing varies, NoSolutionError where the nominal
    plant decides nothing, ClusterError where the cluster cannot be used, FrictoolError where an
    argument is none that is allowed.
    """
    _check(method, trials, seed, at_least, confidence, evaluations, cores)
    setting, count = (
        CampaignSetting(plant, controller, scenario, spec, recorded, DocumentNames(), number),
        trials,
    )
    check_requirements(spec, "spec")
    try:
        recheck(controller)
        trial = TrialPlayer(
            setting, space_of_setting(setting), scenario.seed if seed is None else seed
        )
    except ElementError as wrong:
        raise document_error(setting.names.model, wrong.key, str(wrong)) from None
    if count is None and method != "vertices":
        count = TRIALS
    draws = draws_of(method, count, trial.space.size, trial.seed)
    played, worst = conduct(
        trial,
        draws,
        TrialStore(None, {}),
        evaluations,
        sharing(cores, cluster),
        commands_of(number),
        progress,
    )
    return CampaignResult(
        find(played, method, worst, at_least, confidence, remarks_of(setting, trial.space)),
        tuple(worst),
    )


def conduct(
    trial: TrialPlayer,
    draws: UnitDraws,
    store: TrialStore,
    evaluations: int,
    shared: Callable[[float], JobSharing],
    commands: Commands,
    progress: ProgressContext,
) -> tuple[Trials, list[WorstCase]]:
    """All trials, and the worst cases, where `evaluations` is not 0; what `store` has is not played
    again.

    shared: of about how long the work takes [s], how it is shared. commands: what plays a worst
    case's scenario again. Raises NoSolutionError where the nominal plant decides nothing.
    """
    nominal = check_nominal(trial.nominal(), trial.setting.names)
    begun = time.perf_counter()
    trial.nominal()  # compiled by now: how long a trial takes
    each = time.perf_counter() - begun
    metrics, left = metrics_of(nominal), draws.units.shape[0] - len(store.trials)
    with progress("campaign") as tell:
        trials = run_trials(
            trial, trial.space, metrics, draws.units, store, shared(left * each), tell, each
        )
    if not evaluations:
        return trials, []
    return trials, worst_cases(
        trial,
        trials,
        store,
        shared(len(metrics) * evaluations * each),
        evaluations,
        commands,
        progress,
    )


def sharing(cores: int | None, cluster: str | None) -> Callable[[float], JobSharing]:
    """Of about how long work takes [s], how it is shared: where `cores` is None, among processes
    only where these are worth their start."""

    def of(seconds: float) -> JobSharing:
        processes = 1 if cores is None and seconds < WORTH_SHARING_S else cores

        def shared(function: Any, jobs: Any, batch: int, instead: Any) -> Any:
            return share(
                function, jobs, cores=processes, cluster=cluster, batch=batch, instead=instead
            )

        return shared

    return of


def _check(
    method: str,
    trials: int | None,
    seed: int | None,
    at_least: float | None,
    confidence: float,
    evaluations: int,
    cores: int | None,
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
