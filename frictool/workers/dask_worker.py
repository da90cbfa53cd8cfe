"""Functions that run in a worker of a cluster, one task at a time even with several threads."""

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
from frictool.workers.installation_agreement import Installation, installation
from frictool.workers.task_batch import picklable_error, run_task

# threads of a worker take turns: kernels may run in parallel, but not all the code around them
_TURN = threading.Lock()


@dataclass(frozen=True)
class DifferentInstallation:
    """Value that a worker returns instead of results if its installation differs from the sender's.

    there: installation of the worker.
    """

    there: Installation
    host: str


@dataclass(frozen=True)
class TransferFailure:
    """Value that a worker returns if a function, a job or a result cannot be pickled."""

    error: Exception


def worker_installation() -> Installation:
    """Return the installation of the worker."""
    return installation()


def run(topic: str, expected: Installation, function: bytes, task: bytes) -> bytes:
    """Run a task on a worker and return the pickled results.

    topic: Dask topic on which the worker reports that it compiles kernels.
    expected: installation that the worker must have.
    function: pickled function that computes a job.
    task: pickled task (batch of jobs).
    """
    with _TURN:
        return pickle.dumps(_run(topic, expected, function, task))


def _run(topic: str, expected: Installation, function: bytes, task: bytes) -> Any:
    limit_blas_threads()
    if installation().versions != expected.versions:
        return DifferentInstallation(installation(), socket.gethostname())
    multiprocessing.current_process().daemon = False  # readers of logs start processes
    try:
        with notifications.receiving(compiling=functools.partial(_tell_of_compiling, topic)):
            results = run_task(_loaded(function), pickle.loads(task))
        pickle.dumps(results)
    except Exception as error:
        return TransferFailure(picklable_error(error))
    return results


@functools.lru_cache(maxsize=4)
def _loaded(function: bytes) -> Callable[[Any], Any]:
    loaded: Callable[[Any], Any] = pickle.loads(function)
    return loaded


def _tell_of_compiling(topic: str) -> None:
    from distributed import get_worker

    with contextlib.suppress(ValueError):  # get_worker fails outside of a task's thread
        get_worker().log_event(topic, socket.gethostname())
