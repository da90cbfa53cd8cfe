"""Distribution of jobs to processes or to the workers of a cluster; each job has one result.

    jobs ──task_batch.py──▶ tasks ──┬── in this process
                                    ├── process_pool.py   one process per core
                                    └── dask_cluster.py   workers of a Dask scheduler
         (index, result), ... ◀─────┘   in the order of completion

If the result of a function depends only on the job, the place of execution and the number of
processes do not change the results. If a worker dies, another worker repeats the jobs of its task.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sized
from typing import TypeVar

from frictool.workers.process_pool import ProcessPool
from frictool.workers.task_batch import split_tasks, task_results

Job = TypeVar("Job")
Result = TypeVar("Result")


def share(
    function: Callable[[Job], Result],
    jobs: Iterable[Job],
    *,
    cores: int | None = None,
    cluster: str | None = None,
    batch: int = 1,
    instead: Callable[[Job, str], Result] | None = None,
) -> Iterator[tuple[int, Result]]:
    """Yield the index and result of each job, in the order of completion.

    If the caller closes the iterator early, the running jobs are ended.

    Parameters
    ----------
    function : Callable
        Function that takes a job and returns its result. It must be defined in a module; function,
        jobs and results must be picklable.
    jobs : Iterable
        Jobs; a job is taken from the iterable only when a worker is ready for it.
    cores : int, optional
        Number of processes; 1: this process; None: one process for each core of this machine.
    cluster : str, optional
        Address of a Dask scheduler; its workers are used instead of processes.
    batch : int, optional
        Number of jobs that are sent together as a task; a task should take some tenths of a second.
    instead : Callable, optional
        Function of a job and a reason; it returns a substitute for the result of a job during which
        several processes died.

    Yields
    ------
    tuple[int, Result]
        Index and result of a job.

    Raises
    ------
    Exception
        Any exception that `function` raises.
    WorkerLost
        If several workers die during the same job and `instead` is None, or if a process does not
        start.
    ClusterError
        If the cluster cannot be used.
    ValueError
        If `cores` or `batch` is below 1.
    """
    if (cores is not None and cores < 1) or batch < 1:
        raise ValueError(f"cores, batch: found {cores}, {batch}; allowed: each at least 1")
    if cluster is not None:
        from frictool.workers.dask_cluster import run_on_cluster

        for task, results in run_on_cluster(function, split_tasks(jobs, batch), cluster, instead):
            yield from task_results(task, results)
        return
    workers = cores or available_cores()
    if isinstance(jobs, Sized):
        workers = min(workers, -(-len(jobs) // batch))
    if workers <= 1:
        yield from ((index, function(job)) for index, job in enumerate(jobs))
        return
    pool = ProcessPool(function, workers, instead)
    source = split_tasks(jobs, batch)
    try:
        pool.feed(source)
        while pool.busy:
            answers = pool.heard()
            pool.feed(source)  # feed first, so that no process is idle while the results are used
            for task, results in answers:
                yield from task_results(task, results)
    finally:
        pool.close()


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
