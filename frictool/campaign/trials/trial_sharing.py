"""The trials of a campaign, played by whoever shares the work, kept as they are done.

draws ──those not kept yet──▶ jobs ──share──▶ Trial, Trial, ... in any order ──▶ Store ──▶ all of
them, in order
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from frictool.campaign.draws.space import FactorSpace
from frictool.campaign.trials.differential_evolution import SearchResult
from frictool.campaign.trials.trial_store import SearchKey, TrialStore
from frictool.campaign.trials.trials import MetricLimit, TrialResult, Trials, collect_trials

Vector = NDArray[np.float64]
Job = tuple[int, tuple[float, ...]]  # number of the draw, and where it is in the cube
ProgressCallback = Callable[[float], None]
TOGETHER_S, MOST_TOGETHER = 0.3, 500  # jobs travel together so that they take about so long


class JobSharing(Protocol):
    """frictool/workers/share.py `share`, with cores and cluster chosen."""

    def __call__(
        self, function: Callable[[Any], Any], jobs: Sequence[Any], batch: int, instead: Any
    ) -> Iterator[tuple[int, Any]]: ...


def run_trials(
    play: Callable[[Job], TrialResult],
    space: FactorSpace,
    metrics: Sequence[MetricLimit],
    units: Vector,
    store: TrialStore,
    share: JobSharing,
    tell: ProgressCallback = lambda part: None,
    each_s: float = 0.0,
) -> Trials:
    """All trials of the draws `units` (n, d), of which `store` has some. tell: is told the part
    that is done, 0..1. each_s: about how long one takes."""
    count = units.shape[0]
    jobs: list[Job] = [
        (draw, tuple(map(float, units[draw]))) for draw in range(count) if draw not in store.trials
    ]
    batch = int(
        min(max(1.0, TOGETHER_S / max(each_s, 1e-6)), MOST_TOGETHER, max(1.0, len(jobs) / 16))
    )
    waiting: list[TrialResult] = []
    try:
        for done, (_, trial) in enumerate(share(play, jobs, batch, _not_outlived), start=1):
            waiting.append(trial)
            if len(waiting) >= batch:
                store.add(waiting)
                waiting = []
                tell(done / len(jobs))
    finally:  # whoever interrupts loses none that is done
        store.add(waiting)
    tell(1.0)
    return collect_trials(space, metrics, units, (store.trials[draw] for draw in range(count)))


def _not_outlived(job: Job, reason: str) -> TrialResult:
    return TrialResult(job[0], (), (), reason)


class SearchJob(Protocol):
    """What a search for the worst case of one metric is given."""

    @property
    def asked(self) -> SearchKey: ...


def run_searches(
    look: Callable[[Any], SearchResult],
    jobs: Sequence[SearchJob],
    store: TrialStore,
    share: JobSharing,
    tell: ProgressCallback,
) -> list[SearchResult]:
    """The worst case of each job's metric, in their order, of which `store` has some."""
    left = [job for job in jobs if job.asked not in store.worst]
    for done, (index, worst) in enumerate(share(look, left, 1, None), start=1):
        store.add_worst(left[index].asked, worst)
        tell(done / len(left))
    return [store.worst[job.asked] for job in jobs]


def starts_of(trials: Trials, metric: int, most: int) -> NDArray[np.int64]:
    """The draws with the worst values of a metric, the worst first; empty where none has one."""
    sign = 1.0 if trials.metrics[metric].relation == "<=" else -1.0
    badness = np.where(np.isnan(trials.found[:, metric]), -np.inf, sign * trials.found[:, metric])
    order = np.argsort(-badness, kind="stable")[:most]
    return np.asarray(order[badness[order] > -np.inf], dtype=np.int64)
