"""Execution of tasks on a Dask cluster whose workers may end, join late, or be on other machines.

    here                          scheduler             worker, one of many
    task ──submit──▶ future ──▶  queue  ──────────────▶ dask_worker.py
         ◀── results, or "its workers died" ◀─────────┘

A task is a batch of jobs. If a worker dies, the scheduler gives the worker's task to another
worker. After several workers have died during a task (setting `allowed-failures`), the scheduler
gives the task up, although another task may have caused the deaths. The jobs of tasks that were
given up are repeated at the end, one at a time. A job is lost only if workers die again during this
job.
"""

from __future__ import annotations

import contextlib
import importlib
import pickle
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextvars import copy_context
from typing import Any

from frictool.errors import ClusterError, WorkerLost
from frictool.runtime import notifications
from frictool.workers import dask_worker
from frictool.workers.dask_connection import connect
from frictool.workers.installation_agreement import Installation, differences, installation
from frictool.workers.task_batch import Task

FIRST_S = 10.0  # s, longest wait for the first worker
# s, after which a message says that a worker has not reported its installation
SLOW_S = 10.0
# s without any worker, after which the run fails; until then, a supervisor may restart a worker
NO_WORKER_S = 60.0
LOOK_S, POLL_S = 2.0, 0.005  # s, intervals of the checks of workers, and of results
LIMIT = "`dask worker --memory-limit`"
MODULE = "'frictool"  # text in the message of a failed import of frictool or of its modules
# s without a result, after which workers are checked for a pause due to low memory
LONG_S = 20.0
# the run fails if no task has returned results and HOPELESS times the largest number of tasks in
# progress were given up
HOPELESS = 2
ALONE = 3  # the run fails if this many jobs, each repeated alone, were given up and none is done
AHEAD = 3  # tasks in progress per worker, so that none is idle
Instead = Callable[[Any, str], Any] | None


def run_on_cluster(
    function: Callable[[Any], Any], source: Iterator[Task], address: str, instead: Instead
) -> Iterator[tuple[Task, list[Any]]]:
    """Yield each task with the results of its jobs, in the order of completion.

    instead: as in `share` (job_sharing.py). Raises ClusterError if the scheduler cannot be reached
    or has no workers, or if the installation of a worker differs from this installation. Raises
    WorkerLost if all workers that receive the same job die, and `instead` is None.
    """
    with connect(address) as client:
        _check(client, address)
        run = ClusterRun(client, address, pickle.dumps(function), instead)
        try:
            yield from run.answers(source)
        finally:
            run.close()


def _check(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=FIRST_S)
    except TimeoutError:
        raise ClusterError(
            f"{address}: the scheduler has no worker; "
            f"start some with `dask worker {address} --nthreads 1`"
        ) from None
    here = installation()
    answers = _answers(client, address)
    unlike = {name: _unlike(here, there) for name, there in answers.items()}
    unlike = {name: text for name, text in unlike.items() if text}
    if unlike:
        raise ClusterError(
            f"{address}: workers differ from this machine: "
            f"{'; '.join(f'{name}: {text}' for name, text in unlike.items())}"
        )
    others = {there.processor for there in answers.values()} - {here.processor}
    if others:
        notifications.remark(
            f"workers have another processor ({', '.join(sorted(others))}, here "
            f"{here.processor}): the last digits of results may differ"
        )
    if any(threads > 1 for threads in client.nthreads().values()):
        notifications.remark(
            "workers have several threads, but use only one each; start workers with --nthreads 1 "
            "--nworkers N"
        )


def _answers(client: Any, address: str) -> Any:
    text = (
        f"{address}: a worker does not answer; frictool waits until the scheduler removes this "
        "worker (worker-ttl of the scheduler, by default 5 min)"
    )
    slow = threading.Timer(SLOW_S, copy_context().run, (notifications.remark, text))
    slow.daemon = True
    slow.start()
    try:
        answers = client.run(dask_worker.worker_installation, on_error="return")
    except OSError:
        raise ClusterError(f"{address}: the scheduler no longer answers; start it again") from None
    finally:
        slow.cancel()
    # a worker that has ended returns an OSError
    return {name: there for name, there in answers.items() if not isinstance(there, OSError)}


def _unlike(here: Installation, there: Any) -> str:
    if isinstance(there, Exception):
        # for some errors, Dask transfers only the text
        missing = isinstance(there, ImportError | AttributeError) or MODULE in str(there)
        return "no frictool, or another version" if missing else f"{type(there).__name__}: {there}"
    return differences(here, there)


class ClusterRun:
    """Execution of tasks on a cluster."""

    def __init__(self, client: Any, address: str, function: bytes, instead: Instead) -> None:
        self._client = client
        self._address = address
        self._function = function
        self._instead = instead
        self._distributed = importlib.import_module("distributed")
        self._completed = self._distributed.as_completed([], loop=client.loop)
        self._under_way: dict[str, tuple[Any, Task]] = {}  # key of a future -> future and its task
        self._suspects: deque[Task] = deque()
        self._workers = 1
        self._looked = 0.0
        self._last_seen = time.monotonic()
        self._answered = 0
        self._given_up = 0
        self._last_answer = time.monotonic()
        self._topic = f"frictool-{client.id}"
        self._told = set[str]()
        self._context = copy_context()  # of the caller; Dask calls back from another thread
        client.subscribe_topic(self._topic, self._hear)

    def answers(self, source: Iterator[Task]) -> Iterator[tuple[Task, list[Any]]]:
        """Yield each task with its results; repeat the jobs of given-up tasks at the end."""
        while True:
            self._look()
            self._submit(source)
            if not self._under_way:
                break
            for future in self._ready():
                yield from self._answer(future)
        self._given_up = 0
        while self._suspects:
            task = self._suspects.popleft()
            self._submit(iter((task,)))
            while self._under_way:
                for future in self._ready():
                    yield self._answer_of_suspect(future)
                self._look()

    def close(self) -> None:
        """Cancel the tasks that have not begun; the workers complete the running tasks."""
        with contextlib.suppress(Exception):  # a lost scheduler has no tasks
            self._client.unsubscribe_topic(self._topic)
            self._client.cancel([future for future, _ in self._under_way.values()], force=True)
        self._under_way.clear()

    def _submit(self, source: Iterator[Task]) -> None:
        while (
            len(self._under_way) < AHEAD * self._workers
            and (task := next(source, None)) is not None
        ):
            arguments = self._topic, installation(), self._function, pickle.dumps(task)
            try:
                future = self._client.submit(dask_worker.run, *arguments, pure=False)
            except Exception as error:
                raise self._gone() from error
            self._under_way[future.key] = future, task
            self._completed.add(future)

    def _look(self) -> None:
        now = time.monotonic()
        if now - self._looked < LOOK_S:
            return
        if self._client.status != "running":  # otherwise Dask would wait for the scheduler's return
            raise self._gone()
        try:
            workers = len(self._client.nthreads())
        except Exception as error:  # any exception, because the connection may fail at either end
            raise self._gone() from error
        self._looked = now
        self._workers = max(1, workers)
        paused = workers > 0 and now - self._last_answer > LONG_S and self._paused()
        if workers and not paused:
            self._last_seen = now
        elif now - self._last_seen > NO_WORKER_S:
            state = f"whose memory allows another task ({LIMIT})" if paused else "at all"
            raise ClusterError(
                f"{self._address}: the scheduler has had no worker {state} for {NO_WORKER_S:g} s; "
                "finished jobs are kept"
            )

    def _paused(self) -> bool:
        try:
            workers = self._client.scheduler_info(n_workers=-1)["workers"].values()
        except Exception as error:
            raise self._gone() from error
        return all(
            one["status"] == "paused" and not one["metrics"].get("task_counts", {}).get("executing")
            for one in workers
        )

    def _ready(self) -> list[Any]:
        until = time.monotonic() + LOOK_S
        while not self._completed.has_ready() and time.monotonic() < until:
            time.sleep(POLL_S)
        return list(self._completed.next_batch(block=False))

    def _answer(self, future: Any) -> Iterator[tuple[Task, list[Any]]]:
        results = self._results(future)
        task = self._under_way.pop(future.key)[1]
        if results is None:
            self._give_up(HOPELESS * AHEAD * self._workers)
            if not self._suspects:
                notifications.remark(
                    f"{self._address}: workers ended during their jobs; these jobs are repeated at "
                    "the end"
                )
            self._suspects.extend((one,) for one in task)
        else:
            yield task, results

    def _answer_of_suspect(self, future: Any) -> tuple[Task, list[Any]]:
        results = self._results(future)
        task = self._under_way.pop(future.key)[1]
        if results is not None:
            return task, results
        self._give_up(ALONE)
        ((index, job),) = task
        reason = "every worker that received this job ended, perhaps because memory is low"
        if self._instead is None:
            raise WorkerLost(index, f"job {index}: {reason}")
        return task, [self._instead(job, reason)]

    def _give_up(self, most: int) -> None:
        self._given_up += 1
        if self._given_up >= most and not self._answered:
            raise ClusterError(
                f"{self._address}: every worker that received a task died; check the memory of the "
                f"workers ({LIMIT})"
            )

    def _results(self, future: Any) -> list[Any] | None:
        packed = self._fetched(future)
        if packed is None:
            return None
        results = pickle.loads(packed)
        self._answered = self._answered + 1
        self._last_answer = time.monotonic()
        if isinstance(results, dask_worker.DifferentInstallation):
            raise ClusterError(
                f"{self._address}: worker on {results.host} differs from this machine: "
                f"{differences(installation(), results.there)}"
            )
        if isinstance(results, dask_worker.TransferFailure):
            raise results.error
        return list(results)

    def _fetched(self, future: Any) -> bytes | None:
        while True:
            self._look()
            try:
                return bytes(future.result(timeout=LOOK_S))
            except self._distributed.KilledWorker:
                return None
            except CancelledError:
                raise self._gone() from None
            except Exception as error:  # from the task, or from a broken connection
                if future.status == "error":
                    if MODULE in str(error):
                        raise ClusterError(
                            f"{self._address}: a worker has no frictool, or another version; "
                            "install this version on every worker"
                        ) from None
                    raise ClusterError(
                        f"{self._address}: a worker cannot run its task: "
                        f"{type(error).__name__}: {error}"
                    ) from None
                time.sleep(POLL_S)

    def _gone(self) -> ClusterError:
        return ClusterError(
            f"{self._address}: the connection to the scheduler is lost; finished jobs are kept"
        )

    def _hear(self, event: tuple[float, str]) -> None:
        host = event[1]
        if host not in self._told:
            self._told.add(host)
            self._context.run(
                notifications.remark,
                f"{host}: compiling, once per installation (up to a minute) ...",
            )
