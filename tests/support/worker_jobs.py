"""Functions to share: some end the process that runs them, some fail. Nothing is imported that
takes a process long to start."""

from __future__ import annotations

import itertools
import os
import random
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from frictool.errors import LogError
from frictool.runtime import notifications

_kept: list[bytes] = []


def series(seed: int) -> list[float]:
    """Some arithmetic whose last bits tell the order of its sums."""
    drawn = random.Random(seed)
    return list(itertools.accumulate(drawn.gauss(0.0, 1.0) for _ in range(200)))


def slow_series(seed: int) -> list[float]:
    """The same, long enough to be ended in its middle."""
    time.sleep(0.02)
    return series(seed)


@dataclass(frozen=True)
class Deadly:
    """Ends its process where the job is one of `fatal`, the first `times` times: files in `folder`
    count them."""

    folder: Path
    fatal: tuple[int, ...]
    times: int

    def __call__(self, seed: int) -> list[float]:
        deaths = len(list(self.folder.glob(f"{seed}.*")))
        if seed in self.fatal and deaths < self.times:
            (self.folder / f"{seed}.{deaths}").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return series(seed)


def negative(number: int) -> int:
    """Fails at 7 as a reader of logs does."""
    if number == 7:
        raise LogError("run.csv", "has no samples", line=3)
    return -number


def greedy(number: int) -> int:
    """Keeps 200 MB for good, and is long enough for its worker to see it."""
    _kept.append(b"1" * 200_000_000)
    time.sleep(0.5)
    return number


def compiles(number: int) -> int:
    """Waits for the compiler, as the first use of a kernel does."""
    notifications.compiling()
    return number


def untravelled(number: int) -> Any:
    """A result that pickle refuses."""
    return lambda: number


def content(paths: tuple[Path, ...], job: str) -> tuple[str, list[tuple[str, bytes]]]:
    """Return the contents of the files that a job reads, by name."""
    return job, [(path.name, path.read_bytes()) for path in paths]


def instead(job: str, reason: str) -> tuple[str, list[tuple[str, bytes]]]:
    """In place of it."""
    return job, [(reason, b"")]
