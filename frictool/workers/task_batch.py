"""Batches of jobs that a worker runs one after another.

    (index, job), (index, job), ... ──run_task──▶ result | JobFailure, ...

The error of a failed job is returned as a value, so that the results of the other jobs are kept.
"""

from __future__ import annotations

import pickle
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

Task = Sequence[tuple[int, Any]]  # jobs that are sent together, each with its index


@dataclass(frozen=True)
class JobFailure:
    """Error of a failed job, in place of the job's result."""

    error: Exception


def split_tasks(jobs: Iterable[Any], batch: int) -> Iterator[Task]:
    """Yield tasks of `batch` jobs each; jobs are taken only when a task is requested."""
    numbered = enumerate(jobs)
    while task := tuple(islice(numbered, batch)):
        yield task


def run_task(function: Callable[[Any], Any], task: Task) -> list[Any]:
    """Return the results of a task's jobs in order; the result of a failed job is a JobFailure."""
    return [_one(function, job) for _, job in task]


def task_results(task: Task, results: Sequence[Any]) -> Iterator[tuple[int, Any]]:
    """Yield (index, result) of each job in order; raise the error of a failed job."""
    for (index, _), result in zip(task, results, strict=True):
        if isinstance(result, JobFailure):
            raise result.error
        yield index, result


def _one(function: Callable[[Any], Any], job: Any) -> Any:
    try:
        return function(job)
    except Exception as error:
        return JobFailure(picklable_error(error))


def picklable_error(error: Exception) -> Exception:
    """Return the error with its traceback added as a note.

    If the error cannot be pickled, a RuntimeError with the same text is returned.
    """
    error.add_note("".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
