"""A pool of processes that may be ended at any time, as where memory is short: what one was at is
done again by another.

    here                                  process, one a core
    task ──pipe──▶ jobs in turn
         ◀──pipe── results, or that it waits for the compiler; the end of the pipe: the process is
         no more

Each process holds one task and has a pipe of its own, so that it is known what is lost with it, and
nothing else is: a pool of `concurrent.futures` gives up every task as soon as one process dies.
Processes end with the pipe, so that none outlives this one.
"""

from __future__ import annotations

import contextlib
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

ATTEMPTS = 3  # at a job, before it is taken for what ends the processes
PATIENCE_S = 2.0  # for a process to end by itself
READY, COMPILING, RESULTS, FAILED = "ready", "compiling", "results", "failed"
Answer = tuple[Task, list[Any]]
FallbackResult = Callable[[Any, str], Any] | None


@dataclass
class PendingTask:
    """A task, and how many processes have died at it where it is a single job."""

    task: Task
    deaths: int = 0


def start_method() -> str:
    """Return the start method of worker processes. A fork would copy locked locks of threads;
    Windows has no fork server."""
    return "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"


class WorkerProcess:
    """One process, and what it has been given."""

    def __init__(self, function: bytes) -> None:
        context: Any = get_context(start_method())
        self.connection, theirs = context.Pipe()
        # not a daemon: readers of logs start processes of their own
        self.process = context.Process(target=_serve, args=(theirs, function))
        self.process.start()
        theirs.close()
        self.held: PendingTask | None = None
        self.ready = False

    def give(self, held: PendingTask) -> bool:
        """Whether the process was there to take it."""
        try:
            self.connection.send(held.task)
        except OSError:
            return False
        self.held = held
        return True

    def hear(self) -> list[Any] | None:
        """The results, or None where it told something else. Raises EOFError where it is no more,
        and what it failed of."""
        try:
            kind, told = self.connection.recv()
        except (OSError, pickle.UnpicklingError):  # ended while it sent
            raise EOFError from None
        if kind == FAILED:
            raise told
        if kind == COMPILING:
            notifications.compiling()
        self.ready = self.ready or kind == READY
        return told if kind == RESULTS else None

    def cause(self) -> str:
        """What it was ended by."""
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
        """Whether it waits, works, or is no more."""
        self.connection.close()
        self.process.join(PATIENCE_S)
        if self.process.is_alive():
            self.process.kill()
        self.process.join()
        self.process.close()


class ProcessPool:
    """As many processes as asked for, each replaced where it was ended. instead: gives the result
    of a job that ends them all."""

    def __init__(
        self, function: Callable[[Any], Any], size: int, instead: FallbackResult = None
    ) -> None:
        self._function, self._instead = pickle.dumps(function), instead
        self._again: deque[PendingTask] = deque()
        self._members: list[WorkerProcess] = []
        self.close = finalize(
            self, _end, self._members
        )  # at the interpreter's exit too, which waits for processes
        for _ in range(size):
            self._members.append(WorkerProcess(self._function))

    @property
    def busy(self) -> bool:
        """Whether an answer is to come."""
        return any(one.held is not None for one in self._members)

    def feed(self, source: Iterator[Task]) -> None:
        """Gives each idle process a task: what was lost, then what is next."""
        for place in range(len(self._members)):
            while self._members[place].held is None:
                held = self._next(source)
                if held is None:
                    return
                if not self._members[place].give(held):
                    self._again.appendleft(held)
                    self._replace(place)

    def _next(self, source: Iterator[Task]) -> PendingTask | None:
        if self._again:
            return self._again.popleft()
        task = next(source, None)
        return None if task is None else PendingTask(task)

    def heard(self) -> list[Answer]:
        """Waits for one process at least: what they answer. Raises WorkerLost where a job ends
        every process that is at it."""
        told = connection.wait([one.connection for one in self._members])
        answers: list[Answer] = []
        for place, member in enumerate(self._members):
            if member.connection not in told:
                continue
            try:
                results = member.hear()
            except EOFError:
                answers += self._lost(place)
                continue
            if results is not None and member.held is not None:
                answers.append((member.held.task, results))
                member.held = None
        return answers

    def _lost(self, place: int) -> list[Answer]:
        """What a dead process held is done again, each job by itself so that only the guilty one is
        given up."""
        dead = self._members[place]
        cause, held = dead.cause(), dead.held
        if not dead.ready:
            raise WorkerLost(
                None, f"a process to share the work with does not start ({cause}); try one core"
            )
        self._replace(place)
        if held is None:
            return []
        deaths = held.deaths + (len(held.task) == 1)  # of several, nobody knows which it was
        if deaths >= ATTEMPTS:
            return [
                self._given_up(
                    held.task,
                    f"each of {deaths} processes that were at it was ended ({cause}); is memory short?",
                )
            ]
        notifications.remark(f"a process was ended ({cause}); what it was at is done again")
        self._again.extend(PendingTask((one,), deaths) for one in held.task)
        return []

    def _given_up(self, task: Task, reason: str) -> Answer:
        ((index, job),) = task
        if self._instead is None:
            raise WorkerLost(index, f"job {index}: {reason}")
        return task, [self._instead(job, reason)]

    def _replace(self, place: int) -> None:
        self._members[place].end()
        self._members[place] = WorkerProcess(self._function)


def _end(members: list[WorkerProcess]) -> None:
    """Those that wait end with their pipe; those that work are told to."""
    for one in members:
        if one.held is not None or not one.ready:
            one.process.terminate()
        one.connection.close()
    for one in members:
        one.end()
    members.clear()


def _serve(theirs: Connection, function: bytes) -> None:
    """The process: does tasks until the pipe ends. Ctrl-C is for the one that shares the work,
    which ends this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.update(
        OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1"
    )  # before numpy: sums in another order give other bytes
    notifications.compiling = lambda: theirs.send((COMPILING, None))
    with contextlib.suppress(EOFError, OSError):  # the other end is no more
        try:
            work = pickle.loads(function)
            theirs.send((READY, None))
            while True:
                theirs.send((RESULTS, run_task(work, theirs.recv())))
        except (EOFError, OSError):
            raise
        except Exception as error:  # what cannot travel: a function, a job or a result
            theirs.send((FAILED, picklable_error(error)))
