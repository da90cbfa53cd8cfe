"""Campaign as a Python function; unlike `frictool campaign`, it takes documents in memory.

    CampaignSetting ──varied_space.py──▶ FactorSpace ──sampling.py──▶ UnitDraws
    UnitDraws ──trial_player.py, trial_sharing.py──▶ Trials ──findings.py──▶ Findings
    Trials ──worst_case_search.py──▶ WorstCase ──▶ Findings

The command also stores completed trials, so that an interrupted campaign can be resumed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, get_args

from frictool.campaign.draws.sampling import Method, UnitDraws, draws_of
from frictool.campaign.statistics.clopper_pearson import CONFIDENCE
from frictool.campaign.statistics.findings import Findings, find
from frictool.campaign.trials.campaign_warnings import doubt_of, remarks_of
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
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.key_lines import document_error
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.logs.log import Log
from frictool.plant.mechanism.element_error import ElementError
from frictool.runtime.object_view import ResultView
from frictool.simulate.document_agreement import DocumentNames
from frictool.verify.recheck import recheck
from frictool.workers.job_sharing import share

TRIALS = 1000
# shortest expected duration of the work [s] for which parallel processes save time
WORTH_SHARING_S = 3.0


@dataclass(frozen=True, eq=False, repr=False)
class CampaignResult(ResultView):
    """Result of a campaign.

    `findings`: statistics of the trials.
    `worst`: worst case of each requirement, with a scenario that repeats it.
    """

    findings: Findings
    worst: tuple[WorstCase, ...]


@dataclass(frozen=True)
class CampaignRequest:
    """Options of a campaign.

    Attributes
    ----------
    trials : int or None
        Number of draws, by default 1000. For method `vertices`, the default is all vertices, but
        4096 random vertices if there are more than 4096.
    method : {"random", "latin", "vertices"}
        Method that chooses the draws.
    seed : int or None
        Seed of draws and noise; by default the scenario's seed.
    at_least : float or None
        Pass rate that the campaign must show, 0 to 1. By default every trial must pass.
    confidence : float
        Confidence level of intervals and bounds, 0 to 1.
    evaluations : int
        Largest number of plants in the worst-case search of each requirement; 0 for no search.
    number : {"double", "float", "q31"}
        Number format of the controller.
    cores : int or None
        Number of processes. If it is None, several processes are used only if this saves time. If
        `cores` is not 1, a script must call `campaign` inside `if __name__ == "__main__":`.
    cluster : str or None
        Address of a Dask scheduler; its workers run the trials.
    """

    trials: int | None = None
    method: Method = "random"
    seed: int | None = None
    at_least: float | None = None
    confidence: float = CONFIDENCE
    evaluations: int = 0
    number: ProgramNumber = "double"
    cores: int | None = 1
    cluster: str | None = None

    @property
    def count(self) -> int | None:
        """Return the number of draws; None for all vertices."""
        return TRIALS if self.trials is None and self.method != "vertices" else self.trials

    def check(self) -> None:
        """Raise FrictoolError for the first value that is out of range."""
        rate, cores = self.at_least, self.cores
        for name, fits, allowed in (
            ("method", self.method in get_args(Method), "random, latin, vertices"),
            ("trials", self.trials is None or self.trials >= 1, "1 or more"),
            ("seed", self.seed is None or self.seed >= 0, "0 or more"),
            ("at_least", rate is None or 0.0 < rate <= 1.0, "above 0, at most 1"),
            ("confidence", 0.0 < self.confidence < 1.0, "between 0 and 1"),
            ("evaluations", self.evaluations >= 0, "0 or more"),
            ("cores", cores is None or cores >= 1, "1 or more"),
        ):
            if not fits:
                raise FrictoolError(f"{name}: found {getattr(self, name)!r}; allowed: {allowed}")


USUAL = CampaignRequest()


@contextmanager
def _silent(label: str) -> Iterator[ProgressCallback]:
    yield lambda part: None


def campaign(
    plant: Model | Mechanism,
    controller: Controller,
    scenario: Scenario,
    spec: Spec,
    request: CampaignRequest = USUAL,
    *,
    recorded: Log | None = None,
    progress: ProgressContext = _silent,
) -> CampaignResult:
    """Simulate a scenario on many plants and judge each run by the specification.

    The plants are drawn from the ranges of the plant and of the scenario's `spread`. Nothing is
    stored on disk; only the command `frictool campaign` can resume an interrupted campaign.

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
    request : CampaignRequest
        Number and method of the draws, confidence, worst-case search, processes.
    recorded : Log, optional
        The log that the scenario replays.
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
        If the simulation of the nominal plant decides no requirement.
    ClusterError
        If the cluster cannot be used.
    FrictoolError
        If an argument is out of range.
    """
    request.check()
    setting = CampaignSetting(
        plant, controller, scenario, spec, recorded, DocumentNames(), request.number
    )
    check_requirements(spec, "spec")
    try:
        recheck(controller)
        seed = scenario.seed if request.seed is None else request.seed
        trial = TrialPlayer(setting, space_of_setting(setting), seed)
    except ElementError as wrong:
        raise document_error(setting.names.model, wrong.key, str(wrong)) from None
    trials, worst = conduct(
        trial,
        draws_of(request.method, request.count, trial.space.size, trial.seed),
        TrialStore(None, {}),
        request.evaluations,
        sharing(request.cores, request.cluster),
        commands_of(request.number),
        progress,
    )
    return CampaignResult(findings_of(trial, trials, worst, request), tuple(worst))


def findings_of(
    trial: TrialPlayer, trials: Trials, worst: Sequence[WorstCase], request: CampaignRequest
) -> Findings:
    """Return the findings: statistics of the trials, warnings, and a reason for doubt.

    The reason for doubt states why the axis may fail although the trials pass (`doubt_of`).
    """
    return find(
        trials,
        request.method,
        worst,
        request.at_least,
        request.confidence,
        remarks_of(trial.setting, trial.space),
        doubt_of(trial),
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
    """Run the trials of all draws, and search for the worst cases if `evaluations` is not 0.

    `shared`: function that distributes the trials to processes (`sharing`).
    `commands`: maps the name of a scenario file to the commands that simulate the file.

    Raises NoSolutionError if the simulation of the nominal plant decides no requirement.
    """
    nominal = check_nominal(trial.nominal(), trial.setting.names)
    begun = time.perf_counter()
    trial.nominal()  # the second run, without compilation, gives the duration of a trial
    each = time.perf_counter() - begun
    metrics = metrics_of(nominal)
    left = draws.units.shape[0] - len(store.trials)
    with progress("campaign") as tick:
        trials = run_trials(trial, metrics, draws.units, store, shared(left * each), tick, each)
    if not evaluations:
        return trials, []
    shared_search = shared(len(metrics) * evaluations * each)
    return trials, worst_cases(trial, trials, store, shared_search, evaluations, commands, progress)


def sharing(cores: int | None, cluster: str | None) -> Callable[[float], JobSharing]:
    """Return a function that maps the expected duration of the work [s] to a JobSharing.

    The JobSharing uses `cores` processes or the cluster. If both are None, it uses several
    processes only if they save time.
    """

    def of(seconds: float) -> JobSharing:
        processes = 1 if cores is None and seconds < WORTH_SHARING_S else cores

        def shared(function: Any, jobs: Any, batch: int, instead: Any) -> Any:
            return share(
                function, jobs, cores=processes, cluster=cluster, batch=batch, instead=instead
            )

        return shared

    return of
