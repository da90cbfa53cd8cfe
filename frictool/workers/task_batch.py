"""What runs where the work is done: a few jobs in turn, and each error as a value, so that it
travels and the others' results stay.

(index, job), (index, job), ... ──done──▶ result | Raised, ...
"""

from __future__ import annotations

import pickle
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

Task = Sequence[tuple[int, Any]]  # jobs that travel together, each with its index


@dataclass(frozen=True)
class JobFailure:
    """In place of the result of a job that failed."""

    error: Exception


def split_tasks(jobs: Iterable[Any], batch: int) -> Iterator[Task]:
    """`batch` jobs a task, in order; no more of them are asked for than are taken."""
    numbered = enumerate(jobs)
    while task := tuple(islice(numbered, batch)):
        yield task


def run_task(function: Callable[[Any], Any], task: Task) -> list[Any]:
    """The results, in the order of the task."""
    return [_one(function, job) for _, job in task]


def task_results(task: Task, results: Sequence[Any]) -> Iterator[tuple[int, Any]]:
    """Each index with its result. Raises what a job has raised, after the results before it."""
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
    """The error, with a note of where it was raised, which a traceback shows; as text where it
    cannot travel as it is."""
    error.add_note("".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
