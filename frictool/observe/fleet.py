"""A fleet's logs, a row each: found in their folders, observed in processes side by side, compared with the earliest of each unit.

    logs ──one_log.py, a process a core──▶ Found, Found, ... ──commissioning.py, alarm.py──▶ Row, Row, ...

The rows are in the order of unit, date and file, whatever process ends first.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

from frictool.documents.model import Model
from frictool.errors import FrictoolError, LogError
from frictool.logs.recordings.parts import METADATA
from frictool.observe.one_log import THESE, Estimators, OneLog, Settings
from frictool.observe.origin import Name, Origin, origin_by_name
from frictool.observe.outcome import Outcome

Job = tuple["Member", Model, Settings, Estimators]
# what in a folder is taken for a log; a file that is named by itself is read whatever it is called
SUFFIXES = (".mcap", ".bag", ".db3", ".csv", ".tsv", ".txt", ".mat", ".mf4", ".mdf", ".dat", ".parquet", ".pq", ".npz")
WORTH_SHARING = 50_000_000  # bytes of all logs, below which the start of further processes takes longer than they save


@dataclass(frozen=True)
class Member:
    """A log of the fleet, and what it is called: below the folder that was given, or as it was given itself."""

    path: Path
    name: Name


@dataclass(frozen=True)
class Found:
    """What a log has told, or why it could not. lost: whether it could not be read, or not whole."""

    member: Member
    origin: Origin
    outcome: Outcome | None
    reason: str = ""

    @property
    def lost(self) -> bool:
        return self.outcome is None or bool(self.outcome.losses)


def is_fleet(logs: Sequence[Path]) -> bool:
    """Whether a table is asked for, not the estimates of one log."""
    return len(logs) > 1 or (logs[0].is_dir() and not _is_bag(logs[0]))


def _is_bag(folder: Path) -> bool:
    """Whether a folder is one recording, a ROS 2 bag."""
    return (folder / METADATA).is_file()


def members(logs: Iterable[Path], without: Sequence[Path] = ()) -> list[Member]:
    """The logs that are named, and those in the folders that are, hidden ones left out; `without`: outputs, which are none.

    Raises LogError where a folder has none.
    """
    left_out = {path.resolve() for path in without}
    found: dict[Path, Member] = {}
    for log in logs:
        for member in _below(log) if is_fleet([log]) else [Member(log, Name(log.as_posix()))]:
            if member.path.resolve() not in left_out:
                found.setdefault(member.path.resolve(), member)
    return list(found.values())


def _below(folder: Path) -> list[Member]:
    below = [(path, path.relative_to(folder)) for path in _logs(folder)]
    logs = [Member(path, Name(name.as_posix(), name.parent.name)) for path, name in below]
    if not logs:
        raise LogError(folder, f"holds no log; what counts as one ends in {', '.join(SUFFIXES)}, or is a ROS 2 bag")
    return logs


def _logs(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        if path.is_dir() and not _is_bag(path):
            yield from _logs(path)
        elif path.is_dir() or path.suffix.lower() in SUFFIXES:
            yield path


def observed(
    fleet: Sequence[Member],
    model: Model,
    settings: Settings,
    estimators: Estimators = THESE,
    cores: int | None = None,
    tick: Callable[[float], None] = lambda part: None,
) -> list[Found]:
    """What each log tells, in the order given. tick: is told the part of them that is done."""
    workers = min(len(fleet), cores or _cores(fleet))
    results: Iterator[Found]
    jobs = [(member, model, settings, estimators) for member in fleet]
    if workers == 1:
        results = (_observe(*job) for job in jobs)
        return list(_ticking(results, len(fleet), tick))
    with ProcessPoolExecutor(workers, get_context("forkserver")) as pool:
        asked = [pool.submit(_observe, *job) for job in jobs]
        results = (_result(one.result, job) for one, job in zip(asked, jobs, strict=True))
        return list(_ticking(results, len(fleet), tick))


def _cores(fleet: Sequence[Member]) -> int:
    """How many processes to share the logs among."""
    if sum(member.path.stat().st_size for member in fleet if member.path.is_file()) < WORTH_SHARING:
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _ticking(results: Iterator[Found], count: int, tick: Callable[[float], None]) -> Iterator[Found]:
    for done, found in enumerate(results, start=1):
        tick(done / count)
        yield found


def _result(result: Callable[[], Found], job: Job) -> Found:
    """What a process has found. One that is ended from outside, as where memory is short, takes the others' results along: each that is
    lost so is tried once more by itself."""
    with contextlib.suppress(BrokenProcessPool):
        return result()
    with ProcessPoolExecutor(1, get_context("forkserver")) as alone:
        try:
            return alone.submit(_observe, *job).result()
        except BrokenProcessPool:
            return _unread(job[0], job[2], "the process that read it was ended")


def _observe(member: Member, model: Model, settings: Settings, estimators: Estimators) -> Found:
    """In a process of its own: one log, none of its samples kept."""
    try:
        one = OneLog(member.path, model, settings, member.name, estimators)
        for _ in one.parts():
            pass
        out = one.outcome()
        return Found(member, Origin(out.unit, out.date), out)
    except FrictoolError as error:
        return _unread(member, settings, str(error).removeprefix(f"{member.path}: "))
    except MemoryError:
        return _unread(member, settings, "needs more memory than there is")
    except OSError as error:
        return _unread(member, settings, f"cannot be read: {error.strerror or error}")
    except Exception as error:  # a mistake of ours with one log must not take the others along
        return _unread(member, settings, f"could not be observed ({type(error).__name__}: {error}); observe it alone to see more")


def _unread(member: Member, settings: Settings, reason: str) -> Found:
    return Found(member, origin_by_name(member.name, settings.patterns), None, reason)
