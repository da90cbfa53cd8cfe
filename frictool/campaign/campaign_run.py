"""Complete campaign on documents in memory, as `frictool campaign` runs it.

    CampaignSetting ──varied_space.py──▶ FactorSpace ──sampling.py──▶ UnitDraws
    UnitDraws ──trial_player.py, trial_sharing.py──▶ Trials ──findings.py──▶ Findings
    Trials ──worst_case_search.py──▶ WorstCase ──▶ Findings

The command adds a file of completed trials, so that it can resume a killed campaign.
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
    3.0  # s, amount of work below which starting further processes takes longer than they save
)


@dataclass(frozen=True)
class CampaignResult:
    """Result of a campaign.

    `findings`: statistics of the trials. `worst`: the worst case found for each requirement, with
    the scenario that replays it.
    """

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
    """Simulate a scenario on many plants and judge each run by the specification.

    The plants are drawn from the ranges of the plant and of the scenario's `spread`. Nothing is
    stored on disk while the campaign runs; the command `frictool campaign` can resume a killed
    campaign.

    Parameters
    ----------
    plant : Model or Mechanism
        The nominal plant with its ranges.
    controller : Controller
        The controller under test.
    scenario : Scenario
        The test, with the variations in `spread`.
    spec : Spec
        The requirements.
    trials : int, optional
        Number of draws. By default 1000, or all vertices, at most 4096.
    method : {"random", "latin", "vertices"}
        Choice of the draws.
    seed : int, optional
        Seed of draws and noise; by default that of the scenario.
    at_least : float, optional
        Pass rate to show, 0 to 1. By default every trial must pass.
    confidence : float
        Confidence of intervals and bounds, 0 to 1.
    evaluations : int
        Number of plants that the worst-case search of each requirement may try; 0 for no search.
    number : {"double", "float", "q31", "q15"}
        Number format of the controller.
    recorded : Log, optional
        The log that the scenario replays.
    cores : int, optional
        Number of processes; None uses as many as save time. With more than one, the work of the
        calling
        script must be below `if __name__ == "__main__":`.
    cluster : str, optional
        Address of a Dask scheduler whose workers run the trials.
    progress : callable
        `progress(label)` returns a context manager that yields a callback taking the completed
        fraction (0 to 1).

    Returns
    -------
    CampaignResult
        Statistics of the trials and worst cases.

    Raises
    ------
    DocumentError
        If the documents do not fit together, or nothing varies.
    NoSolutionError
        If the nominal run decides no requirement.
    ClusterError
        If the cluster cannot be used.
    FrictoolError
        If an argument is out of range.
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
    """Run all trials, and search for the worst cases if `evaluations` is not 0.

    Trials in `store` are not repeated. `shared` maps the expected duration of the work [s] to a
    function that distributes it. `commands` returns the command that replays a worst case's
    scenario. Raises NoSolutionError if the nominal run decides no requirement.
    """
    nominal = check_nominal(trial.nominal(), trial.setting.names)
    begun = time.perf_counter()
    trial.nominal()  # second run, without compilation, for the duration of a trial
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
    """Return a function from the expected duration of work [s] to its distribution.

    If `cores` is None, work goes to several processes only if that saves time.
    """

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
    """Raise FrictoolError for the first argument that is out of range."""
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
