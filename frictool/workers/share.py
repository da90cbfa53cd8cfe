"""Jobs shared among processes, or the workers of a cluster: each job done once, whoever does it,
and whoever dies of it.

    jobs ──batch.py──▶ tasks ──┬── in this process
                               ├── process_pool.py   a process a core
                               └── dask_cluster.py     the workers of a Dask scheduler
         (index, result), ... ◀┘   as they are done

A function of a job alone gives the same results in each of the three, so that the number of
processes changes nothing.
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
    """Index and result of each job, in the order in which they are done.

    function: what is done with a job; named in a module, or an instance of a class that is. It is
    sent by pickle, as jobs and results are. jobs: asked for as they are needed. cores: how many
    processes, all of this machine's where None; one is this process itself. cluster: the address of
    a Dask scheduler, whose workers do the work in their place. batch: how many jobs travel
    together; to be chosen so that they take some tenths of a second. instead: called with a job
    that several processes in turn did not outlive, and with what ended them; gives its result in
    its place.

    Raises what `function` raises, WorkerLost where a job ends each process that is at it,
    ClusterError where the cluster cannot be used. Whoever leaves early, by an exception or by
    closing the iterator, ends what is under way.
    """
    if (cores is not None and cores < 1) or batch < 1:
        raise ValueError(f"cores and batch are at least 1; found {cores} and {batch}")
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
    pool, source = ProcessPool(function, workers, instead), split_tasks(jobs, batch)
    try:
        pool.feed(source)
        while pool.busy:
            answers = pool.heard()
            pool.feed(source)  # first, so that nobody waits for what is done with the results
            for task, results in answers:
                yield from task_results(task, results)
    finally:
        pool.close()


def available_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
