"""Pool of processes that may end at any time, for example because memory runs out.

    this process                          worker process, one per core
    task ──pipe──▶ jobs, one after another
         ◀──pipe── results, or "compiling"; the pipe closes if the process ends

A task is a batch of jobs. If a process ends, another process repeats the jobs of its task. Each
process has one task and one pipe, so that the results of only one task are lost. A process ends
when its pipe closes, so that no process outlives its parent.
"""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import pickle
import signal
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from typing import Any
from weakref import finalize

from frictool.errors import WorkerLost
from frictool.runtime import notifications
from frictool.workers.task_batch import Task, picklable_error, run_task

ATTEMPTS = 3  # a job is given up after this many processes have ended while they ran the job alone
PATIENCE_S = 2.0  # s, longest wait for a process to end by itself
READY, COMPILING, RESULTS, FAILED = "ready", "compiling", "results", "failed"
Answer = tuple[Task, list[Any]]
FallbackResult = Callable[[Any, str], Any] | None


@dataclass
class PendingTask:
    """Task that waits or runs.

    `deaths`: number of processes that ended unexpectedly while they ran the task.
    """

    task: Task
    deaths: int = 0


def start_method() -> str:
    """Return the start method of worker processes: a fork server, or "spawn" on Windows.

    The method "fork" is not used, because it would copy locks of other threads.
    """
    return "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"


class WorkerProcess:
    """Worker process with its current task."""

    def __init__(self, function: bytes) -> None:
        context: Any = get_context(start_method())
        self.connection, theirs = context.Pipe()
        # not a daemon: readers of logs start processes
        self.process = context.Process(target=_serve, args=(theirs, function))
        self.process.start()
        theirs.close()
        self.pending: PendingTask | None = None
        self.ready = False

    def give(self, pending: PendingTask) -> bool:
        """Send a task; return False if the process has ended."""
        try:
            self.connection.send(pending.task)
        except OSError:
            return False
        self.pending = pending
        return True

    def hear(self) -> list[Any] | None:
        """Receive a message; return the results of the task, or None if the message has no results.

        Raises EOFError if the process has ended. Raises the error that the process has sent.
        """
        try:
            kind, content = self.connection.recv()
        except (OSError, pickle.UnpicklingError):  # the process ended while it sent
            raise EOFError from None
        if kind == FAILED:
            raise content
        if kind == COMPILING:
            notifications.compiling()
        self.ready = self.ready or kind == READY
        return content if kind == RESULTS else None

    def cause(self) -> str:
        """Return the exit code or signal that ended the process."""
        self.process.join(PATIENCE_S)
        code = self.process.exitcode
        if code is None or code >= 0:
            return f"exit code {code}"
        return (
            signal.Signals(-code).name
            if -code in {one.value for one in signal.Signals}
            else f"signal {-code}"
        )

    def end(self) -> None:
        """End the process immediately."""
        self.connection.close()
        self.process.join(PATIENCE_S)
        if self.process.is_alive():
            self.process.kill()
        self.process.join()
        self.process.close()


class ProcessPool:
    """Pool of `size` processes; a process that ends is replaced.

    instead: function(job, reason) that returns a substitute for the result of a job during which
    ATTEMPTS processes have died.
    """

    def __init__(
        self, function: Callable[[Any], Any], size: int, instead: FallbackResult = None
    ) -> None:
        self._function = pickle.dumps(function)
        self._instead = instead
        self._again: deque[PendingTask] = deque()
        self._members: list[WorkerProcess] = []
        # called also at the interpreter's exit, which waits for processes
        self.close = finalize(self, _end, self._members)
        for _ in range(size):
            self._members.append(WorkerProcess(self._function))

    @property
    def busy(self) -> bool:
        """Return True if a process has a task."""
        return any(one.pending is not None for one in self._members)

    def feed(self, source: Iterator[Task]) -> None:
        """Give each idle process a task; tasks that must be repeated come before new tasks."""
        for index in range(len(self._members)):
            while self._members[index].pending is None:
                pending = self._next(source)
                if pending is None:
                    return
                if not self._members[index].give(pending):
                    self._again.appendleft(pending)
                    self._replace(index)

    def _next(self, source: Iterator[Task]) -> PendingTask | None:
        if self._again:
            return self._again.popleft()
        task = next(source, None)
        return None if task is None else PendingTask(task)

    def heard(self) -> list[Answer]:
        """Wait for a message from at least one process; return completed tasks with their results.

        Raises WorkerLost if ATTEMPTS processes have died during a job, and `instead` is None.
        """
        ready = connection.wait([one.connection for one in self._members])
        answers: list[Answer] = []
        for index, member in enumerate(self._members):
            if member.connection not in ready:
                continue
            try:
                results = member.hear()
            except EOFError:
                answers += self._lost(index)
                continue
            if results is not None and member.pending is not None:
                answers.append((member.pending.task, results))
                member.pending = None
        return answers

    def _lost(self, index: int) -> list[Answer]:
        """Replace a process that has ended, and make a separate task of each of its jobs.

        Only a job that ran alone is given up, because only then must this job have ended the
        process.
        """
        dead = self._members[index]
        cause = dead.cause()
        pending = dead.pending
        if not dead.ready:
            raise WorkerLost(None, f"a worker process does not start ({cause}); try one core")
        self._replace(index)
        if pending is None:
            return []
        deaths = pending.deaths + (
            len(pending.task) == 1
        )  # with several jobs, it is unknown which job caused the end
        if deaths >= ATTEMPTS:
            return [
                self._given_up(
                    pending.task,
                    f"each of {deaths} worker processes that started this job ended ({cause}), "
                    "perhaps because memory is low",
                )
            ]
        notifications.remark(f"a worker process ended ({cause}); its jobs are repeated")
        self._again.extend(PendingTask((one,), deaths) for one in pending.task)
        return []

    def _given_up(self, task: Task, reason: str) -> Answer:
        ((index, job),) = task
        if self._instead is None:
            raise WorkerLost(index, f"job {index}: {reason}")
        return task, [self._instead(job, reason)]

    def _replace(self, index: int) -> None:
        self._members[index].end()
        self._members[index] = WorkerProcess(self._function)


def _end(members: list[WorkerProcess]) -> None:
    for one in members:
        if one.pending is not None or not one.ready:
            one.process.terminate()
        one.connection.close()
    for one in members:
        one.end()
    members.clear()


def _serve(theirs: Connection, function: bytes) -> None:
    """Run tasks until the pipe is closed; ignore Ctrl-C, which the parent process handles."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # set before numpy is loaded, because another order of sums changes the last digits
    os.environ.update(OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")
    compiling = functools.partial(theirs.send, (COMPILING, None))
    with (
        contextlib.suppress(EOFError, OSError),  # the parent process has ended
        notifications.receiving(compiling=compiling),
    ):
        try:
            work = pickle.loads(function)
            theirs.send((READY, None))
            while True:
                theirs.send((RESULTS, run_task(work, theirs.recv())))
        except (EOFError, OSError):
            raise
        except Exception as error:  # a function, a job or a result cannot be pickled
            theirs.send((FAILED, picklable_error(error)))
