"""Distribution of trials to workers.

A job is a draw without a stored result. The workers return results in any order; each batch is
stored when it arrives. `Trials` has the results in the order of the draws.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, overload

import numpy as np

from frictool.campaign.trials.trial_player import TrialPlayer
from frictool.campaign.trials.trial_store import TrialStore
from frictool.campaign.trials.trials import MetricLimit, TrialResult, Trials, collect_trials
from frictool.typing import IntVector, Vector

Job = tuple[int, tuple[float, ...]]  # index of the draw, point in the cube
ProgressCallback = Callable[[float], None]
# duration of a batch of jobs [s]; largest number of jobs in a batch
TOGETHER_S = 0.3
MOST_TOGETHER = 500


class JobSharing(Protocol):
    """Interface of a function that runs jobs in processes or a cluster (workers/job_sharing.py)."""

    def __call__(
        self, function: Callable[[Any], Any], jobs: Sequence[Any], batch: int, instead: Any
    ) -> Iterator[tuple[int, Any]]:
        """Apply `function` to each job; yield (index of the job, result) in any order.

        `batch`: number of jobs that are sent to a worker together.
        `instead`: function that takes a job and a reason, and returns a substitute for the result.
            It is called if several processes died while they ran this job.
        """


class DrawJobs(Sequence[Job]):
    """Sequence of jobs (index of a draw, point of the unit cube) of draws without a stored result.

    - units: all n draws, points (n, d) in the unit cube of the d factors
    - left: indices of the draws without a stored result
    """

    def __init__(self, units: Vector, left: IntVector) -> None:
        self._units, self._left = units, left

    def __len__(self) -> int:
        return int(self._left.size)

    @overload
    def __getitem__(self, index: int) -> Job: ...

    @overload
    def __getitem__(self, index: slice) -> DrawJobs: ...

    def __getitem__(self, index: int | slice) -> Job | DrawJobs:
        if isinstance(index, slice):
            return DrawJobs(self._units, self._left[index])
        draw = int(self._left[index])
        return draw, tuple(self._units[draw].tolist())


def run_trials(
    play: TrialPlayer,
    metrics: Sequence[MetricLimit],
    units: Vector,
    store: TrialStore,
    share: JobSharing,
    tick: ProgressCallback = lambda part: None,
    each_s: float = 0.0,
) -> Trials:
    """Run the trials that are not in `store`; return the trials of all draws `units` (n, d).

    `tick`: function that is called with the completed fraction, 0 to 1.
    `each_s`: expected duration of a trial [s].
    """
    count = units.shape[0]
    jobs = DrawJobs(
        units, np.array([k for k in range(count) if k not in store.trials], dtype=np.int64)
    )
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
                tick(done / len(jobs))
    finally:  # an interrupt loses no completed trial
        store.add(waiting)
    tick(1.0)
    return collect_trials(play.space, metrics, units, (store.trials[draw] for draw in range(count)))


def _not_outlived(job: Job, reason: str) -> TrialResult:
    return TrialResult(job[0], (), (), reason)
