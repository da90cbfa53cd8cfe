"""Jobs that read a file, and workers that may not see it: the file is read at its path where the same bytes are there, and sent where not.

    (path, job) ──▶ worker: at the path, by size and SHA-256? ──yes──▶ function(path, job)
                                     └─no─▶ asked for ──▶ its bytes come along ──▶ function(a copy, job)

So a shared file system is used where there is one, and not needed. Copies are kept while they are read.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from frictool.workers.share import share

Job = TypeVar("Job")
Result = TypeVar("Result")
LARGEST_SENT = 256_000_000  # bytes: a task passes through the scheduler's memory
JOURNAL = "-wal"  # a database's, which lies beside it and belongs to it


@dataclass(frozen=True)
class Sent:
    """A file, or a folder of files, as it is here. parts: relative name and SHA-256 of each. content: their bytes, where they are sent."""

    path: Path
    parts: tuple[tuple[str, str], ...]
    size: int
    content: tuple[bytes, ...] = ()


@dataclass(frozen=True)
class NotThere:
    """In place of a result: the worker has not the same file at its path."""


@dataclass(frozen=True)
class _There(Generic[Job, Result]):
    """What a worker runs: the function on the file that is there, or on a copy of what was sent."""

    function: Callable[[Path, Job], Result]

    def __call__(self, job: tuple[Sent, Job]) -> Result | NotThere:
        sent, own = job
        if sent.content:
            with _copy(sent) as path:
                return self.function(path, own)
        if not is_here(sent):
            return NotThere()
        return self.function(sent.path, own)


@dataclass(frozen=True)
class _Here(Generic[Job, Result]):
    """The same on this machine."""

    function: Callable[[Path, Job], Result]

    def __call__(self, job: tuple[Path, Job]) -> Result:
        return self.function(*job)


def share_files(
    function: Callable[[Path, Job], Result],
    jobs: Sequence[tuple[Path, Job]],
    instead: Callable[[Job, str], Result],
    *,
    cores: int | None = None,
    cluster: str | None = None,
) -> Iterator[tuple[int, Result]]:
    """As `share` of jobs that read a file each; the function is told where it is.

    instead: the result of a job that ended each process that was at it, or whose file can neither be read there nor be sent.
    Raises ClusterError where the cluster cannot be used, OSError where a file cannot be read here.
    """
    if cluster is None:
        yield from share(_Here(function), jobs, cores=cores, instead=lambda job, why: instead(job[1], why))
        return
    yield from _by_description(function, jobs, instead, cluster)


def _by_description(
    function: Callable[[Path, Job], Result], jobs: Sequence[tuple[Path, Job]], instead: Callable[[Job, str], Result], cluster: str
) -> Iterator[tuple[int, Result]]:
    """First what each file is, then the bytes of those that a worker has not."""
    places: list[int] = []
    described: list[Sent] = []

    def offered() -> Iterator[tuple[Sent, Job]]:
        for index, (path, job) in enumerate(jobs):
            if os.access(path, os.R_OK):
                places.append(index)
                described.append(described_file(path))
                yield described[-1], job

    def lost(job: tuple[Sent, Job], why: str) -> Result | NotThere:
        return instead(job[1], why)

    asked: list[int] = []
    for number, result in share(_There(function), offered(), cluster=cluster, instead=lost):
        if isinstance(result, NotThere):
            asked.append(number)
        else:
            yield places[number], result
    sendable = [number for number in sorted(asked) if described[number].size <= LARGEST_SENT]
    if sendable:
        sent = ((with_content(described[number]), jobs[places[number]][1]) for number in sendable)
        for turn, result in share(_There(function), sent, cluster=cluster, instead=lost):
            assert not isinstance(result, NotThere)
            yield places[sendable[turn]], result
    for number in set(asked) - set(sendable):
        yield places[number], instead(jobs[places[number]][1], _too_large(described[number]))
    for index in set(range(len(jobs))) - set(places):  # the function tells best what is wrong with it
        yield index, function(*jobs[index])


def _too_large(sent: Sent) -> str:
    return (
        f"is not at its path on the worker, and {sent.size / 1e6:.0f} MB are not sent (allowed: {LARGEST_SENT / 1e6:.0f}); "
        "put it where the workers see it under the same path"
    )


def described_file(path: Path) -> Sent:
    """What tells whether another machine has the same. Raises OSError where it cannot be read."""
    at = path.absolute()
    names = _names(at)
    parts = tuple((name, _digest(at.parent / name)) for name in names)
    return Sent(at, parts, sum((at.parent / name).stat().st_size for name in names))


def with_content(sent: Sent) -> Sent:
    """The same with the bytes as they are now."""
    return Sent(sent.path, sent.parts, sent.size, tuple((sent.path.parent / name).read_bytes() for name, _ in sent.parts))


def is_here(sent: Sent) -> bool:
    """Whether the same bytes are at the path on this machine."""
    try:
        return described_file(sent.path) == sent
    except OSError:
        return False


def _names(path: Path) -> list[str]:
    """The files that are at a path, relative to its folder: itself and its journal, or those below."""
    if path.is_dir():
        return sorted(one.relative_to(path.parent).as_posix() for one in path.rglob("*") if one.is_file())
    return [one.name for one in (path, path.with_name(f"{path.name}{JOURNAL}")) if one.is_file()]


def _digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


@contextmanager
def _copy(sent: Sent) -> Iterator[Path]:
    """The path of a copy under the same name."""
    with tempfile.TemporaryDirectory(prefix="frictool-") as folder:
        for (name, _), content in zip(sent.parts, sent.content, strict=True):
            target = Path(folder, name)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
        yield Path(folder, sent.path.name)
