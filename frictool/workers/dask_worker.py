"""What runs in a worker of a cluster: one task at a time, whatever threads the worker has."""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import pickle
import socket
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from frictool.runtime import notifications
from frictool.workers.blas_threads import limit_blas_threads
from frictool.workers.installation import Installation, installation
from frictool.workers.task_batch import picklable_error, run_task

# kernels run beside each other, but not all that is around them: a worker that is given threads
# takes turns
_TURN = threading.Lock()


@dataclass(frozen=True)
class DifferentInstallation:
    """In place of the results of a worker whose installation is another."""

    there: Installation
    host: str


@dataclass(frozen=True)
class TransferFailure:
    """In place of the results where a function, a job or a result cannot travel."""

    error: Exception


def worker_installation() -> Installation:
    """That of the worker."""
    return installation()


def run(topic: str, expected: Installation, function: bytes, task: bytes) -> bytes:
    """The results of a task, by pickle. topic: where the one that shares the work hears of waits
    for the compiler."""
    with _TURN:
        return pickle.dumps(_run(topic, expected, function, task))


def _run(topic: str, expected: Installation, function: bytes, task: bytes) -> Any:
    limit_blas_threads()
    if installation().versions != expected.versions:
        return DifferentInstallation(installation(), socket.gethostname())
    multiprocessing.current_process().daemon = False  # readers of logs start processes of their own
    notifications.compiling = functools.partial(_tell_of_compiling, topic)
    try:
        results = run_task(_loaded(function), pickle.loads(task))
        pickle.dumps(results)
    except Exception as error:
        return TransferFailure(picklable_error(error))
    return results


@functools.lru_cache(maxsize=4)
def _loaded(function: bytes) -> Callable[[Any], Any]:
    """The same function comes with every task, so that a worker that joins later has it."""
    loaded: Callable[[Any], Any] = pickle.loads(function)
    return loaded


def _tell_of_compiling(topic: str) -> None:
    from distributed import get_worker

    with contextlib.suppress(ValueError):  # a thread that is no task's
        get_worker().log_event(topic, socket.gethostname())
